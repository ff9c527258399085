"""The numbers of all tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview_lab.metrics.angles import (
    DIRECTION_GROUPS,
    PART_GROUPS,
    RELATIVE_ANGLE_GROUPS,
    axis_errors,
    direction_errors,
    orientation_errors,
    relative_angle_errors,
)
from topview_lab.metrics.calibration import Calibration, calibrate
from topview_lab.metrics.depth_benchmarks import WithinLimit, benchmark
from topview_lab.metrics.errors import Errors, Offsets, Pool, end_errors, pool, position_errors
from topview_lab.metrics.facing import Held, facing
from topview_lab.metrics.matching import PeopleCounts
from topview_lab.metrics.reacquired import reacquired
from topview_lab.metrics.samples import Evaluation
from topview_lab.metrics.splits import ALL, label_splits, occlusion_splits, splits
from topview_lab.metrics.statistics import Comparison, share
from topview_lab.metrics.tracking import TrackingScores, score_tracking

Table = dict[str, Comparison]  # by joint, part, angle or group of them, and ALL


@dataclass(frozen=True, slots=True)
class SplitRecall:
    """How many person-frames of a split there are, and the share of them that was found."""

    count: int
    recall: float


@dataclass(frozen=True, slots=True)
class SequenceSummary:
    """One recording's numbers; the offsets are still those of the whole set."""

    name: str
    joints: Comparison
    axes: Comparison
    people: PeopleCounts
    tracking: TrackingScores
    frames_per_second: float


@dataclass(frozen=True, slots=True)
class Summary:
    """The numbers of all tables.

    Tables of errors are by split ("all", "unhidden", "hidden ≥ 30%", "hidden by oneself ≥ 30%",
    "action: boxing", "body: woman 1.62 m", ...: `topview_lab.metrics.splits`), then by joint,
    part or angle, or group of them.

    Attributes:
        offsets: how the constant offsets were estimated.
        joints_cm: distances.
        ends_cm: distances of wrists and feet, which no other table counts; empty where the
            reference does not tell them.
        relative_angles_deg: see `topview_lab.metrics.angles`.
        directions_deg: of bones.
        axes_deg: of parts.
        orientations_deg: of parts; empty where the reference does not tell them.
        joint_offsets: the constant offset of each joint, reference minus prediction as x, y, z in
            the frame of its part and in shares of the stature; empty unless one for the whole set.
        within_10_cm: as depth benchmarks count.
        people: counts over all recordings.
        recall: see `PeopleCounts`.
        precision: see `PeopleCounts`.
        found: recall by split, by what is hidden of the whole person.
        tracking: HOTA and CLEAR MOT.
        facing: how many person-frames after the first second, and how often the trunk faces right
            (`topview_lab.metrics.facing`).
        reacquired: how many joints came back into view from behind another person, and how often
            they were found again soon (`topview_lab.metrics.reacquired`).
        calibration: of the joints' confidences.
        tracked_frames: how many.
        seconds: spent in the tracker, all processes together.
        frames_per_second: of one process.
        sequences: one each.
    """

    offsets: Offsets
    joints_cm: dict[str, Table]
    ends_cm: dict[str, Table]
    relative_angles_deg: dict[str, Table]
    directions_deg: dict[str, Table]
    axes_deg: dict[str, Table]
    orientations_deg: dict[str, Table]
    joint_offsets: dict[str, tuple[float, ...]]
    within_10_cm: dict[str, WithinLimit]
    people: PeopleCounts
    recall: float
    precision: float
    found: dict[str, SplitRecall]
    tracking: TrackingScores
    facing: Held
    reacquired: Held
    calibration: Calibration
    tracked_frames: int
    seconds: float
    frames_per_second: float
    sequences: tuple[SequenceSummary, ...]


def summarise(evaluation: Evaluation, offsets: Offsets = "set") -> Summary:
    """The numbers of all tables; `offsets` as in `topview_lab.metrics.errors`.

    Raises:
        ValueError: there is no recording.
    """
    sequences = evaluation.sequences
    pooled = pool(evaluation, offsets)
    joints, ends, axes, orientations = (
        measure(pooled)
        for measure in (position_errors, end_errors, axis_errors, orientation_errors)
    )
    people = sum((s.people for s in sequences), PeopleCounts())
    tracking = sum((s.tracking for s in sequences[1:]), sequences[0].tracking)
    tracked_frames = sum(s.tracked_frames for s in sequences)
    seconds = sum(s.seconds for s in sequences)
    return Summary(
        offsets=offsets,
        joints_cm=tables(pooled, joints),
        ends_cm=tables(pooled, ends) if np.isfinite(ends.raw).any() else {},
        relative_angles_deg=tables(pooled, relative_angle_errors(pooled), RELATIVE_ANGLE_GROUPS),
        directions_deg=tables(pooled, direction_errors(pooled), DIRECTION_GROUPS | PART_GROUPS),
        axes_deg=tables(pooled, axes),
        orientations_deg=tables(pooled, orientations)
        if np.isfinite(orientations.raw).any()
        else {},
        joint_offsets=_by_joint(pooled.joint_offsets[0]) if offsets == "set" else {},
        within_10_cm=benchmark(pooled),
        people=people,
        recall=people.recall,
        precision=people.precision,
        found=_found(pooled),
        tracking=score_tracking(people, tracking),
        facing=facing(pooled),
        reacquired=reacquired(pooled),
        calibration=calibrate(pooled),
        tracked_frames=tracked_frames,
        seconds=seconds,
        frames_per_second=share(tracked_frames, seconds),
        sequences=tuple(
            SequenceSummary(
                name=s.name,
                joints=joints.compare(pooled.sequence == i),
                axes=axes.compare(pooled.sequence == i),
                people=s.people,
                tracking=score_tracking(s.people, s.tracking),
                frames_per_second=share(s.tracked_frames, s.seconds),
            )
            for i, s in enumerate(sequences)
        ),
    )


def tables(
    pool: Pool, errors: Errors, groups: Mapping[str, Sequence[str]] | None = None
) -> dict[str, Table]:
    """By split, then by name of the errors, by group of names, and ALL."""
    columns = {name: (name,) for name in errors.names} | dict(groups or {}) | {ALL: errors.names}
    chosen = {name: [errors.names.index(n) for n in of] for name, of in columns.items()}
    parts = {name: errors.of(of) for name, of in columns.items()}
    return {
        split: {name: parts[name].compare(where[:, of]) for name, of in chosen.items()}
        for split, where in splits(pool, errors).items()
    }


def _found(pool: Pool) -> dict[str, SplitRecall]:
    """By what is hidden of the person: the mean over the joints that are known."""
    hidden = pool.samples.hidden
    known = np.isfinite(hidden)
    count = known.sum(1)
    mean = np.where(known, hidden, 0.0).sum(1) / np.where(count > 0, count, np.nan)
    everyone = np.ones(len(mean), bool)
    where = {ALL: everyone, **occlusion_splits(mean), **label_splits(pool)}
    return {
        split: SplitRecall(
            int(chosen.sum()), share(int(pool.samples.found[chosen].sum()), chosen.sum())
        )
        for split, chosen in where.items()
    }


def _by_joint(offsets_part: NDArray[np.float64]) -> dict[str, tuple[float, ...]]:
    return dict(zip(JOINT_NAMES, map(tuple, offsets_part.tolist()), strict=True))
