"""How people turn: a belief over all yaws, and over how fast they change, over time (ours).

Whoever turns round goes on turning. So a belief knows a rate beside each yaw, and front and back
are not exchanged where the side view tells little.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

N_YAWS: Final = 60
YAWS_RAD: Array = np.linspace(-np.pi, np.pi, N_YAWS, endpoint=False, dtype=np.float64)

# All ours.
RATES_RAD: Array = np.linspace(-0.135, 0.135, 7)  # by which somebody may turn within `FRAME_S`
CHANGE_SHARE: Final = 0.1  # of how often, within `FRAME_S`, the next faster or slower one follows
STEP_RAD: Final = 0.03  # standard deviation of how far somebody turns besides, within `FRAME_S`
FRONTAL_LOG_ODDS: Final = 0.4  # of somebody new, that they face the camera and not away from it
FORGOTTEN_SHARE: Final = 1e-3  # of the belief within `FRAME_S`: it may be wrong altogether
EVIDENCE_SHARE: Final = 0.2  # of the log likelihood in `FRAME_S`: frames in a row err alike


def of_somebody_new() -> Array:
    """[rates, yaws] the belief before anything is seen: a little likelier to face the camera."""
    yaws = np.exp(0.5 * FRONTAL_LOG_ODDS * np.cos(YAWS_RAD))
    return normalised(np.repeat(yaws[None], len(RATES_RAD), axis=0))


def turned_on(belief: Array, frames: float) -> Array:
    """The belief before the next frame is seen: everybody turns on, like a random walk besides, and
    may turn faster or slower.

    Args:
        belief: [rates, yaws] for `RATES_RAD` and `YAWS_RAD`; sums to 1, as what is returned does.
        frames: of `FRAME_S` that have gone by.
    """
    turns, changes = _transition(frames)
    moved = np.fft.ifft(np.fft.fft(belief) * turns)
    changed = changes @ np.maximum(np.real(moved), 0.0)
    forgotten = min(FORGOTTEN_SHARE * frames, 1.0)
    return (1.0 - forgotten) * changed + forgotten / changed.size


def evidence_share(frames: float) -> float:
    """Of the log likelihood of a frame that comes so many `FRAME_S` after the one before."""
    return min(EVIDENCE_SHARE * frames, 1.0)


def normalised(belief: Array) -> Array:
    """The same, with a sum of 1."""
    return belief / belief.sum()


def wrapped(angles_rad: Array) -> Array:
    """The same angles in -180..180 degrees."""
    return (angles_rad + np.pi) % (2 * np.pi) - np.pi


@lru_cache(maxsize=64)  # most frames come as long after the one before
def _transition(frames: float) -> tuple[NDArray[np.complex128], Array]:
    """[rates, yaws] Fourier transform of how far each rate turns somebody, and [rates, rates] how
    likely each rate follows each other one, column by column, `frames` of `FRAME_S` later: one of
    its neighbours follows it, or itself, at the ends as well."""
    off = YAWS_RAD - YAWS_RAD[0] - frames * RATES_RAD[:, None]
    sigma_rad = STEP_RAD * np.sqrt(max(frames, 0.1))
    kernels = np.exp(-0.5 * (wrapped(off) / sigma_rad) ** 2)
    kernels /= kernels.sum(1, keepdims=True)
    R = len(RATES_RAD)
    share = min(CHANGE_SHARE * frames, 0.5)
    neighbours = np.eye(R, k=1) + np.eye(R, k=-1)
    neighbours[[0, -1], [0, -1]] = 1.0
    return np.fft.fft(kernels), (1.0 - share) * np.eye(R) + 0.5 * share * neighbours
