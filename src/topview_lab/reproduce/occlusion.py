"""How much of a user or of a torso is occluded: what frames are sorted by."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview_lab.metrics import Pool
from topview_lab.reproduce.printed import Occlusion
from topview_lab.sim import GroundTruth

BANDS: Final[dict[Occlusion, tuple[float, float]]] = {
    "0 %": (0.0, 0.05),
    "30 %": (0.20, 0.40),
    "60 %": (0.50, 0.70),
}
"""Shares of the torso that count as each of the thesis's three cases (ours)."""
INTERACTION: Final = 0.2
"""With this share of the user hidden by another, a frame is one with occlusions (ours)."""

_TORSO: Final = (
    "neck", "torso", "pelvis", "left_shoulder", "right_shoulder", "left_hip", "right_hip",
)  # fmt: skip
_TORSO_OF_TRUTH: Final = (
    "neck", "torso", "pelvis", "shoulder_l", "shoulder_r", "hip_l", "hip_r",
)  # fmt: skip


def torso_hidden(pool: Pool) -> NDArray[np.float64]:
    """[N] share of the torso that other people and objects hide: mean over its joints."""
    return pool.hidden_share(_TORSO, ("another person", "an object"))


def true_torso_hidden(truth: GroundTruth) -> NDArray[np.float64]:
    """[F, P] the same of a simulated recording."""
    columns = [list(truth.names).index(joint) for joint in _TORSO_OF_TRUTH]
    return truth.joint_occ_inter[..., columns].mean(-1).astype(np.float64)


def is_in_band(hidden: NDArray[np.float64], level: Occlusion) -> NDArray[np.bool_]:
    """[...] True for the shares that count as this case."""
    low, high = BANDS[level]
    return (hidden >= low) & (hidden <= high)


def is_subject(pool: Pool) -> NDArray[np.bool_]:
    """[N] True for the user who is looked at; others are dummies who occlude (Sec. 6.1.2)."""
    return pool.samples.person == 0


def is_occluded(pool: Pool) -> NDArray[np.bool_]:
    """[N] True where another person occludes a good part of the user."""
    return pool.hidden_share(JOINT_NAMES, ("another person",)) >= INTERACTION
