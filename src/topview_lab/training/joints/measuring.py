"""How well a network proposes joints on recordings that it may not know, with the true masks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints.network import mode_weights
from topview.detect.joints.proposals import FACING_MODE
from topview_lab.training.joints.recordings import Samples
from topview_lab.training.joints.windows import (
    AS_THEY_ARE,
    SHOULDERS_AND_HIPS,
    WITHOUT_PERSON,
    LabelledWindow,
    Variation,
    labelled_window,
)

NEAR_JOINT_M: Final = 0.1
INTERVALS: Final = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
INTERVAL: Final = INTERVALS.index(0.9)
"""The one that is told of each joint."""
_SHARES: Final = np.array(INTERVALS)
HALF_WIDTHS: Final = log(2.0) / log(3.0) * np.log((1.0 + _SHARES) / (1.0 - _SHARES))
"""Half the widths of the intervals, in scales, that hold those shares. The scales are learnt as
those of Laplace laws; half of the errors are within the Laplace law's median, but their tails are
those of a logistic law of the same median."""
CLEARLY_FACING: Final = 0.3
"""Sine between the camera's direction and a person's shoulders and hips (ours)."""
HIDDEN_FROM: Final = 0.3
"""Share from which a joint is hidden by others."""

Network = Callable[[NDArray[np.float32]], Mapping[str, NDArray[np.float32]]]
"""`topview.detect.joints.network.OUTPUTS` by name, of [P, 3, 128, 128] windows."""


@dataclass(frozen=True, slots=True, eq=False)
class JointScores:
    """Of the windows of some recordings; NaN for joints that none of them shows.

    Attributes:
        windows: how many.
        mean_m, within: [21] mean distance, and share within `NEAR_JOINT_M`.
        held: [21, 3] share of the 90 % intervals that hold the truth, axis by axis.
        held_in_view, held_hidden: [10, 3] share of the `INTERVALS` of all joints that do, of those
            that others hide less, and not less, than `HIDDEN_FROM`.
        facing_told: share of those who clearly face the camera, or are turned away, that are told
            to be so; NaN where nobody is.
        people_told, things_told: share of windows with one person, and without any, that are told
            so.
    """

    windows: int
    mean_m: NDArray[np.float64]
    within: NDArray[np.float64]
    held: NDArray[np.float64]
    held_in_view: NDArray[np.float64]
    held_hidden: NDArray[np.float64]
    facing_told: float
    people_told: float
    things_told: float


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a network says of one window.

    Attributes:
        window: what it was asked about.
        mode: the likeliest.
        off: [21, 3] how far it has the joints from where they are, in the box; NaN where unknown.
        scales: [21, 3] as it states them, in the box.
        person_logit: above 0 where it rather sees a person.
    """

    window: LabelledWindow
    mode: int
    off: NDArray[np.float64]
    scales: NDArray[np.float64]
    person_logit: float


def answer_to(network: Network, samples: Samples, number: int, how: Variation) -> Answer:
    """Of one sample, varied."""
    window = _window(samples, number, how)
    said = network(window.image[None])
    mode = int(mode_weights(said["mode_logits"], said["log_scales"])[0].argmax())
    off = said["places"][0, mode].astype(np.float64) - window.places
    off[~window.is_known] = np.nan
    scales = np.exp(said["log_scales"][0, mode].astype(np.float64))
    return Answer(window, mode, off, scales, float(said["person_logit"][0]))


def measure(
    network: Network, samples: Samples, every: int, advance: Callable[[], None]
) -> JointScores:
    """Scores of every n-th sample."""
    apart, scaled, hidden, faced, told, things = [], [], [], [], [], []
    for number in range(0, len(samples), every):
        answer = answer_to(network, samples, number, AS_THEY_ARE)
        sine = facing_sine(answer.window)
        if abs(sine) > CLEARLY_FACING:
            faced.append((answer.mode == FACING_MODE) == (sine > 0.0))
        hidden.append(answer.window.hidden)
        apart.append(np.linalg.norm(answer.off, axis=1) * answer.window.half_m)
        scaled.append(np.abs(answer.off) / answer.scales)
        told.append(answer.person_logit > 0.0)
        thing = _window(samples, number, WITHOUT_PERSON)
        if not thing.is_person:
            things.append(float(network(thing.image[None])["person_logit"][0]) < 0.0)
        advance()
    distance_m, ratio = np.array(apart), np.array(scaled)
    is_told = np.isfinite(distance_m)
    counts = np.where(is_told.any(axis=0), is_told.sum(axis=0), np.nan)
    return JointScores(
        len(distance_m),
        np.nansum(distance_m, axis=0) / counts,
        (is_told & (distance_m < NEAR_JOINT_M)).sum(axis=0) / counts,
        (np.isfinite(ratio) & (ratio < HALF_WIDTHS[INTERVAL])).sum(axis=0) / counts[:, None],
        _held(ratio[is_told & ~(np.array(hidden) >= HIDDEN_FROM)]),
        _held(ratio[is_told & (np.array(hidden) >= HIDDEN_FROM)]),
        float(np.mean(faced)) if faced else float("nan"),
        float(np.mean(told)),
        float(np.mean(things)) if things else float("nan"),
    )


def facing_sine(window: LabelledWindow) -> float:
    """1 for whoever faces the camera, -1 for who is turned away; 0 where a shoulder or hip is not
    known."""
    if not window.is_known[SHOULDERS_AND_HIPS].all():
        return 0.0
    left, right = window.places[SHOULDERS_AND_HIPS].sum(axis=1)
    across = left - right
    return float(across[0] / max(np.hypot(across[0], across[2]), 1e-6))


def _held(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """[10, 3] share of [N, 3] errors, in scales, within each of the `INTERVALS`; NaN of none."""
    if not len(ratio):
        return np.full((len(INTERVALS), 3), np.nan)
    return (ratio[None] < HALF_WIDTHS[:, None, None]).mean(axis=1)


def _window(samples: Samples, number: int, how: Variation) -> LabelledWindow:
    return labelled_window(samples, number, np.random.default_rng(number), how)
