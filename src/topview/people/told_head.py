"""The head that the joint network sees in one window."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints.proposals import JointProposals

Vector = NDArray[np.float64]

TOLD_JOINT, TRUNK_END = "head", "pelvis"
# All ours. A network that takes a window for a person's by this probability, and is no less exact
# than this (standard deviation), knows where the head is; no less than the last, about where.
SURE, SURE_M, ROUGHLY_M = 0.5, 0.17, 0.28
# A head that it sees so far from the track's is another's.
ELSEWHERE_M: Final = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class ToldHead:
    """What the joint network said of one window.

    Attributes:
        p_person: probability that it shows a person.
        head_camera: [3] metres.
        sigma_m: standard deviation of the head's place along each axis; infinity where the window
            is not taken for a person's.
        trunk_camera: [3] unit vector from the pelvis to the head; None where no pelvis is proposed.
    """

    p_person: float
    head_camera: Vector
    sigma_m: float
    trunk_camera: Vector | None = None

    @classmethod
    def of(cls, proposals: JointProposals) -> ToldHead:
        """Of one person's proposals."""
        mode, head = int(np.argmax(proposals.weights[0])), proposals.joint_names.index(TOLD_JOINT)
        p_person = float(proposals.p_person[0])
        scale_m = float(proposals.scales_m[0, mode, head].max())
        sigma_m = sqrt(2.0) * scale_m if p_person > SURE else inf  # Laplace's law
        joints_camera = proposals.positions_camera[0, mode]
        trunk_camera = None
        if TRUNK_END in proposals.joint_names:
            way = joints_camera[head] - joints_camera[proposals.joint_names.index(TRUNK_END)]
            trunk_camera = way / max(float(np.linalg.norm(way)), 1e-6)
        return cls(p_person, joints_camera[head], sigma_m, trunk_camera)

    @property
    def is_sure(self) -> bool:
        """Whether the network knows where the head is."""
        return self.sigma_m < SURE_M

    @property
    def is_rough(self) -> bool:
        """Whether the network knows about where the head is."""
        return self.sigma_m < ROUGHLY_M

    def is_near(self, head_camera: Vector) -> bool:
        """Whether it may be the head at [3] that the network saw."""
        return bool(np.linalg.norm(self.head_camera - head_camera) < ELSEWHERE_M)

    @property
    def log_odds(self) -> float:
        """Of a person."""
        return float(np.log(max(self.p_person, 1e-6)) - np.log(max(1.0 - self.p_person, 1e-6)))
