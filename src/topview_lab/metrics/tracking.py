"""Tracking scores of people over time: HOTA and CLEAR MOT, in 3D.

Luiten et al., "HOTA: a higher order metric for evaluating multi-object tracking", IJCV 2021;
Bernardin & Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT metrics",
EURASIP J. Image and Video Processing 2008. Our own few lines, because the libraries want pandas,
matplotlib or another OpenCV to be installed; a test holds them against `motmetrics`.

The similarity of two people is 1 - d / (2 gate), where d is the mean distance of their joints: 1
where they agree, 1/2 at the gate, 0 from twice the gate on.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from topview_lab.metrics.matching import NOBODY, PeopleCounts, people_in_slots
from topview_lab.metrics.statistics import CM_PER_M, share

ALPHAS: Final = np.arange(1, 20) * 0.05  # Luiten et al., Sec. 5: 0.05, 0.10, ... 0.95
THRESHOLD_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class TrackingCounts:
    """What the scores are made of, at each of the A `ALPHAS`; adds up over recordings.

    Attributes:
        hits: [A] pairs of people that are at least alpha alike and matched (TP).
        misses: [A] reference person-frames left over (FN).
        false: [A] predicted person-frames left over (FP).
        association: [A] sum over the hits of how well the two lasting identities overlap, 0..1.
        matched: pairs of `match_people`.
        matched_distance_m: sum of their distances.
    """

    hits: NDArray[np.float64]
    misses: NDArray[np.float64]
    false: NDArray[np.float64]
    association: NDArray[np.float64]
    matched: int
    matched_distance_m: float

    def __add__(self, other: TrackingCounts) -> TrackingCounts:
        return TrackingCounts(
            *(getattr(self, field.name) + getattr(other, field.name) for field in fields(self))
        )


@dataclass(frozen=True, slots=True)
class TrackingScores:
    """NaN where there is nothing to score.

    Attributes:
        hota: mean over alpha of sqrt(detection x association), 0..1.
        detection: DetA, mean over alpha.
        association: AssA, mean over alpha.
        mota: 1 - (missed + false + mismatches) / present, at most 1.
        motp_cm: mean distance of matched people: over all joints, then over people.
    """

    hota: float
    detection: float
    association: float
    mota: float
    motp_cm: float


def count_tracking(
    distances_m: NDArray[np.float64],
    matches: NDArray[np.int64],
    reference_present: NDArray[np.bool_],
    predicted_present: NDArray[np.bool_],
    gate_m: float,
    who: NDArray[np.int64] | None = None,
) -> TrackingCounts:
    """Counts of one recording.

    Args:
        distances_m: [F, R, S] as from `people_distances`.
        matches: [F, R] as from `match_people`, for MOTP.
        reference_present: [F, R].
        predicted_present: [F, S].
        gate_m: as of `match_people`.
        who: [F, S] which of the P people is in each slot, from 0, as of `match_people`; anything
            where nobody is.
    """
    F, _, S = distances_m.shape
    who = people_in_slots(who, F, S)
    alike = np.maximum(1.0 - distances_m / (2.0 * gate_m), 0.0)
    frames_r = reference_present.sum(0)[:, None]
    frames_p = np.bincount(who[predicted_present], minlength=who.max(initial=0) + 1)
    f, r, s = _match(alike, who, frames_r, frames_p)
    is_hit = alike[f, r, s] >= ALPHAS[:, None] - THRESHOLD_ROUNDING
    together = np.zeros((len(ALPHAS), len(frames_r), len(frames_p)))
    for alpha, hit in enumerate(is_hit):
        np.add.at(together[alpha], (r, who[f, s]), hit)
    hits = is_hit.sum(1).astype(np.float64)
    matched_f, matched_r = np.nonzero(matches != NOBODY)
    matched_m = distances_m[matched_f, matched_r, matches[matched_f, matched_r]]
    return TrackingCounts(
        hits=hits,
        misses=reference_present.sum() - hits,
        false=predicted_present.sum() - hits,
        association=(together * _overlap(together, frames_r, frames_p)).sum((1, 2)),
        matched=len(matched_m),
        matched_distance_m=float(matched_m.sum()),
    )


def score_tracking(people: PeopleCounts, counts: TrackingCounts) -> TrackingScores:
    """The scores of one recording, or of several whose counts were added up."""
    if not people.person_frames:
        return TrackingScores(*[float("nan")] * 5)
    detection = counts.hits / (counts.hits + counts.misses + counts.false)
    association = counts.association / np.maximum(counts.hits, 1.0)
    errors = people.missed + people.false_person_frames + people.mismatches
    return TrackingScores(
        hota=float(np.sqrt(detection * association).mean()),
        detection=float(detection.mean()),
        association=float(association.mean()),
        mota=1.0 - errors / people.person_frames,
        motp_cm=CM_PER_M * share(counts.matched_distance_m, counts.matched),
    )


def _match(
    alike: NDArray[np.float64],
    who: NDArray[np.int64],
    frames_r: NDArray[np.int64],
    frames_p: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Frame, reference person and slot of each pair, at most one per person and frame.

    Favours those who fit over the whole recording (Luiten et al., Sec. 3.3 and their code): it is
    the one matching for all alphas, the pairs less alike than alpha being left out afterwards.
    """
    either = alike.sum(2, keepdims=True) + alike.sum(1, keepdims=True) - alike
    in_frame = alike / np.where(either > 0.0, either, 1.0)
    together = np.zeros((len(frames_p), len(frames_r)))
    np.add.at(together, who, in_frame.transpose(0, 2, 1))
    overlap = _overlap(together.T, frames_r, frames_p)
    pairs = [
        (f, r, s)
        for f in np.flatnonzero(alike.any((1, 2)))
        for r, s in zip(
            *linear_sum_assignment(overlap[:, who[f]] * alike[f], maximize=True), strict=True
        )
    ]
    f, r, s = np.array(pairs, np.int64).reshape(-1, 3).T
    return f, r, s


def _overlap(
    together: NDArray[np.float64], frames_r: NDArray[np.int64], frames_p: NDArray[np.int64]
) -> NDArray[np.float64]:
    """[..., R, P] frames together per frames of either, from [R, 1] and [P] frames of each."""
    either = frames_r + frames_p - together
    return together / np.where(either > 0.0, either, 1.0)
