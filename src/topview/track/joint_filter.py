"""Proposed joints over time: a Kalman filter for each joint of each mode (ours).

Joints go on at a constant velocity that changes at random, and each frame's proposal is a
measurement as sure as its scales say. It averages what differs from frame to frame, such as noise
and which way the window was looked at; what a proposer gets wrong all the time stays wrong. So the
scales that go on are those of the proposals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from topview.detect.joints import JointProposals
from topview.kernels import joint_filter as kernel
from topview.records import check_range


@dataclass(frozen=True, slots=True)
class JointFilterSettings:
    """Ours, fitted on rendered people.

    Attributes:
        unrest_m2_s3: how fast the variance of a joint's velocity grows, 0.001 to 1e6.
        jump: a joint starts anew whose proposal is so many standard deviations off, 1 to 1000.

    Raises:
        InputError: a value out of range.
    """

    unrest_m2_s3: float = 20.0
    jump: float = 5.0

    def __post_init__(self) -> None:
        check_range(self, 0.001, 1e6, "unrest_m2_s3")
        check_range(self, 1.0, 1000.0, "jump")


class JointFilter:
    """The joints of one person's proposals over time.

    Places are filtered as what they are measured as: across, as shares of the depth, and in depth.
    """

    def __init__(self, settings: JointFilterSettings) -> None:
        self.settings = settings
        self._state = np.zeros((5, 0, 0, 3))  # as in `kernel.filter_joints`

    def update(self, proposals: JointProposals, elapsed_s: float) -> JointProposals:
        """The first person's proposals with their places filtered.

        Args:
            proposals: P = 1; always of as many modes and joints.
            elapsed_s: since the ones before.
        """
        places, scales_m = proposals.positions_camera[0], proposals.scales_m[0]
        begins = self._state.shape[1:] != places.shape
        if begins:
            self._state = np.zeros((5, *places.shape))
        filtered = np.empty(places.shape)
        kernel.filter_joints(
            places, scales_m, (elapsed_s, elapsed_s**2, elapsed_s**3), self.settings.unrest_m2_s3,
            -inf if begins else self.settings.jump**2, self._state, filtered,
        )  # fmt: skip
        return proposals if begins else replace(proposals, positions_camera=filtered[None])
