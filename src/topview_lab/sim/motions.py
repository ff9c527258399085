"""Performances: combine a person's path and actions into one pose per moment."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.sim.actions import (
    ACTIONS,
    Act,
    Hand,
    Moment,
    Side,
    Style,
    standing,
    stepping_round,
    walking,
)
from topview_lab.sim.actions.act import SIDES, Vector
from topview_lab.sim.bodies import Body
from topview_lab.sim.limbs import reaching_angles
from topview_lab.sim.paths import COMFORTABLE_MPS, Path, Route, smooth_step
from topview_lab.sim.skeleton import (
    SEGMENT_INDEX,
    SEGMENT_LIMITS_RAD,
    Pose,
    angles_array,
    heading_rotation,
    segment_poses,
)
from topview_lab.sim.stance import plant, stance_targets

QUICK_STEP_DEG: Final = 90.0
"""The most that a foot turns in one step before or after a walk (ours)."""
RAMP_S: Final = 0.45
"""Duration of fading an action in or out (ours)."""
STRIDE_SHARE: Final = 0.78
"""Stride length over stature at a comfortable speed. With this value the standing foot slides least
(Winter 2009, Ch. 5: about 0.8)."""
STRIDE_POWER: Final = 0.42
"""Stride length grows with this power of the speed (D. Grieve and R. Gear, Ergonomics 9, 1966)."""


@dataclass(frozen=True, slots=True)
class Clip:
    """An action between two moments; it fades in and out within them.

    Attributes:
        action: one of `ACTIONS`.
        start_s, end_s: when.
        side: the leading hand or foot.
        ramp_s: duration of fading in or out.
        seat_m: height of the seat behind the person.
        target_room: what the hands reach for, metres in the room.
    """

    action: str
    start_s: float
    end_s: float
    side: Side = "r"
    ramp_s: float = RAMP_S
    seat_m: float = 0.45
    target_room: Vector | None = None

    def weight(self, time_s: float) -> float:
        """Weight of the action at a time, 0 to 1."""
        return min(
            smooth_step((time_s - self.start_s) / self.ramp_s),
            smooth_step((self.end_s - time_s) / self.ramp_s),
        )

    def act(self, style: Style, stature_m: float, time_s: float) -> Act:
        """Targets of the action at a time of the recording."""
        moment = Moment(
            style=style,
            time_s=time_s - self.start_s,
            remaining_s=self.end_s - time_s,
            stature_m=stature_m,
            seat_m=self.seat_m,
            target_room=self.target_room,
        )
        act = ACTIONS[self.action](moment)
        return act if self.side == "r" else act.mirrored()


@dataclass(frozen=True, slots=True, eq=False)
class Performance:
    """What one person does: a path and the actions on it."""

    path: Path | Route
    clips: tuple[Clip, ...]
    style: Style

    def action_at(self, time_s: float) -> str:
        """The dominant action at a time: a clip's (the last of equals), "walk" or "stand"."""
        shown = [(clip.weight(time_s), k) for k, clip in enumerate(self.clips)]
        weight, k = max(shown, default=(0.0, -1))
        pace = self.path.state_at(time_s).pace
        if weight >= 0.5 and weight >= pace:
            return self.clips[k].action
        return "walk" if pace >= 0.5 else "stand"

    def pose(self, body: Body, time_s: float) -> Pose:
        """The pose at a time: feet in their places, or soles on the floor while walking."""
        style, walked = self.style, self.path.state_at(time_s)
        stature_m = body.appearance.stature_m
        angles = angles_array(standing(style, time_s))
        if walked.pace > 0.0:
            size = (walked.speed_mps / COMFORTABLE_MPS) ** STRIDE_POWER
            phase = walked.distance_m / (size * STRIDE_SHARE * stature_m) + 0.2
            gait = angles_array(walking(style, time_s, phase))
            angles += size * walked.pace * (gait - angles)
        acts = [
            (weight, clip.act(style, stature_m, time_s))
            for clip in self.clips
            if (weight := clip.weight(time_s)) > 0.0
        ]
        for weight, act in acts:
            for name, target in act.angles.items():
                row = angles[SEGMENT_INDEX[name]]
                row += weight * (np.radians(target) - row)
        turn_rad, turned = walked.turn
        steps = Act(feet=stepping_round(float(np.degrees(turn_rad)), turned, QUICK_STEP_DEG))
        wish = stance_targets([*acts, (1.0, steps)])
        heading = walked.heading_rad + np.radians(wish.turn_deg)
        _lift_shoulders(angles)
        angles = _within_limits(angles)
        x, y = walked.position_room
        at_floor = Pose(np.array([x, y, 0.0]), heading, angles)
        sole = _lowest_sole(body, segment_poses(body.offsets_m, at_floor))
        pose = Pose(np.array([x, y, -sole]), heading, angles)
        if walked.pace < 1.0:
            root, angles = plant(body, style, pose, wish, 1.0 - walked.pace)
            pose = Pose(root, heading, _within_limits(angles))
            if walked.pace > 0.0:  # between planted and swinging feet, one at least is down
                sole = _lowest_sole(body, segment_poses(body.offsets_m, pose))
                pose = replace(pose, root_room=root - np.array([0.0, 0.0, max(sole, 0.0)]))
        for weight, act in acts:
            for side in SIDES:
                if side in act.hands:
                    hand = act.hands[side]
                    pose = with_hand(body, pose, walked.position_room, side, hand, weight)
        return pose


def _within_limits(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.clip(angles, SEGMENT_LIMITS_RAD[..., 0], SEGMENT_LIMITS_RAD[..., 1])


def with_hand(
    body: Body,
    pose: Pose,
    position_room: NDArray[np.float64],
    side: Side,
    hand: Hand,
    weight: float,
) -> Pose:
    """The pose with one palm on its way to what it reaches for; a person stands at a position."""
    weight *= hand.weight
    arm, forearm, palm, clavicle = (
        SEGMENT_INDEX[f"{name}_{side}"] for name in ("upper_arm", "forearm", "hand", "clavicle")
    )
    resting = pose.angles_rad.copy()
    resting[clavicle] = 0.0
    elbow = np.array(hand.elbow)
    for _ in range(2):  # the shoulder girdle moves with the arm
        Ts = segment_poses(body.offsets_m, pose)
        at = np.array(hand.at)
        if hand.frame == "chest":
            T = Ts[SEGMENT_INDEX["chest"]]
            at = T[:3, :3] @ (body.appearance.stature_m * at) + T[:3, 3]
        elif hand.frame == "floor":
            at = heading_rotation(pose.heading_rad) @ (body.appearance.stature_m * at)
            at[:2] += position_room
        upper, flexion = reaching_angles(body, Ts, side, at, elbow)
        angles = resting.copy()
        angles[arm] += weight * (upper - angles[arm])
        angles[forearm] += weight * ((flexion, 0.0, np.radians(hand.palm_deg)) - angles[forearm])
        angles[palm] *= 1.0 - weight
        angles[clavicle, 1] = _girdle_rise(angles[arm])
        pose = Pose(pose.root_room, pose.heading_rad, _within_limits(angles))
    return pose


def _girdle_rise(upper_arm_rad: NDArray[np.float64]) -> float:
    """Raised arms take the shoulder girdle with them, about 1 degree for 6 at the side of the
    trunk and more overhead (after V. Inman et al., J. Bone Joint Surg. 26, 1944)."""
    raised = float(np.linalg.norm(upper_arm_rad[:2]))
    return 0.16 * raised**2 / np.pi


def _lift_shoulders(angles: NDArray[np.float64]) -> None:
    for side in SIDES:
        rise = _girdle_rise(angles[SEGMENT_INDEX[f"upper_arm_{side}"]])
        angles[SEGMENT_INDEX[f"clavicle_{side}"], 1] += rise


SOLE_BLEND_M: Final = 0.008
"""Feet closer in height than this share the floor, so that the hips rise and sink smoothly."""


def _lowest_sole(body: Body, Ts_room_segment: NDArray[np.float64]) -> float:
    """Height of the soles' lowest points, a soft minimum over heels and toes of both feet."""
    feet = np.isin(body.start_segments, [SEGMENT_INDEX["foot_l"], SEGMENT_INDEX["foot_r"]])
    lows = body.flesh(Ts_room_segment).lowest()[:, feet].ravel()
    weights = np.exp((lows.min() - lows) / SOLE_BLEND_M)
    return float((weights * lows).sum() / weights.sum())
