"""How well a network proposes joints on recordings that it may not know, with the true masks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints.windows import HALF_BOX_M
from topview_lab.training.joints.recordings import Samples
from topview_lab.training.joints.windows import (
    AS_THEY_ARE,
    WITHOUT_PERSON,
    Variation,
    labelled_window,
)

NEAR_JOINT_M: Final = 0.1
INTERVAL: Final = 0.9
LAPLACE_INTERVAL: Final = -np.log(1.0 - INTERVAL)
"""Half the width of the interval, in scales, that holds that share of a Laplace law."""

Network = Callable[[NDArray[np.float32]], tuple[NDArray[np.float32], ...]]


@dataclass(frozen=True, slots=True, eq=False)
class JointScores:
    """Of the windows of some recordings; NaN for joints that none of them shows.

    Attributes:
        windows: how many.
        mean_m, within: [21] mean distance, and share within `NEAR_JOINT_M`.
        held: [21, 3] share of the 90 % intervals that hold the truth, axis by axis.
        people_told, things_told: share of windows with one person, and without any, that are told
            so.
    """

    windows: int
    mean_m: NDArray[np.float64]
    within: NDArray[np.float64]
    held: NDArray[np.float64]
    people_told: float
    things_told: float


def measure(
    network: Network, samples: Samples, every: int, advance: Callable[[], None]
) -> JointScores:
    """Scores of every n-th sample."""
    apart, scaled, told, things = [], [], [], []
    for number in range(0, len(samples), every):
        image, places, is_known = _window(samples, number, AS_THEY_ARE)
        found, log_scales, modes, person, _ = network(image[None])
        best = int(modes[0].argmax())
        off = np.abs(found[0, best] - places)
        unknown = np.where(is_known, 0.0, np.nan)
        apart.append(np.linalg.norm(off, axis=1) * HALF_BOX_M + unknown)
        scaled.append(off / np.exp(log_scales[0, best]) + unknown[:, None])
        told.append(float(person[0]) > 0.0)
        thing, _, is_somebody = _window(samples, number, WITHOUT_PERSON)
        if not is_somebody.any():
            things.append(float(network(thing[None])[3][0]) < 0.0)
        advance()
    distance_m, ratio = np.array(apart), np.array(scaled)
    is_told = np.isfinite(distance_m)
    counts = np.where(is_told.any(axis=0), is_told.sum(axis=0), np.nan)
    return JointScores(
        len(distance_m),
        np.nansum(distance_m, axis=0) / counts,
        (is_told & (distance_m < NEAR_JOINT_M)).sum(axis=0) / counts,
        (np.isfinite(ratio) & (ratio < LAPLACE_INTERVAL)).sum(axis=0) / counts[:, None],
        float(np.mean(told)),
        float(np.mean(things)) if things else float("nan"),
    )


def _window(
    samples: Samples, number: int, how: Variation
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    window = labelled_window(samples, number, np.random.default_rng(number), how)
    return window.image, window.places, window.is_known
