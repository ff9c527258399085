"""The head that the joint network sees in one window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints.proposals import JointProposals

Vector = NDArray[np.float64]

TOLD_JOINT, TRUNK_END = "head", "pelvis"
# All ours. A network that takes a window for a person's by this probability, and is no less exact
# than this (Laplace's scale), knows where the head is; no less than the last, about where.
SURE, SURE_M, ROUGHLY_M = 0.5, 0.12, 0.2
# A head that it sees so far from the track's is another's.
ELSEWHERE_M: Final = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class ToldHead:
    """What the joint network said of one window.

    Attributes:
        p_person: probability that it shows a person.
        head_camera: [3] metres.
        is_sure: whether the network knows where the head is.
        trunk_camera: [3] unit vector from the pelvis to the head; None where no pelvis is proposed.
        is_rough: whether the network knows about where the head is.
    """

    p_person: float
    head_camera: Vector
    is_sure: bool
    trunk_camera: Vector | None = None
    is_rough: bool = False

    @classmethod
    def of(cls, proposals: JointProposals) -> ToldHead:
        """Of one person's proposals."""
        mode, head = int(np.argmax(proposals.weights[0])), proposals.joint_names.index(TOLD_JOINT)
        p_person = float(proposals.p_person[0])
        scale_m = float(proposals.scales_m[0, mode, head].max()) if p_person > SURE else np.inf
        joints_camera = proposals.positions_camera[0, mode]
        trunk_camera = None
        if TRUNK_END in proposals.joint_names:
            way = joints_camera[head] - joints_camera[proposals.joint_names.index(TRUNK_END)]
            trunk_camera = way / max(float(np.linalg.norm(way)), 1e-6)
        is_sure, is_rough = scale_m < SURE_M, scale_m < ROUGHLY_M
        return cls(p_person, joints_camera[head], is_sure, trunk_camera, is_rough)

    def is_near(self, head_camera: Vector) -> bool:
        """Whether it may be the head at [3] that the network saw."""
        return bool(np.linalg.norm(self.head_camera - head_camera) < ELSEWHERE_M)

    @property
    def log_odds(self) -> float:
        """Of a person."""
        return float(np.log(max(self.p_person, 1e-6)) - np.log(max(1.0 - self.p_person, 1e-6)))
