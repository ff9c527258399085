"""Whole bodies looked up by what is seen of them (ours).

A table holds poses of people, each turned in several directions, and what each looks like: which
cells of an upright grid round the head it covers, and how far before or behind the head its surface
lies there, as a few numbers (the principal components of all). What is seen of a person becomes the
same numbers, and the nearest entries are whole-body hypotheses: front and back, left and right, and
arms that lie before the trunk are told by all of the body at once, from one frame alone. All
entries together tell how likely somebody faces which way. In the spirit of Baak et al. 2011 and Ye,
Wang, Yang, Ren, Pollefeys 2011; `topview train-poses` makes the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import as_file, files
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import UPPER_TORSO
from topview.files import read_archive
from topview.filter.turning import N_YAWS, YAWS_RAD, normalised
from topview.geometry.rotations import cross, unit
from topview.kernels.lookup import project, squared_distances
from topview.records import read_only
from topview.track.evidence import Evidence
from topview.track.pose import Pose
from topview.track.stances import heading

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

# All ours. The grid, in shares of the stature: upright, across the line of sight, the head's centre
# at the origin; x to the right, y down.
CELL: Final = 0.035
GRID_COLUMNS, GRID_ROWS = 32, 40
LEFT, TOP = -0.56, -0.385
DEPTH_CAP: Final = 0.4  # of the stature, before or behind the head
DEPTH_WEIGHT: Final = 2.5  # per stature, against a covered cell
FULL: Final = 0.8  # share of its pixels from which a cell counts as covered
UNIT_QUANTUM: Final = 127.0  # of directions that are kept in 8 bits

HIDDEN_BEHIND: Final = (
    0.15  # of the stature: what is farther before the head than this hides the body
)

POSES_FILE: Final = "data/poses.npz"
SHARES: Final = 4  # of the table, of which one is looked through at a time
EXAMINED: Final = 100  # nearest entries of which different ones are chosen
DIFFERENT: Final = 0.035  # of the stature: joints of entries that count as different, on average
# So much less likely, as a power of e, is a pose that is farther by 1, in squares: true yaws are
# likeliest with 0.7 for rendered people and 1.0 for UTD-MHAD, and less so by 1 % and 5 % with this,
# which tells fronts from backs more often (`scripts/fit_likeness.py`).
LIKE_BY_SQUARE: Final = 0.5
UNLIKE_SHARE: Final = 0.05  # of frames, in which the table tells no yaw
FACING_GRID: Final = np.diag([-1.0, 1.0, -1.0])  # rotation of who faces the camera, in its axes


def descriptors(covered: Floats, depth: Floats) -> Floats:
    """[N, rows, columns] the share of each cell that a body covers, and its depth behind the head
    there in shares of the stature, to [N, F] what is compared. Both are blurred by a cell."""
    ahead = np.clip(depth, -DEPTH_CAP, DEPTH_CAP) * DEPTH_WEIGHT
    maps = np.stack([covered, covered * ahead], axis=1)
    maps = np.pad(maps, ((0, 0), (0, 0), (1, 1), (1, 1)))
    maps = 0.25 * (maps[:, :, :-2] + maps[:, :, 2:]) + 0.5 * maps[:, :, 1:-1]
    maps = 0.25 * (maps[..., :-2] + maps[..., 2:]) + 0.5 * maps[..., 1:-1]
    return np.ascontiguousarray(maps.reshape(len(maps), -1), np.float32)


def upright_axes(evidence: Evidence) -> Array:
    """[3, 3] rows: the grid's right, down, and level line of sight, in the camera frame."""
    return _upright_axes(*evidence.up_camera.tolist(), *evidence.head_camera.tolist())


@lru_cache(maxsize=64)  # several times a frame for each person
def _upright_axes(*up_and_head: float) -> Array:
    up, head = np.array(up_and_head).reshape(2, 3)
    down = -up
    away = unit(head - (head @ down) * down)
    return read_only(np.stack([cross(down, away), down, away]))


def seen_descriptor(evidence: Evidence, stature_m: float) -> Floats:
    """[F] of what is seen of somebody of this stature."""
    places = (evidence.all_points_camera - evidence.head_camera) @ upright_axes(evidence).T
    places /= stature_m
    columns = np.floor((places[:, 0] - LEFT) / CELL).astype(np.int64)
    rows = np.floor((places[:, 1] - TOP) / CELL).astype(np.int64)
    is_inside = (columns >= 0) & (rows >= 0) & (columns < GRID_COLUMNS) & (rows < GRID_ROWS)
    cells = (rows * GRID_COLUMNS + columns)[is_inside]
    count = np.bincount(cells, minlength=GRID_ROWS * GRID_COLUMNS)
    depth = np.bincount(cells, places[is_inside, 2], minlength=GRID_ROWS * GRID_COLUMNS)
    view, head = evidence.view, evidence.head_camera
    pixels = (CELL * stature_m) ** 2 * view.fx * view.fy / float(head @ head)
    covered = np.minimum(count / (FULL * pixels), 1.0)
    depth = depth / np.maximum(count, 1)  # of none they are whole numbers
    shape = (1, GRID_ROWS, GRID_COLUMNS)
    return descriptors(
        covered.reshape(shape).astype(np.float32), depth.reshape(shape).astype(np.float32)
    )[0]


def hidden_cells(evidence: Evidence, stature_m: float) -> NDArray[np.bool_]:
    """[F] which of a descriptor's cells are outside of the image, or behind somebody or something
    else."""
    across = LEFT + CELL * (np.arange(GRID_COLUMNS) + 0.5)
    down = TOP + CELL * (np.arange(GRID_ROWS) + 0.5)
    places = np.zeros((GRID_ROWS, GRID_COLUMNS, 3))
    places[..., 0], places[..., 1] = across, down[:, None]
    places = stature_m * places.reshape(-1, 3) @ upright_axes(evidence) + evidence.head_camera
    is_hidden = evidence.out_of_sight(places, HIDDEN_BEHIND * stature_m)
    return np.tile(is_hidden, 2)


def turned(yaws_rad: Array) -> Array:
    """[N] yaws to [N, 3, 3] turns about the vertical, in the grid's axes."""
    c, s = np.cos(yaws_rad), np.sin(yaws_rad)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, zero, s], [zero, one, zero], [-s, zero, c]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def packed(Rs: Array) -> NDArray[np.int8]:
    """[..., 3, 3] rotations to [..., 2, 3] their first two columns in 8 bits."""
    return np.round(np.swapaxes(Rs, -1, -2)[..., :2, :] * UNIT_QUANTUM).astype(np.int8)


def unpacked(columns: NDArray[np.int8]) -> Array:
    """Inverse of `packed`, but for what 8 bits leave out."""
    y = unit(columns[..., 1, :].astype(np.float64))
    x = columns[..., 0, :].astype(np.float64)
    x = unit(x - (x * y).sum(-1, keepdims=True) * y)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class PoseTable:
    """Poses of people, and what they look like.

    Attributes:
        Rs: [P, 11, 3, 3] rotations of the parts in the grid's axes, facing the camera.
        yaws_rad: [P, Y] by which each is turned.
        mean: [F] of all descriptors.
        axes: [F, C] their principal axes.
        components: of each share of the table [C, N], of each turned pose.
        entries: of each share [N], which turned poses it holds.
        yaw_bins: [P Y] which of `YAWS_RAD` each turned pose's torso faces, 0 for the camera.
    """

    Rs: Array
    yaws_rad: Array
    mean: Floats
    axes: Floats
    components: tuple[Floats, ...]
    entries: tuple[NDArray[np.int64], ...]
    yaw_bins: NDArray[np.int64]

    def likeness(self, evidence: Evidence, stature_m: float, share: int | None = None) -> Likeness:
        """How like what is seen of somebody of this stature the turned poses are; those of one
        share of the table, 0 to `SHARES` - 1, or of all of it. What is hidden tells nothing."""
        shares = range(SHARES) if share is None else [share]
        seen = seen_descriptor(evidence, stature_m) - self.mean
        is_hidden = hidden_cells(evidence, stature_m)
        C = self.axes.shape[1]
        gram, place = np.empty((C, C), np.float32), np.empty(C, np.float32)
        project(seen, is_hidden, self.axes, gram, place)
        found = [np.empty(len(self.entries[own]), np.float32) for own in shares]
        for own, squares in zip(shares, found, strict=True):
            squared_distances(self.components[own], gram, place, squares)
        entries = np.concatenate([self.entries[own] for own in shares])
        return Likeness(self, evidence, entries, np.concatenate(found))


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """How like what is seen of somebody the turned poses of a table are.

    Attributes:
        table: the table.
        evidence: of the frame.
        entries: [N] which turned poses were compared.
        distances: [N] how far each is from what is seen, in squares, up to a constant.
    """

    table: PoseTable
    evidence: Evidence
    entries: NDArray[np.int64]
    distances: Floats

    def poses(self, model: BodyModel, count: int) -> list[Pose]:
        """Up to `count` different poses of a body that are most like what is seen, the likest
        first."""
        nearest = np.argpartition(self.distances, EXAMINED)[:EXAMINED]
        nearest = self.entries[nearest[np.argsort(self.distances[nearest], kind="stable")]]
        poses = self._below_head(nearest, model)
        ends = poses.ends(model)
        chosen: list[int] = []
        is_left = np.ones(len(nearest), np.bool_)
        while is_left.any() and len(chosen) < count:
            chosen.append(int(is_left.argmax()))
            away_m = np.linalg.norm(ends - ends[:, chosen[-1:]], axis=-1).mean(0)
            is_left &= away_m >= DIFFERENT * model.stature_m
        return [
            Pose(poses.neck_camera[index].copy(), np.ascontiguousarray(poses.Rs[:, index]))
            for index in chosen
        ]

    def yaw_log_likelihood(self) -> Array:
        """[N_YAWS] of `YAWS_RAD`; the table may tell nothing."""
        likelihood = self.yaw_likelihood(LIKE_BY_SQUARE)
        return np.log((1.0 - UNLIKE_SHARE) * likelihood + UNLIKE_SHARE / N_YAWS)

    def yaw_likelihood(self, like_by_square: float) -> Array:
        """[N_YAWS] of `YAWS_RAD`, with a sum of 1: the mean over the poses whose torsos face so,
        each of which is less likely by this power of e where it is farther by 1, in squares."""
        squares = self.distances.astype(np.float64)
        weights = np.exp(-like_by_square * (squares - squares.min()))
        bins = self.table.yaw_bins[self.entries]
        total, count = np.bincount(bins, weights, N_YAWS), np.bincount(bins, minlength=N_YAWS)
        R_camera_facing = upright_axes(self.evidence).T @ FACING_GRID
        to_camera_rad = heading(R_camera_facing, self.evidence.up_camera)
        means = total / np.maximum(count, 1)
        return normalised(np.interp(YAWS_RAD - to_camera_rad, YAWS_RAD, means, period=2.0 * np.pi))

    def _below_head(self, entries: NDArray[np.intp], model: BodyModel) -> Pose:
        """Many poses at once, their heads where the person's is."""
        table = self.table
        who = entries // table.yaws_rad.shape[1]
        turn = upright_axes(self.evidence).T @ turned(table.yaws_rad.ravel()[entries])
        Rs = np.swapaxes(turn[:, None] @ table.Rs[who], 0, 1)
        return Pose.below_head(self.evidence.head_camera, Rs, model)


@cache
def shipped_poses() -> PoseTable:
    """The table that comes with the project."""
    with as_file(files("topview.track.methods.topview").joinpath(POSES_FILE)) as path:
        arrays = read_archive(path)
    Rs = unpacked(arrays["rotations"])
    components = arrays["components"] * arrays["component_scale"].astype(np.float32)
    directions = arrays["yaws"].shape[1]
    share_of = np.repeat(np.arange(len(Rs)) % SHARES, directions)
    entries = tuple(np.flatnonzero(share_of == share) for share in range(SHARES))
    mean = arrays["mean"].astype(np.float32)
    yaws_rad = arrays["yaws"].astype(np.float64) * (2.0 * np.pi / 256.0)
    faces_rad = (
        np.array([heading(R, -FACING_GRID[1]) for R in Rs[:, UPPER_TORSO]])[:, None] + yaws_rad
    )
    steps = np.round((faces_rad.ravel() - YAWS_RAD[0]) * (N_YAWS / (2.0 * np.pi)))
    return PoseTable(
        Rs,
        yaws_rad,
        mean,
        arrays["axes"].astype(np.float32),
        tuple(np.ascontiguousarray(components[own].T) for own in entries),
        entries,
        steps.astype(np.int64) % N_YAWS,
    )
