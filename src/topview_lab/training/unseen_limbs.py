"""Fit where limbs that are out of sight are on average
(`topview.track.methods.topview.unseen_limbs`) to captured motion."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError
from topview.room.floor import CAMERA_UP
from topview.track.methods.topview.posture import N_UPRIGHT, head_heights, upright_traits
from topview.track.methods.topview.unseen_limbs import UnseenLimbs
from topview.track.pose import mirrored

Array = NDArray[np.float64]

FEWEST_CAPTURED: Final = 10 * N_UPRIGHT  # poses that are needed; ours


def fit_unseen_limbs(captured: Array, source: str) -> UnseenLimbs:
    """Mean and covariance of what captured people look like. Left and right are alike.

    Args:
        captured: [F, 11, 3, 3] poses of `topview_lab.training.poses.read_captures`.
        source: what they are.

    Raises:
        InputError: too few poses.
    """
    if len(captured) < FEWEST_CAPTURED:
        raise InputError(
            f"{len(captured)} captured poses are too few: at least {FEWEST_CAPTURED} are needed"
        )
    Rs = np.swapaxes(np.concatenate([captured, mirrored(captured)]), 0, 1)
    traits = upright_traits(Rs, CAMERA_UP, head_heights(Rs))
    return UnseenLimbs(source, traits.mean(0), np.cov(traits, rowvar=False))
