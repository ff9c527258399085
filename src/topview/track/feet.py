"""Which way somebody's feet point, by the joints that are proposed over time (ours).

A fitted body ends at the ankles. Where feet are proposed, the way from the fitted ankle to the
proposed foot is averaged in the frame of the lower leg; how feet stand at rest counts as one more
measurement. A foot keeps its length.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.ends import ANKLES, FEET_AT_REST, LOWER_LEGS
from topview.body.kinematics import joints_from_parts
from topview.detect.joints.proposals import JointProposals, proposed_of_joints
from topview.geometry.rotations import lengths, unit
from topview.track.pose import FittedBody

Array = NDArray[np.float64]

FOOT_SIGMA: Final = 0.03  # of the stature: how far a foot is from where it is at rest; ours
FOOT_MEMORY_S: Final = 0.1  # of the mean; ours
_FEET: Final = ("left_foot", "right_foot")


class Feet:
    """The feet of one person over time."""

    def __init__(self) -> None:
        self._weighted_leg = np.zeros((2, 3))  # sum of ways over their variances, 1/m
        self._time_s = -np.inf

    def update(
        self, body: FittedBody, proposals: JointProposals | None, timestamp_s: float
    ) -> Array:
        """[2, 3] from the left and the right ankle to the foot, in the frame of the lower leg,
        metres.

        Args:
            body: as it is fitted in the next frame.
            proposals: of the joints of this person there, P = 1, if any.
            timestamp_s: of the frame.
        """
        kept = np.exp((self._time_s - timestamp_s) / FOOT_MEMORY_S)
        self._time_s = timestamp_s
        self._weighted_leg *= kept
        if proposals is not None:
            feet = proposed_of_joints(proposals.joint_names, _FEET)
            if (feet >= 0).all():
                self._measure(body, proposals, feet)
        at_rest_m = body.model.stature_m * FEET_AT_REST
        of_rest = 1.0 / (FOOT_SIGMA * body.model.stature_m) ** 2
        way = unit(of_rest * at_rest_m + self._weighted_leg)
        return way * lengths(at_rest_m)[:, None]

    def _measure(
        self, body: FittedBody, proposals: JointProposals, feet: NDArray[np.int64]
    ) -> None:
        """Count the feet, which are [2] of the proposed joints, of the mode that is nearest to the
        body; legs that are not tracked have none."""
        joints = joints_from_parts(body.model, body.Ts_camera_part)
        mode = _nearest_mode(joints, proposals)
        if mode is None:
            return
        ways = proposals.positions_camera[0, mode, feet] - joints[ANKLES]
        ways_leg = np.einsum("lba,lb->la", body.Ts_camera_part[LOWER_LEGS, :3, :3], ways)
        variance = 2.0 * (proposals.scales_m[0, mode, feet] ** 2).mean(-1, keepdims=True)  # Laplace
        self._weighted_leg += np.nan_to_num(ways_leg / variance)


def _nearest_mode(joints_camera: Array, proposals: JointProposals) -> int | None:
    """The mode whose joints lie nearest to the body's known ones; None if nothing is proposed."""
    proposed = proposed_of_joints(proposals.joint_names)
    places = proposals.positions_camera[0].take(proposed, axis=1)
    is_known = np.isfinite(joints_camera).all(-1) & (proposed >= 0)
    is_used = proposals.weights[0] > 0.0
    if not is_known.any() or not is_used.any():
        return None
    gaps_m = lengths(places - joints_camera)[:, is_known].mean(-1)
    return int(np.where(is_used, gaps_m, np.inf).argmin())
