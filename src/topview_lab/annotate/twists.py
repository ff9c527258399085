"""Resolve the twist of limbs: which of a joint's two markers is the visible one.

A twisting arm shows both cameras the same marker, or each the other's. The tracked names of limb
markers are therefore not trusted. The twists that best explain the whole recording are found by
dynamic programming (A. Viterbi, IEEE Trans. Inf. Theory 13, 1967). Markers
lie across the bone and face the cameras that see them, bones keep their lengths, elbows and knees
bend to one side only, and limbs twist slowly. Hands are as thin as markers, so that theirs are
visible from behind too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import unit
from topview_lab.annotate.landmarks import BACK, FOLLOWS, FRONT, INDEX, PARENTS, PLACES
from topview_lab.annotate.tracks import mean_of_views, rotate_least, trunk_axes

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TWIST_STEPS: Final = 36
"""Discrete twists over a full turn (ours)."""
SWEEPS: Final = 2
"""Passes over all joints, each of which depends on its neighbours (ours)."""
LEAST_FRAMES: Final = 5
"""Least number of frames with both ends of a bone measured, to estimate its length (ours)."""
ONE_SPOT: Final = 0.5
"""Two markers closer than this share of a joint's depth are one that got both names (ours)."""
ARM: Final = ("shoulder", "elbow", "hand")
LEG: Final = ("hip", "knee", "ankle")
LIMB_JOINTS: Final = [
    INDEX[f"{name}_{side}"] for side in ("l", "r") for name in (*ARM, "knee", "ankle")
]
HANDS: Final = (INDEX["hand_l"], INDEX["hand_r"])
STRAIGHT_LIMB_SINE, BENT_LIMB_SINE = 0.35, 0.75
"""Sines of the bends at which a limb's twist begins to be observable, and is well observable
(ours)."""

# What makes a twist likely; all ours. Costs are squares of standard deviations.
TWIST_SIGMA_DEG_PER_S: Final = 360.0
"""Standard deviation of the rate of twist."""
ACROSS_SIGMA_DEG: Final = 20.0
"""Standard deviation of the direction between a joint's two markers from its twist."""
LEAST_MARKER_FACING: Final = 0.3
"""Cosine between a marker's outward direction and the line to a camera that sees it; a lower one
is less likely."""
FACING_SIGMA: Final = 0.25
"""Standard deviation of that cosine."""
BONE_SIGMA_M: Final = 0.015
"""Standard deviation of a measured bone length."""
OTHER_NAME_COST: Final = 0.1
"""Cost of a marker that was tracked as the other side's."""
BENT_COST: Final = 2.0
"""Cost of a twist at right angles to the one that a well bent elbow or knee shows."""
MOST_COST: Final = 12.0
"""Greatest cost of one frame's observation."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkerObservations:
    """The observed markers of a joint in F frames.

    Attributes:
        front, back: [F, 3] the markers by tracked name, metres, NaN where unseen.
        both: [F] True where two distinct markers are visible.
        one: [F] True where exactly one is visible, whatever its name.
        spot: [F, 3] that one.
        name: [F] +1 if it was tracked as the front marker, -1 as the back marker, 0 as both.
        seen_by: [V, F] which views see any.
    """

    front: Array
    back: Array
    both: Mask
    one: Mask
    spot: Array
    name: Array
    seen_by: Mask

    @classmethod
    def of(cls, points: Array, depth_m: float) -> MarkerObservations:
        """Of [V, F, 2, 3] markers, NaN where unseen."""
        front, back = (side[:, 0] for side in mean_of_views(points[:, :, None]))
        has_front, has_back = (~np.isnan(side[:, 0]) for side in (front, back))
        apart = np.linalg.norm(front - back, axis=-1)
        both = has_front & has_back & ~(apart < ONE_SPOT * depth_m)
        sides = np.nan_to_num(np.stack([front, back]))
        count = np.maximum(has_front.astype(int) + has_back, 1)[:, None]
        return cls(
            front=front,
            back=back,
            both=both,
            one=(has_front | has_back) & ~both,
            spot=sides.sum(0) / count,
            name=has_front.astype(float) - has_back,
            seen_by=np.logical_not(np.isnan(points[..., 0]).all(-1)),
        )


def resolve_twists(
    points: Array,
    eyes: Array,
    joints: Array,
    measured: Mask,
    depths_m: Array,
    fps: float,
) -> tuple[Array, Mask]:
    """One person's joints, those of the limbs placed by the likeliest twists, and which of them two
    markers determine.

    Args:
        points: [V, F, J, 2, 3] markers, NaN where unseen; all in metres, one camera's frame.
        eyes: [V, 3] positions of the cameras.
        joints: [F, J, 3] initial estimate, none missing.
        measured: [F, J] True where two markers determine the joint.
        depths_m: [J] from the front to the back marker.
        fps: frames per second.
    """
    joints, measured = joints.copy(), measured.copy()
    sights = {j: MarkerObservations.of(points[:, :, j], depths_m[j]) for j in LIMB_JOINTS}
    steps = np.arange(TWIST_STEPS)
    step_deg = (
        360.0
        / TWIST_STEPS
        * np.abs((steps[:, None] - steps + TWIST_STEPS // 2) % TWIST_STEPS - TWIST_STEPS // 2)
    )
    turns = (step_deg * fps / TWIST_SIGMA_DEG_PER_S) ** 2
    for j in LIMB_JOINTS * SWEEPS:
        sight = sights[j]
        reach_m = PLACES[j] * depths_m[j], (1.0 - PLACES[j]) * depths_m[j]
        axes = across_bone(joints, j)
        outwards = _around(axes, steps * (2.0 * np.pi / TWIST_STEPS))
        one, is_front = _costs_of_one(sight, eyes, outwards, reach_m, joints, measured, j)
        costs = _costs_of_two(sight, outwards)
        costs[sight.one] = np.minimum(one, MOST_COST)[sight.one]
        bent, trust = fronts_of_bent_limbs(joints)
        costs += BENT_COST * trust[:, j] * (1.0 - np.einsum("fki,fi->fk", outwards, bent[:, j]))
        path = cheapest_path(costs, turns)
        outward = _between_steps(sight, axes, path)
        is_front = is_front[np.arange(len(path)), path]
        inwards = np.where(is_front, -reach_m[FRONT], reach_m[BACK])[:, None] * outward
        joints[sight.one, j] = (sight.spot + inwards)[sight.one]
        swapped = ((sight.front - sight.back) * outward).sum(-1) < 0.0
        share = np.where(swapped, 1.0 - PLACES[j], PLACES[j])[:, None]
        two = sight.front + share * (sight.back - sight.front)
        joints[sight.both, j] = two[sight.both]
        measured[:, j] = sight.both
    return joints, measured


def _around(axes: Array, angles_rad: NDArray[np.floating]) -> Array:
    """[F, K, 3] units at angles [K] or [F, K] from the first of [F, 2, 3] axes to the second."""
    return (
        np.cos(angles_rad)[..., None] * axes[:, None, 0]
        + np.sin(angles_rad)[..., None] * axes[:, None, 1]
    )


def _between_steps(sight: MarkerObservations, axes: Array, path: NDArray[np.intp]) -> Array:
    """[F, 3] directions to the front marker along a path of discrete twists, refined between the
    steps by the nearest frames with two visible markers."""
    step_rad = 2.0 * np.pi / TWIST_STEPS
    frames = np.arange(len(path))
    two = frames[sight.both]
    off = np.zeros(len(path))
    if len(two):
        gap = (sight.front - sight.back)[two]
        x, y = (np.einsum("fi,fi->f", gap, axes[two, k]) for k in range(2))
        # Front and back may have each other's names: half a turn more or less is no difference.
        more = (np.arctan2(y, x) - path[two] * step_rad + np.pi / 2) % np.pi - np.pi / 2
        off = np.interp(frames, two, np.clip(more, -step_rad / 2, step_rad / 2))
    return _around(axes, (path * step_rad + off)[:, None])[:, 0]


def across_bone(joints: Array, j: int) -> Array:
    """[F, 2, 3] two units across the bone at joint j, of [F, J, 3] joints. From frame to frame
    they turn with the trunk and with the bone, and not about it."""
    bone = unit(joints[:, FOLLOWS[j]] - joints[:, j])
    least = np.eye(3)[np.abs(bone).argmin(-1)]
    first = unit(np.cross(bone, least))
    second = np.cross(bone, first)
    trunk = trunk_axes(joints)
    R = trunk[1:] @ np.swapaxes(trunk[:-1], -1, -2)
    before, carried = (np.einsum("fij,fj->fi", R, units[:-1]) for units in (bone, first))
    carried = rotate_least(before, bone[1:], carried)
    off = np.arctan2((carried * second[1:]).sum(-1), (carried * first[1:]).sum(-1))
    total = np.concatenate([[0.0], np.cumsum(off)])[:, None]
    cosine, sine = np.cos(total), np.sin(total)
    return np.stack([cosine * first + sine * second, cosine * second - sine * first], 1)


def _costs_of_two(sight: MarkerObservations, outwards: Array) -> Array:
    """[F, K] of directions [F, K, 3] to the front marker where two markers are seen, else 0."""
    gap = sight.front - sight.back
    cosine = np.einsum("fki,fi->fk", outwards, unit(np.nan_to_num(gap)))
    off_deg = np.degrees(np.arccos(np.clip(np.abs(cosine), 0.0, 1.0)))
    costs = (off_deg / ACROSS_SIGMA_DEG) ** 2 + OTHER_NAME_COST * (cosine < 0.0)
    return np.where(sight.both[:, None], np.minimum(costs, MOST_COST), 0.0)


def _costs_of_one(
    sight: MarkerObservations,
    eyes: Array,
    outwards: Array,
    reach_m: tuple[float, float],
    joints: Array,
    measured: Mask,
    j: int,
) -> tuple[Array, Mask]:
    """[F, K] of directions [F, K, 3] to the front marker where one marker is seen, and whether
    that then is the front one."""
    bones = [(k, length) for k in _neighbours(j) if (length := _bone(joints, measured, j, k))]
    sides = []
    for side, sign in ((FRONT, 1.0), (BACK, -1.0)):
        cost = np.where(sight.name == -sign, OTHER_NAME_COST, 0.0)[:, None]
        for eye, seen in zip(eyes, sight.seen_by & (j not in HANDS), strict=True):
            facing = sign * np.einsum("fki,fi->fk", outwards, unit(eye - sight.spot))
            less = np.maximum(LEAST_MARKER_FACING - facing, 0.0) / FACING_SIGMA
            cost = cost + np.where(seen[:, None], less**2, 0.0)
        place = sight.spot[:, None] - sign * reach_m[side] * outwards
        for k, length_m in bones:
            off_m = np.linalg.norm(place - joints[:, None, k], axis=-1) - length_m
            trust = np.where(measured[:, None, k], 1.0, GUESSED)
            cost = cost + trust * (off_m / BONE_SIGMA_M) ** 2
        sides.append(cost)
    return np.minimum(*sides), sides[FRONT] <= sides[BACK]


GUESSED: Final = 0.3
"""Weight of a bone's length whose other end is determined by one marker (ours)."""


def _neighbours(j: int) -> list[int]:
    return [int(PARENTS[j]), *np.flatnonzero(np.equal(PARENTS, j)).tolist()]


def _bone(joints: Array, measured: Mask, j: int, k: int) -> float:
    """Length in metres of the bone from joint j to joint k, 0 where it is not known."""
    seen = measured[:, j] & measured[:, k]
    if seen.sum() < LEAST_FRAMES:
        return 0.0
    return float(np.median(np.linalg.norm(joints[seen, j] - joints[seen, k], axis=-1)))


def cheapest_path(costs: Array, turns: Array) -> NDArray[np.intp]:
    """[F] states of the cheapest path through costs [F, K], with transition costs [K, K]."""
    total, came = costs[0], np.zeros(costs.shape, np.intp)
    for f in range(1, len(costs)):
        ways = total[:, None] + turns
        came[f] = ways.argmin(0)
        total = ways.min(0) + costs[f]
    path = np.empty(len(costs), np.intp)
    path[-1] = total.argmin()
    for f in range(len(costs) - 1, 0, -1):
        path[f - 1] = came[f, path[f]]
    return path


def fronts_of_bent_limbs(joints: Array) -> tuple[Array, Array]:
    """[..., J, 3] units to the front of limb parts and [..., J, 1] how far they can be trusted, of
    [..., J, 3] joints: forearms bend to the front, shins to the back, so that a bent limb shows how
    it is twisted (ours)."""
    fronts, shares = np.zeros(joints.shape), np.zeros((*joints.shape[:-1], 1))
    for names, sign in ((ARM, 1.0), (LEG, -1.0)):
        for side in ("_l", "_r"):
            top, hinge, end = (INDEX[name + side] for name in names)
            upper = unit(joints[..., hinge, :] - joints[..., top, :])
            lower = unit(joints[..., end, :] - joints[..., hinge, :])
            cosine = (upper * lower).sum(-1, keepdims=True)
            bend = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
            share = np.clip(
                (bend - STRAIGHT_LIMB_SINE) / (BENT_LIMB_SINE - STRAIGHT_LIMB_SINE), 0.0, 1.0
            )
            fronts[..., top, :] = sign * unit(lower - cosine * upper)
            fronts[..., hinge, :] = fronts[..., end, :] = -sign * unit(upper - cosine * lower)
            shares[..., [top, hinge, end], :] = share[..., None, :]
    return fronts, shares
