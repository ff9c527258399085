"""Whole bodies looked up by what is seen of them (ours).

A table holds poses of people, each turned in several directions, and what each looks like: which
cells of an upright grid round the head it covers, and how far before or behind the head its surface
lies there, as a few numbers (the principal components of all). What is seen of a person becomes the
same numbers, and the nearest entries are whole-body hypotheses: front and back, left and right, and
arms that lie before the trunk are told by all of the body at once, from one frame alone. In the
spirit of Baak et al. 2011 and Ye, Wang, Yang, Ren, Pollefeys 2011; `topview train-poses` makes the
table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.files import read_archive
from topview.geometry.rotations import unit
from topview.kernels.lookup import project, squared_distances
from topview.track.evidence import Evidence
from topview.track.pose import Pose

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
RARELY: Final = 0.05  # a cell that fewer bodies cover tells nothing by being hidden
EXAMINED: Final = 100  # nearest entries of which different ones are chosen
DIFFERENT: Final = 0.035  # of the stature: joints of entries that count as different, on average


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
    down = -evidence.up_camera
    head = evidence.head_camera
    away = unit(head - (head @ down) * down)
    return np.stack([np.cross(down, away), down, away])


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
    depth /= np.maximum(count, 1)
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
        may_be_covered: [F] cells that bodies cover.
    """

    Rs: Array
    yaws_rad: Array
    mean: Floats
    axes: Floats
    components: tuple[Floats, ...]
    entries: tuple[NDArray[np.int64], ...]
    may_be_covered: NDArray[np.bool_]

    def look_up(
        self, evidence: Evidence, model: BodyModel, count: int, share: int | None = None
    ) -> list[Pose]:
        """Up to `count` different poses that look most like what is seen, the likest first.

        Args:
            evidence: of the frame.
            model: the person's body.
            count: how many.
            share: which share of the table is looked through, 0 to `SHARES` - 1; all of it if None.
        """
        shares = range(SHARES) if share is None else [share]
        distances = self._distances(evidence, model.stature_m, shares)
        entries = np.concatenate([self.entries[own] for own in shares])
        nearest = np.argpartition(distances, EXAMINED)[:EXAMINED]
        nearest = entries[nearest[np.argsort(distances[nearest], kind="stable")]]
        poses = self._poses(nearest, evidence, model)
        ends = poses.origins(model) + poses.Rs[..., 1] * model.lengths_m[:, None, None]
        chosen: list[int] = []
        for index in range(len(nearest)):
            away = ends[:, chosen] - ends[:, index : index + 1]
            if not (np.linalg.norm(away, axis=-1).mean(0) < DIFFERENT * model.stature_m).any():
                chosen.append(index)
            if len(chosen) == count:
                break
        return [
            Pose(poses.neck_camera[index].copy(), np.ascontiguousarray(poses.Rs[:, index]))
            for index in chosen
        ]

    def _distances(self, evidence: Evidence, stature_m: float, shares: Sequence[int]) -> Floats:
        """[N] how far each entry of these shares is from what is seen, up to a constant; what is
        hidden tells nothing."""
        seen = seen_descriptor(evidence, stature_m) - self.mean
        is_hidden = hidden_cells(evidence, stature_m) & self.may_be_covered
        C = self.axes.shape[1]
        gram, place = np.empty((C, C), np.float32), np.empty(C, np.float32)
        project(seen, is_hidden, self.axes, gram, place)
        found = [np.empty(len(self.entries[share]), np.float32) for share in shares]
        for share, squares in zip(shares, found, strict=True):
            squared_distances(self.components[share], gram, place, squares)
        return np.concatenate(found)

    def _poses(self, entries: NDArray[np.intp], evidence: Evidence, model: BodyModel) -> Pose:
        """Many poses at once, their heads where the person's is."""
        who = entries // self.yaws_rad.shape[1]
        turn = upright_axes(evidence).T @ turned(self.yaws_rad.ravel()[entries])
        Rs = np.swapaxes(turn[:, None] @ self.Rs[who], 0, 1)
        return Pose.below_head(evidence.head_camera, Rs, model)


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
    may_be_covered = np.tile(mean[: len(mean) // 2] > RARELY, 2)
    return PoseTable(
        Rs,
        arrays["yaws"].astype(np.float64) * (2.0 * np.pi / 256.0),
        mean,
        arrays["axes"].astype(np.float32),
        tuple(np.ascontiguousarray(components[own].T) for own in entries),
        entries,
        may_be_covered,
    )
