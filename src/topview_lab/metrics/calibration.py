"""Calibration of `joint_confidence` as the probability that the joint lies within 10 cm.

Reliability in ten bins and the expected calibration error as in Guo et al., "On calibration of
modern neural networks", ICML 2017; Brier, "Verification of forecasts expressed in terms of
probability", 1950. Distances are told with the constant offsets out, or as they are where no
offset can be told.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import JOINT_STATE_NAMES, JointState
from topview_lab.metrics.errors import Pool, position_errors, total_share
from topview_lab.metrics.statistics import WITHIN

CONFIDENCE_BINS: Final = 10
CONFIDENCE_ROUNDING: Final = (
    1e-6  # confidences are told in single precision: 0.9 belongs to the last bin
)


@dataclass(frozen=True, slots=True)
class Reliability:
    """Joints of like confidence or state: NaN where there is none.

    Attributes:
        count: how many.
        confidence: their mean confidence.
        holds: the share of them within 10 cm.
    """

    count: int
    confidence: float
    holds: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """Of all predicted joints whose truth is known.

    Attributes:
        bins: by confidence, [0, 0.1), [0.1, 0.2) ... [0.9, 1].
        overall: all of them.
        expected_error: mean of |confidence - holds| over the bins, by their counts.
        brier: mean of (confidence - holds)^2 over the joints; 0.25 for one half throughout.
        states: by predicted state.
        told_states: true state -> predicted state -> share 0..1 of the joints in that true state.
            The true state is what takes the largest share of the joint: nothing, or one of the
            causes.
        true_states: true state -> how many.
    """

    bins: tuple[Reliability, ...]
    overall: Reliability
    expected_error: float
    brier: float
    states: dict[str, Reliability]
    told_states: dict[str, dict[str, float]]
    true_states: dict[str, int]


def calibrate(pool: Pool, where: NDArray[np.bool_] | None = None) -> Calibration:
    """Of all person-frames, or of the [N] ones `where` says True."""
    errors = position_errors(pool)
    distance_cm = np.where(np.isfinite(errors.offset_out), errors.offset_out, errors.raw)
    is_told = np.isfinite(distance_cm) & np.isfinite(pool.samples.joint_confidence)
    if where is not None:
        is_told &= where[:, None]
    holds = distance_cm[is_told] <= WITHIN
    confidence = pool.samples.joint_confidence[is_told]
    state = pool.samples.joint_state[is_told]
    bin_of = np.minimum(
        ((confidence + CONFIDENCE_ROUNDING) * CONFIDENCE_BINS).astype(int), CONFIDENCE_BINS - 1
    )
    bins = tuple(_reliability(confidence, holds, bin_of == b) for b in range(CONFIDENCE_BINS))
    true_state = true_states(pool.samples.hidden[is_told])
    by_true = {s: true_state == s for s in JointState if s != JointState.ABSENT}
    return Calibration(
        bins=bins,
        overall=_reliability(confidence, holds, np.ones(len(holds), bool)),
        expected_error=_mean(np.concatenate([np.full(b.count, _gap(b)) for b in bins])),
        brier=_mean((confidence - holds) ** 2),
        states={
            name: _reliability(confidence, holds, state == s)
            for s, name in enumerate(JOINT_STATE_NAMES)
            if (state == s).any()
        },
        told_states={
            JOINT_STATE_NAMES[s]: _shares(state[chosen])
            for s, chosen in by_true.items()
            if chosen.any()
        },
        true_states={
            JOINT_STATE_NAMES[s]: int(chosen.sum()) for s, chosen in by_true.items() if chosen.any()
        },
    )


def true_states(hidden: NDArray[np.float64]) -> NDArray[np.int64]:
    """[...] the `JointState` that [..., 4] shares by `CAUSES` amount to, ABSENT where unknown."""
    seen = 1.0 - total_share(hidden)
    shares = np.concatenate([seen[..., None], np.nan_to_num(hidden)], axis=-1)
    of_share = np.array(
        [
            JointState.VISIBLE,
            JointState.OCCLUDED_BY_PERSON,
            JointState.SELF_OCCLUDED,
            JointState.OCCLUDED_BY_OBJECT,
            JointState.OUT_OF_VIEW,
        ]
    )
    states = of_share[np.nan_to_num(shares).argmax(-1)]
    return np.where(np.isfinite(seen), states, JointState.ABSENT)


def _reliability(
    confidence: NDArray[np.float64], holds: NDArray[np.bool_], where: NDArray[np.bool_]
) -> Reliability:
    return Reliability(int(where.sum()), _mean(confidence[where]), _mean(holds[where]))


def _gap(reliability: Reliability) -> float:
    return abs(reliability.confidence - reliability.holds)


def _shares(states: NDArray[np.uint8]) -> dict[str, float]:
    counts = np.bincount(states, minlength=len(JOINT_STATE_NAMES)) / len(states)
    return dict(zip(JOINT_STATE_NAMES, counts.tolist(), strict=True))


def _mean(values: NDArray[np.float64] | NDArray[np.bool_]) -> float:
    return float(values.mean()) if len(values) else float("nan")
