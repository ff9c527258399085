"""Calibration of `joint_confidence` as the probability that the joint lies within 10 cm, and of
`joint_covariance_m2` by how many joints lie in their ellipsoids.

Reliability in ten bins and the expected calibration error as in Guo et al., "On calibration of
modern neural networks", ICML 2017; Brier, "Verification of forecasts expressed in terms of
probability", 1950. Distances are told with the constant offsets out, or as they are where no
offset can be told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import JOINT_STATE_NAMES, JointState
from topview_lab.metrics.errors import Pool, position_errors, total_share
from topview_lab.metrics.samples import CAUSES
from topview_lab.metrics.splits import ALL, HIDDEN_SHARES, UNHIDDEN, hidden_split, occlusion_splits
from topview_lab.metrics.statistics import WITHIN

CONFIDENCE_BINS: Final = 10
ELLIPSOID_90: Final = 6.2514  # squared Mahalanobis distance that 90 % of a Gaussian's errors keep
CALIBRATED_SPLITS: Final = (ALL, UNHIDDEN, hidden_split(HIDDEN_SHARES[0], CAUSES[0]))
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
class SplitCalibration:
    """Joints of one split: NaN where there is none.

    Attributes:
        stated: how many, and how often what is stated of them holds.
        expected_error: mean of |confidence - holds| over the bins of confidence, by their counts.
        inside_90: share of the joints whose covariance is known that lie in its ellipsoid of 90 %.
    """

    stated: Reliability
    expected_error: float
    inside_90: float


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
        splits: of `CALIBRATED_SPLITS`.
    """

    bins: tuple[Reliability, ...]
    overall: Reliability
    expected_error: float
    brier: float
    states: dict[str, Reliability]
    told_states: dict[str, dict[str, float]]
    true_states: dict[str, int]
    splits: dict[str, SplitCalibration]


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
    bins = _bins(confidence, holds)
    distances = mahalanobis(pool)[is_told]
    split_of = occlusion_splits(pool.samples.hidden) | {ALL: np.ones(is_told.shape, bool)}
    true_state = true_states(pool.samples.hidden[is_told])
    by_true = {s: true_state == s for s in JointState if s != JointState.ABSENT}
    return Calibration(
        bins=bins,
        overall=_reliability(confidence, holds, np.ones(len(holds), bool)),
        expected_error=_expected_error(bins),
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
        splits={
            name: _of_split(confidence, holds, distances, split_of[name][is_told])
            for name in CALIBRATED_SPLITS
        },
    )


def mahalanobis(pool: Pool) -> NDArray[np.float64]:
    """[N, J] squared distance of each joint from the truth in units of its covariance, the constant
    offsets out as in `calibrate`; NaN where it is not known."""
    corrected = pool.corrected_camera
    samples = pool.samples
    placed = np.where(np.isfinite(corrected), corrected, samples.predicted_camera)
    errors = placed - samples.reference_camera
    distances = np.full(errors.shape[:2], np.nan)
    is_known = np.isfinite(errors).all(-1) & np.isfinite(samples.joint_covariance_m2).all((-2, -1))
    own = errors[is_known]
    solved = np.linalg.solve(samples.joint_covariance_m2[is_known], own[..., None])[..., 0]
    distances[is_known] = (own * solved).sum(-1)
    return distances


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


def _of_split(
    confidence: NDArray[np.float64],
    holds: NDArray[np.bool_],
    distances: NDArray[np.float64],
    where: NDArray[np.bool_],
) -> SplitCalibration:
    known = distances[where & np.isfinite(distances)]
    return SplitCalibration(
        _reliability(confidence, holds, where),
        _expected_error(_bins(confidence[where], holds[where])),
        _mean(known <= ELLIPSOID_90),
    )


def _bins(confidence: NDArray[np.float64], holds: NDArray[np.bool_]) -> tuple[Reliability, ...]:
    bin_of = np.minimum(
        ((confidence + CONFIDENCE_ROUNDING) * CONFIDENCE_BINS).astype(int), CONFIDENCE_BINS - 1
    )
    return tuple(_reliability(confidence, holds, bin_of == b) for b in range(CONFIDENCE_BINS))


def _expected_error(bins: Sequence[Reliability]) -> float:
    return _mean(np.concatenate([np.full(b.count, _gap(b)) for b in bins]))


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
