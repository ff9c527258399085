"""Keep the feet where they stand: place the hips between them and bend the legs to reach them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import rotations_from_vectors, vectors_from_rotations
from topview_lab.sim.actions import Act, Foot, Side, Style, smooth_step, standing
from topview_lab.sim.actions.act import SIDES
from topview_lab.sim.actions.jumps import TOE_SHARE
from topview_lab.sim.anthropometry import SOLE_SHARE
from topview_lab.sim.bodies import Body
from topview_lab.sim.limbs import end_angles, limb_angles, two_bones
from topview_lab.sim.skeleton import (
    SEGMENT_INDEX,
    Pose,
    angles_array,
    heading_rotation,
    segment_poses,
    segment_rotation,
)

Array = NDArray[np.float64]

UP: Final = np.array([0.0, 1.0, 0.0])  # of a body
BALANCE: Final = 0.35
"""How far the hips move against a lean of the shoulders, to keep the balance: about the share of
the body's mass in trunk, head and arms (Winter 2009, Table 4.1) times its relative height."""
LEG_STRETCH: Final = 0.998
"""The hips sink where a leg would need more than this share of its length (ours)."""
SOFT_M: Final = 0.002
"""Width of that transition (ours)."""
STEP_SHARE: Final = 0.25
"""Lift of a foot that steps, as a share of the step's length (ours)."""


@dataclass(frozen=True, slots=True)
class StanceTargets:
    """Where hips and feet shall be: the weighted sum of all acts of a moment, fields as in
    `Act`."""

    hips: Array
    turn_deg: float
    feet: dict[Side, Foot]
    support: float


def stance_targets(acts: list[tuple[float, Act]]) -> StanceTargets:
    """The weighted sum of acts; feet step to places that fade in."""
    feet: dict[Side, Foot] = {}
    for side in SIDES:
        left = up = front = heel = turn = 0.0
        for shown, act in acts:
            foot = act.feet.get(side, Foot())
            weight = smooth_step(2.0 * shown - (side == "r"))  # the left foot steps first
            away = np.hypot(foot.left, foot.front)
            left, front = left + weight * foot.left, front + weight * foot.front
            up += weight * foot.up + 4.0 * weight * (1.0 - weight) * STEP_SHARE * float(away)
            heel, turn = heel + weight * foot.heel_deg, turn + weight * foot.turn_deg
        feet[side] = Foot(left, up, front, heel, turn)
    return StanceTargets(
        hips=sum((weight * np.array(act.hips) for weight, act in acts), np.zeros(3)),
        turn_deg=sum(weight * act.turn_deg for weight, act in acts),
        feet=feet,
        support=max((weight * act.support for weight, act in acts), default=0.0),
    )


@dataclass(frozen=True, slots=True, eq=False)
class RestStance:
    """How a body stands at rest, in a frame on the floor below the middle of its hips.

    Attributes:
        root_m: height of the hip centres.
        neck_m: [3] the neck from the hip centres.
        tips_m: [3] tip of each foot.
        toe_out: [3, 3] rotation of each foot.
    """

    root_m: float
    neck_m: Array
    tips_m: dict[Side, Array]
    toe_out: dict[Side, Array]


def _tip(body: Body) -> Array:
    return body.appearance.stature_m * np.array([0.0, -SOLE_SHARE, TOE_SHARE])


@lru_cache(maxsize=64)
def rest_stance(body: Body, style: Style) -> RestStance:
    """The resting stance of a body, without drifts."""
    quiet = replace(style, waves=np.zeros_like(style.waves))
    Ts = segment_poses(body.offsets_m, Pose(np.zeros(3), 0.0, angles_array(standing(quiet, 0.0))))
    R = heading_rotation(0.0)
    tips, toe_out, ankles = {}, {}, []
    for side in SIDES:
        T = Ts[SEGMENT_INDEX[f"foot_{side}"]]
        ankle, front = R.T @ T[:3, 3], R.T @ T[:3, 2]
        ankles.append(ankle[1])
        toe_out[side] = rotations_from_vectors(np.arctan2(front[0], front[2]) * UP)
        floor_ankle = np.array([ankle[0], SOLE_SHARE * body.appearance.stature_m, ankle[2]])
        tips[side] = floor_ankle + toe_out[side] @ _tip(body)
    neck = R.T @ Ts[SEGMENT_INDEX["neck"], :3, 3]
    return RestStance(
        SOLE_SHARE * body.appearance.stature_m - float(np.mean(ankles)), neck, tips, toe_out
    )


def plant(
    body: Body, style: Style, free: Pose, wish: StanceTargets, weight: float
) -> tuple[Array, Array]:
    """Root and joint angles with the feet on their places.

    Args:
        body, style: of the person.
        free: the pose that the joint angles alone give; its root lies over the middle of the
            places of the feet.
        wish: what hips and feet shall do.
        weight: of the result against the free pose, 0 for a person who walks.

    Returns:
        [3] root in the room, metres, and [S, 3] angles, radians.
    """
    ease, stature = rest_stance(body, style), body.appearance.stature_m
    R_room_body = heading_rotation(free.heading_rad)
    Ts = segment_poses(body.offsets_m, free)
    R_room_pelvis = Ts[SEGMENT_INDEX["pelvis"], :3, :3]
    lean = R_room_body.T @ (Ts[SEGMENT_INDEX["neck"], :3, 3] - free.root_room) - ease.neck_m
    hips = stature * wish.hips - BALANCE * (1.0 - wish.support) * lean * (1.0, 0.0, 1.0)
    root = R_room_body @ hips
    root[:2] += free.root_room[:2]
    root[2] += ease.root_m

    spot = np.array([*free.root_room[:2], 0.0])
    ankles: dict[Side, Array] = {}
    soles: dict[Side, Array] = {}
    knees: dict[Side, Array] = {}
    for side in SIDES:
        foot = wish.feet[side]
        turned, heel = rotations_from_vectors(
            np.radians([[0.0, foot.turn_deg, 0.0], [foot.heel_deg, 0.0, 0.0]])
        )
        flat = R_room_body @ turned @ ease.toe_out[side]
        soles[side], knees[side] = flat @ heel, flat[:, 2]
        tip = ease.tips_m[side] + stature * np.array([foot.left, foot.up, foot.front])
        ankles[side] = spot + R_room_body @ turned @ tip - soles[side] @ _tip(body)
        if weight < 1.0:
            thigh, end = (Ts[SEGMENT_INDEX[f"{name}_{side}"]] for name in ("thigh", "foot"))
            ankles[side] = end[:3, 3] + weight * (ankles[side] - end[:3, 3])
            way = vectors_from_rotations(soles[side] @ end[:3, :3].T)
            soles[side] = rotations_from_vectors(weight * way) @ end[:3, :3]
            knees[side] = thigh[:3, 2] + weight * (knees[side] - thigh[:3, 2])
    root = free.root_room + weight * (root - free.root_room)

    joints = {s: R_room_pelvis @ body.offsets_m[SEGMENT_INDEX[f"thigh_{s}"]] for s in SIDES}
    root[2] -= weight * _sink(body, {s: root + joints[s] - ankles[s] for s in SIDES})
    angles = free.angles_rad.copy()
    for side in SIDES:
        start = root + joints[side]
        _bend_leg(body, side, R_room_pelvis, ankles[side] - start, soles[side], knees[side], angles)
    return root, angles


def _leg(body: Body, side: Side) -> tuple[float, float]:
    """Lengths of thigh and calf."""
    thigh, calf = (body.offsets_m[SEGMENT_INDEX[f"{name}_{side}"]] for name in ("calf", "foot"))
    return float(np.linalg.norm(thigh)), float(np.linalg.norm(calf))


def _sink(body: Body, hips_over_ankles: dict[Side, Array]) -> float:
    """Metres by which the hips must sink so that both legs reach their feet."""
    excess = [0.0]
    for side, (x, y, z) in hips_over_ankles.items():
        longest = LEG_STRETCH * sum(_leg(body, side))
        excess.append(z - float(np.sqrt(max(longest**2 - x * x - y * y, 0.0))))
    return float(SOFT_M * np.logaddexp.reduce(np.array(excess) / SOFT_M))


def _bend_leg(
    body: Body,
    side: Side,
    R_room_pelvis: Array,
    hip_to_ankle: Array,
    R_room_foot: Array,
    knee: Array,
    angles: Array,
) -> None:
    """Write the angles of a leg that reaches its ankle with the foot in a given rotation."""
    thigh, calf, foot = (f"{name}_{side}" for name in ("thigh", "calf", "foot"))
    bones = two_bones(np.zeros(3), hip_to_ankle, _leg(body, side), knee)
    upper, flexion = limb_angles(thigh, R_room_pelvis, bones)
    angles[SEGMENT_INDEX[thigh]] = upper
    angles[SEGMENT_INDEX[calf]] = (flexion, 0.0, 0.0)
    R_room_calf = R_room_pelvis @ segment_rotation(thigh, upper)
    R_room_calf = R_room_calf @ segment_rotation(calf, angles[SEGMENT_INDEX[calf]])
    angles[SEGMENT_INDEX[foot]] = end_angles(foot, R_room_calf.T @ R_room_foot)
