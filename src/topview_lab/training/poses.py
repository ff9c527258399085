"""The table of poses that whole bodies are looked up in, made of captured motion.

It takes an archive of captures as global rotations of bones (`read_captures`). Poses are chosen so
that each next one differs most from those already taken, and become means of those like them, so
that no captured pose itself is kept; more are made by lending them the arms of others, and by
seating them, as few captures sit. Each is drawn in several directions, and what it
looks like is kept as principal components (`topview.track.methods.topview.lookup`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.spatial import KDTree

from topview.body.kinematics import joints_from_parts
from topview.body.parts import (
    HEAD,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_FOREARM,
    UPPER_TORSO,
)
from topview.files import naming, read_archive
from topview.geometry.rotations import nearest_rotations, unit
from topview.records import InputError
from topview.track.bone_lengths import BoneLengths
from topview.track.methods.topview import lookup
from topview.track.pose import HINGE_BENDS, OTHER_SIDE, Pose, mirrored
from topview_lab.kernels.upright import draw_upright

Array = NDArray[np.float64]

LIKE: Final = 12  # captured poses that each one of the table is the mean of
STRAIGHT: Final = 0.25  # sine of the flexion below which a limb does not tell its hinge's axis
FINER: Final = 2  # rows and columns of rays through each cell of the grid
SAMPLED: Final = 8000  # descriptors that the principal axes are of
BODY: Final = BoneLengths().model(1.0)
# The captures' reference pose has the left at +x, up at +y, the front at +z.
_REFERENCE: Final = np.diag([-1.0, -1.0, 1.0])  # of a part, in that frame
_FACING_CAMERA: Final = np.diag([1.0, -1.0, -1.0])  # from that frame to the grid's axes
_TRUNK: Final = {
    HEAD: ("head", "head"),
    UPPER_TORSO: ("chest", "spine"),
    LOWER_TORSO: ("pelvis", "spine"),
}
_LIMBS: Final = {"upperarm": LEFT_UPPER_ARM, "thigh": LEFT_UPPER_LEG}
_BELOW: Final = {"upperarm": "forearm", "thigh": "shank"}
# Degrees, of who sits: hips bend by the first range, each by the spread more or less; legs spread
# by the second, knees bend by the third. Ours.
SEATED_HIPS: Final = (55.0, 105.0)
SEATED_SPREAD: Final = (-8.0, 28.0)
SEATED_KNEES: Final = (55.0, 115.0)
SEATED_SIGMA: Final = 8.0
UPRIGHT: Final = 0.8  # cosine of a trunk's lean, up to which somebody may be seated


@dataclass(frozen=True, slots=True)
class PosesRecipe:
    """What the table holds.

    Attributes:
        captured: poses of the captures.
        lent: poses with the arms of others.
        seated: poses that sit.
        directions: in which each is turned.
        components: of what it looks like.
        seed: of all that is drawn.
    """

    captured: int = 2500
    lent: int = 1500
    seated: int = 800
    directions: int = 8
    components: int = 40
    seed: int = 0


def read_captures(path: Path, left_out: Sequence[str] = ()) -> Array:
    """[F, 11, 3, 3] poses of the body's parts, in the grid's axes, the camera behind.

    Args:
        path: of the archive: `captures` and `lengths` [N], `bones`, `rotations_xyzw` [F, 19, 4] of
            each bone from its reference pose, and `directions` [N, 19, 3] in that.
        left_out: captures that are not taken.

    Raises:
        InputError: something else, a capture to be left out is not there, or nothing is left.
    """
    with naming(path, right="it must be an archive of captures"):
        arrays = read_archive(path)
        missing = {"captures", "lengths", "bones", "rotations_xyzw", "directions"} - arrays.keys()
        if missing:
            raise InputError(f"has no {', '.join(sorted(missing))}")
        unknown = sorted({*left_out} - {*arrays["captures"].tolist()})
        if unknown:
            raise InputError(f"has no capture {', '.join(unknown)} that could be left out")
        capture = np.repeat(np.arange(len(arrays["lengths"])), arrays["lengths"])
        is_used = ~np.isin(arrays["captures"], left_out)[capture]
        if not is_used.any():
            raise InputError("no capture is left")
        bones = {str(name): index for index, name in enumerate(arrays["bones"])}
        rotations = _from_quaternions(arrays["rotations_xyzw"][is_used].astype(np.float64))
        directions = np.einsum(
            "fbij,fbj->fbi", rotations, arrays["directions"][capture[is_used]].astype(np.float64)
        )
    Rs = np.empty((len(rotations), len(PARTS), 3, 3))
    for part, (one, other) in _TRUNK.items():
        both = (rotations[:, bones[one]] + rotations[:, bones[other]]) @ _REFERENCE
        Rs[:, part] = _standing(unit(both[..., 1]), both[..., 0])
    for name, left in _LIMBS.items():
        for side, upper in (("l", left), ("r", OTHER_SIDE[left])):
            above, below = (bones[f"{bone}_{side}"] for bone in (name, _BELOW[name]))
            place_limb(Rs, upper, unit(directions[:, above]), unit(directions[:, below]))
    return _FACING_CAMERA @ Rs


def place_limb(Rs: Array, upper: int, above: Array, below: Array) -> None:
    """Point a limb of poses [N, 11, 3, 3] along [N, 3] directions of its two parts."""
    hinge = HINGE_BENDS[upper] * np.cross(above, below)
    sine = np.linalg.norm(hinge, axis=-1, keepdims=True)
    share = np.minimum(sine / STRAIGHT, 1.0)
    straight = Rs[:, PARTS[upper].parent, :, 0]
    x = hinge * share / np.maximum(sine, 1e-9) + (1.0 - share) * straight
    Rs[:, upper], Rs[:, upper + 1] = _standing(above, x), _standing(below, x)


def facing_camera(Rs: Array) -> Array:
    """[N, 11, 3, 3] poses, turned until the shoulders lie across the line of sight."""
    right = Rs[:, UPPER_TORSO, :, 0]
    return lookup.turned(-np.arctan2(right[:, 2], -right[:, 0]))[:, None] @ Rs


def joints_below_head(Rs: Array) -> Array:
    """[N, 16, 3] of poses [N, 11, 3, 3], from the head's centre, in shares of the stature."""
    poses = (Pose.below_head(np.zeros(3), own, BODY) for own in Rs)
    return np.array([joints_from_parts(BODY, pose.transforms(BODY)) for pose in poses])


def spread_poses(Rs: Array, count: int) -> Array:
    """Up to `count` places among the poses [N, 11, 3, 3], each next one farthest from those already
    taken: the mean of the `LIKE` poses that are nearest to each."""
    joints = joints_below_head(Rs).astype(np.float32)
    distance = np.full(len(joints), np.inf, np.float32)
    taken = [0]
    while len(taken) < min(count, len(joints)):
        off = ((joints - joints[taken[-1]]) ** 2).sum((1, 2))
        distance = np.minimum(distance, off)
        taken.append(int(distance.argmax()))
    nearest = KDTree(joints.reshape(len(joints), -1)).query(
        joints[taken].reshape(len(taken), -1), min(LIKE, len(joints))
    )[1]
    return nearest_rotations(Rs[nearest.reshape(len(taken), -1)].mean(1))


def with_arms_of(Rs: Array, others: Array) -> Array:
    """Poses [N, 11, 3, 3] with the arms that others have."""
    arms = slice(LEFT_UPPER_ARM, RIGHT_FOREARM + 1)
    turn = Rs[:, UPPER_TORSO] @ np.swapaxes(others[:, UPPER_TORSO], -1, -2)
    lent = Rs.copy()
    lent[:, arms] = turn[:, None] @ others[:, arms]
    return lent


def seated(Rs: Array, rng: np.random.Generator) -> Array:
    """Poses [N, 11, 3, 3] that face the camera, with the legs of somebody who sits."""
    Rs, count = Rs.copy(), len(Rs)
    both = rng.uniform(*SEATED_HIPS, count)
    for upper, outwards in ((LEFT_UPPER_LEG, 1.0), (OTHER_SIDE[LEFT_UPPER_LEG], -1.0)):
        hip = both + rng.normal(0.0, SEATED_SIGMA, count)
        aside = rng.uniform(*SEATED_SPREAD, count)
        shank = hip - rng.uniform(*SEATED_KNEES, count)
        above = _swung(hip, outwards * aside)
        below = _swung(shank, outwards * (aside + rng.normal(0.0, SEATED_SIGMA, count)))
        place_limb(Rs, upper, above, below)
    return Rs


def make_table(captured: Array, recipe: PosesRecipe) -> dict[str, NDArray[Any]]:
    """The arrays of `topview.track.methods.topview.lookup.shipped_poses`.

    Args:
        captured: [F, 11, 3, 3] of `read_captures`.
        recipe: what the table holds.
    """
    rng = np.random.default_rng(recipe.seed)
    Rs = facing_camera(captured)
    chosen = spread_poses(np.concatenate([Rs, mirrored(Rs)]), recipe.captured)

    def drawn(poses: Array, count: int) -> Array:
        return poses[rng.integers(0, len(poses), count)]

    upright = chosen[chosen[:, UPPER_TORSO, 1, 1] > UPRIGHT]
    groups = [chosen, with_arms_of(drawn(chosen, recipe.lent), drawn(chosen, recipe.lent))]
    if len(upright):
        sitting = seated(drawn(upright, recipe.seated), rng)
        groups.append(with_arms_of(sitting, drawn(chosen, recipe.seated)))
    rotations = lookup.packed(np.concatenate(groups))
    Rs = lookup.unpacked(rotations)
    steps = np.arange(recipe.directions) + rng.random((len(Rs), recipe.directions))
    yaws = np.floor(steps * (256.0 / recipe.directions)).astype(np.uint8)
    return {"rotations": rotations, "yaws": yaws, **_looks(Rs, yaws, recipe, rng)}


def _looks(
    Rs: Array, yaws: NDArray[np.uint8], recipe: PosesRecipe, rng: np.random.Generator
) -> dict[str, NDArray[Any]]:
    """What the turned poses look like: mean, principal axes, and components in 8 bits."""
    turns = lookup.turned(yaws.astype(np.float64) * (2.0 * np.pi / 256.0))
    seen = np.concatenate(
        [_drawn(turn[:, None] @ own) for turn, own in zip(turns, Rs, strict=True)]
    )
    mean = seen.mean(0)
    sample = seen[rng.permutation(len(seen))[:SAMPLED]] - mean
    last = len(mean) - 1
    _, axes = eigh(sample.T @ sample, subset_by_index=[last - recipe.components + 1, last])
    axes = axes[:, ::-1].astype(np.float16)
    components = (seen - mean) @ axes.astype(np.float32)
    scale = np.abs(components).max(0) / lookup.UNIT_QUANTUM
    return {
        "mean": mean.astype(np.float16),
        "axes": axes,
        "components": np.round(components / scale).astype(np.int8),
        "component_scale": scale.astype(np.float32),
    }


def _drawn(Rs: Array) -> NDArray[np.float32]:
    """[N, F] descriptors of poses [N, 11, 3, 3]."""
    origins = np.array([Pose.below_head(np.zeros(3), own, BODY).origins(BODY) for own in Rs])
    covered = np.empty((len(Rs), lookup.GRID_ROWS, lookup.GRID_COLUMNS), np.float32)
    depth = np.empty_like(covered)
    draw_upright(
        covered, depth, np.ascontiguousarray(Rs), origins, BODY.lengths_m, BODY.shapes_m,
        lookup.LEFT, lookup.TOP, lookup.CELL, FINER,
    )  # fmt: skip
    return lookup.descriptors(covered, depth)


def _swung(forward_deg: Array, aside_deg: Array) -> Array:
    """[N, 3] directions of what hangs, swung to the front and then to the left."""
    forward, aside = np.radians(forward_deg), np.radians(aside_deg)
    return np.stack(
        [np.sin(aside) * np.sin(forward), np.cos(forward), -np.cos(aside) * np.sin(forward)], -1
    )


def _standing(y: Array, x: Array) -> Array:
    """[..., 3, 3] rotations whose y is a unit vector, and x as near to another as it can be."""
    x = unit(x - (x * y).sum(-1, keepdims=True) * y)
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _from_quaternions(xyzw: Array) -> Array:
    """[..., 4] quaternions of any length to [..., 3, 3] rotations."""
    vector, w = unit(xyzw)[..., :3], unit(xyzw)[..., 3, None, None]
    outer = vector[..., :, None] * vector[..., None, :]
    cross = np.zeros((*vector.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[..., i, j], cross[..., j, i] = -vector[..., k], vector[..., k]
    squared = (vector**2).sum(-1)[..., None, None]
    return (w * w - squared) * np.eye(3) + 2.0 * outer + 2.0 * w * cross
