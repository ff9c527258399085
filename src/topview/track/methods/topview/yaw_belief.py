"""Which way somebody faces, over time: which of the proposed whole bodies is right (ours).

A mode's number tells little. Where a proposer is sure, all its modes face the same way; seen from
the side, each is the other one's neighbour; and a proposer that takes the back for the front does
so for long. So what is believed is the yaw. Each frame's modes are its likelihood: a mixture of
laws round the yaws of their trunks, as wide as the scales of their joints say.

A yaw here is the turn of the trunk's front about the trunk's own axis, from the direction to the
camera, so that somebody who lies has one, too.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.filter.over_time import FRAME_S, PAUSE_FRAMES
from topview.filter.turning import (
    N_YAWS,
    RATES_RAD,
    YAWS_RAD,
    evidence_share,
    normalised,
    turned_on,
    wrapped,
)
from topview.kernels.proposed import face_trunks

Array = NDArray[np.float64]

# All ours.
MODE_DOUBT: Final = 0.02  # of the weights, dealt to all modes alike: they may tell nothing
YAW_OUTLIERS: Final = 0.003  # of the yaws of the right mode, which may be anything
LEAST_BREADTH_M: Final = 0.05  # of trunks whose sides are nearly in one place
TURNED_AWAY_S: Final = 1.0  # with nothing proposed for longer, somebody may face any way

_LEFT = np.array([JOINT_NAMES.index(f"left_{joint}") for joint in ("shoulder", "hip")])
_RIGHT = np.array([JOINT_NAMES.index(f"right_{joint}") for joint in ("shoulder", "hip")])


class YawBelief:
    """One person's yaw over time."""

    def __init__(self, evidence: float) -> None:
        """`evidence`: as `GuideSettings.yaw_evidence`."""
        self._evidence = evidence
        self._belief: Array | None = None  # [rates, yaws]

    def update(
        self, yaws_rad: Array, sigmas_rad: Array, weights: Array, likely: Array, elapsed_s: float
    ) -> Array:
        """[M] how likely each mode is after this frame, by all frames so far.

        Args:
            yaws_rad, sigmas_rad: [M] of the modes' trunks, as `trunk_yaws` tells.
            weights: [M] of the modes in this frame; their sum is 1.
            likely: [M] how likely each mode is, were their yaws alike.
            elapsed_s: since the last frame with proposals.
        """
        if self._belief is None or elapsed_s > TURNED_AWAY_S:
            belief = np.full((len(RATES_RAD), N_YAWS), 1.0 / (len(RATES_RAD) * N_YAWS))
            frames = PAUSE_FRAMES
        else:
            frames = max(elapsed_s, 0.0) / FRAME_S
            belief = turned_on(self._belief, frames)
        doubted = (1.0 - MODE_DOUBT) * weights + MODE_DOUBT / len(weights)
        laws = _laws(yaws_rad, sigmas_rad)
        told = doubted ** min(self._evidence * frames, 1.0) @ laws
        self._belief = normalised(belief * told ** evidence_share(frames))
        by_mode = likely[:, None] * laws
        return by_mode / by_mode.sum(0) @ self._belief.sum(0)


def _laws(yaws_rad: Array, sigmas_rad: Array) -> Array:
    """[M, N_YAWS] probability of `YAWS_RAD`, if each mode is right; alike for all if it tells no
    yaw, which is a sigma of infinity."""
    sigmas_rad = np.maximum(sigmas_rad, np.pi / N_YAWS)[:, None]
    near = np.exp(-0.5 * (wrapped(YAWS_RAD - yaws_rad[:, None]) / sigmas_rad) ** 2)
    return (1.0 - YAW_OUTLIERS) * near / near.sum(1, keepdims=True) + YAW_OUTLIERS / N_YAWS


def trunk_yaws(places_camera: Array, scales_m: Array) -> tuple[Array, Array]:
    """[M] yaws of trunks, -180 to 180 degrees in radians, 0 where the front faces the camera, and
    [M] their standard deviations, infinite where a shoulder or hip is not proposed.

    Args:
        places_camera: [M, 16, 3] metres, in the order of `JOINT_NAMES`.
        scales_m: [M, 16, 3] as in `topview.detect.joints.JointProposals`.
    """
    turns, sigmas_rad = np.empty((2, len(places_camera))), np.empty(len(places_camera))
    face_trunks(places_camera, scales_m, _LEFT, _RIGHT, LEAST_BREADTH_M, turns, sigmas_rad)
    return np.arctan2(*turns), sigmas_rad
