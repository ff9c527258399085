"""Where the outputs' wrists and feet lie on a body that is fitted without them.

A wrist lies on the axis of the forearm, which ends at the palm. A foot, which is its ball, lies
before the ankle in the frame of the lower leg; whoever knows better which way it points says so.
Shares are medians over rendered people.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import joints_from_parts
from topview.body.model import BodyModel
from topview.body.parts import JOINT_NAMES, LEFT_LOWER_LEG, RIGHT_LOWER_LEG
from topview.records import read_only

Array = NDArray[np.float64]

WRIST_SHARE: Final = 0.82  # of the way from the elbow to the palm
FOOT_OUTWARDS, FOOT_FORWARDS = 0.010, 0.089  # shares of the stature, from the ankle

LOWER_LEGS: Final = [LEFT_LOWER_LEG, RIGHT_LOWER_LEG]
ANKLES: Final = [JOINT_NAMES.index(name) for name in ("left_ankle", "right_ankle")]
_ELBOWS: Final = [JOINT_NAMES.index(name) for name in ("left_elbow", "right_elbow")]
_HANDS: Final = [JOINT_NAMES.index(name) for name in ("left_hand", "right_hand")]

FEET_AT_REST: Final = read_only(
    np.array([[-FOOT_OUTWARDS, 0.0, FOOT_FORWARDS], [FOOT_OUTWARDS, 0.0, FOOT_FORWARDS]])
)
"""[2, 3] from the left and the right ankle to the foot, in the frame of the lower leg, in shares of
the stature: how feet stand in the reference pose."""


def output_joints(
    model: BodyModel, Ts_camera_part: Array, feet_leg_m: Array | None = None
) -> Array:
    """[20, 3] `joints_camera` in the order of `OUTPUT_JOINTS`, metres.

    Args:
        model: the body.
        Ts_camera_part: [11, 4, 4], NaN for parts that are not known.
        feet_leg_m: [2, 3] from the left and the right ankle to the foot, in the frame of the lower
            leg, metres; at rest if None.
    """
    if feet_leg_m is None:
        feet_leg_m = FEET_AT_REST * model.stature_m
    joints = joints_from_parts(model, Ts_camera_part)
    return np.concatenate([joints, ends_of(joints, Ts_camera_part, feet_leg_m)])


def ends_of(joints_camera: Array, Ts_camera_part: Array, feet_leg_m: Array) -> Array:
    """[..., 4, 3] `END_JOINTS` of bodies, metres.

    Args:
        joints_camera: [..., 16, 3] their other joints.
        Ts_camera_part: [..., 11, 4, 4].
        feet_leg_m: [..., 2, 3] as of `output_joints`.
    """
    elbows = joints_camera[..., _ELBOWS, :]
    wrists = elbows + WRIST_SHARE * (joints_camera[..., _HANDS, :] - elbows)
    Rs_leg = Ts_camera_part[..., LOWER_LEGS, :3, :3]
    feet = joints_camera[..., ANKLES, :] + np.einsum("...ab,...b->...a", Rs_leg, feet_leg_m)
    return np.concatenate([wrists, feet], axis=-2)
