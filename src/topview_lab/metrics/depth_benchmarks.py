"""Joints within 10 cm, as the benchmarks of depth images count them: missed people are wrong.

PCK and the mAP of Haque et al., "Towards viewpoint invariant 3D human pose estimation", ECCV 2016
(ITOP, the 10 cm rule): the share of a joint that lies within 10 cm, averaged over the joints.

The ranked average precision of Shotton et al., "Real-time human pose recognition in parts from
single depth images", CVPR 2011, Sec. 4 and PAMI 2013: all predictions of a joint in the order of
their confidence, right within 10 cm, wrong beyond or if nobody is there; the area under precision
over recall. It also says whether the confidences rank right before wrong. Predictions of joints
that the reference does not know are not counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview_lab.metrics.errors import Pool, position_errors
from topview_lab.metrics.splits import ALL
from topview_lab.metrics.statistics import WITHIN

BODY_HALVES: Final[dict[str, tuple[str, ...]]] = {
    "upper body": (
        "head",
        "neck",
        *(f"{side}_{j}" for side in ("left", "right") for j in ("shoulder", "elbow", "hand")),
    ),
    "lower body": tuple(
        f"{side}_{j}" for side in ("left", "right") for j in ("hip", "knee", "ankle")
    ),
}
"""The halves of Haque et al.; torso and pelvis count in neither."""


@dataclass(frozen=True, slots=True)
class WithinLimit:
    """Shares 0..1, NaN where the reference never knows the joint; of several joints, their means.

    Attributes:
        count: how often the reference knows the joint.
        raw: share within 10 cm.
        offset_out: the same with the constant offsets out.
        ranked: average precision.
        ranked_offset_out: the same with the constant offsets out.
    """

    count: int
    raw: float
    offset_out: float
    ranked: float
    ranked_offset_out: float


def benchmark(pool: Pool, where: NDArray[np.bool_] | None = None) -> dict[str, WithinLimit]:
    """By joint, `BODY_HALVES` and ALL; `where`: [N] the person-frames to count, with all else out.

    With `where`, the predictions that match nobody still count in the ranking.
    """
    chosen = np.ones(len(pool.group), bool) if where is None else where
    errors = position_errors(pool)
    is_known = np.all(np.isfinite(pool.samples.reference_camera[chosen]), axis=-1)
    rows = {
        name: _row(
            errors.raw[chosen, j][is_known[:, j]],
            errors.offset_out[chosen, j][is_known[:, j]],
            pool.samples.joint_confidence[chosen, j][is_known[:, j]],
            pool.false_confidence[:, j],
        )
        for j, name in enumerate(JOINT_NAMES)
    }
    halves = {half: _mean([rows[joint] for joint in of]) for half, of in BODY_HALVES.items()}
    return rows | halves | {ALL: _mean(list(rows.values()))}


def average_precision(
    is_right: NDArray[np.bool_], confidence: NDArray[np.float64], count: int
) -> float:
    """Area under precision over recall, NaN of nothing.

    Args:
        is_right: [S] of each prediction.
        confidence: [S]; equal ones enter together, so that their order does not matter.
        count: how many there are to be found.
    """
    if not count:
        return float("nan")
    if not len(is_right):
        return 0.0
    order = np.argsort(-confidence, kind="stable")
    last_of_equals = np.append(np.diff(confidence[order]) != 0.0, True)
    right = np.cumsum(is_right[order])[last_of_equals]
    precision = right / (np.flatnonzero(last_of_equals) + 1)
    return float((np.diff(right, prepend=0) * precision).sum() / count)


def _row(
    raw_cm: NDArray[np.float64],
    offset_out_cm: NDArray[np.float64],
    confidence: NDArray[np.float64],
    false_confidence: NDArray[np.float64],
) -> WithinLimit:
    """Of one joint where it is known; errors are NaN where it was missed, or has no offset."""
    count = len(raw_cm)
    is_told = np.isfinite(raw_cm)
    false = false_confidence[np.isfinite(false_confidence)]
    scores = np.append(confidence[is_told], false)

    def score(errors_cm: NDArray[np.float64]) -> tuple[float, float]:
        if not count or (is_told.any() and not np.isfinite(errors_cm).any()):
            return float("nan"), float("nan")
        is_right = errors_cm <= WITHIN
        ranked = np.append(is_right[is_told], np.zeros(len(false), bool))
        return float(is_right.mean()), average_precision(ranked, scores, count)

    (raw, ranked), (offset_out, ranked_offset_out) = score(raw_cm), score(offset_out_cm)
    return WithinLimit(count, raw, offset_out, ranked, ranked_offset_out)


def _mean(rows: list[WithinLimit]) -> WithinLimit:
    """Of the joints that are known."""
    known = [row for row in rows if row.count]
    if not known:
        return WithinLimit(0, *[float("nan")] * 4)
    shares = np.array([(r.raw, r.offset_out, r.ranked, r.ranked_offset_out) for r in known])
    return WithinLimit(sum(row.count for row in known), *shares.mean(0).tolist())
