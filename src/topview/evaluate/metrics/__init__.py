"""Metrics over skeleton sequences, whoever made them.

`evaluate_sequence` measures one recording; `Evaluation.pooled` joins recordings; `summarise` turns
what was measured into the numbers of the tables. For a selection of one's own: `pool` the
evaluation, take the errors of a family (`position_errors`, `direction_errors`,
`relative_angle_errors`, `axis_errors`, `orientation_errors`), choose person-frames by
`Pool.hidden_share` and the samples' labels, and `compare`.
"""

from topview.evaluate.metrics.angles import (
    BONES,
    DIRECTION_GROUPS,
    DIRECTIONS,
    PART_GROUPS,
    RELATIVE_ANGLE_GROUPS,
    RELATIVE_ANGLES,
    Bone,
    RelativeAngle,
    axis_errors,
    direction_errors,
    orientation_errors,
    relative_angle_errors,
)
from topview.evaluate.metrics.calibration import Calibration, Reliability, calibrate, true_states
from topview.evaluate.metrics.depth_benchmarks import (
    BODY_HALVES,
    WithinLimit,
    average_precision,
    benchmark,
)
from topview.evaluate.metrics.errors import Errors, Offsets, Pool, pool, position_errors
from topview.evaluate.metrics.matching import (
    GATE_M,
    PeopleCounts,
    count_people,
    match_people,
    people_distances,
)
from topview.evaluate.metrics.measure import evaluate_sequence, measure_sequence
from topview.evaluate.metrics.reference import ReferenceSequence
from topview.evaluate.metrics.samples import (
    CAUSES,
    Evaluation,
    Samples,
    SequenceErrors,
)
from topview.evaluate.metrics.splits import ALL, UNHIDDEN, hidden_split
from topview.evaluate.metrics.statistics import Comparison, Statistic, statistic
from topview.evaluate.metrics.summary import Found, SequenceSummary, Summary, summarise, tables
from topview.evaluate.metrics.tracking import TrackingCounts, TrackingScores, score_tracking

__all__ = [
    "ALL",
    "BODY_HALVES",
    "BONES",
    "CAUSES",
    "DIRECTIONS",
    "DIRECTION_GROUPS",
    "GATE_M",
    "PART_GROUPS",
    "RELATIVE_ANGLES",
    "RELATIVE_ANGLE_GROUPS",
    "UNHIDDEN",
    "Bone",
    "Calibration",
    "Comparison",
    "Errors",
    "Evaluation",
    "Found",
    "Offsets",
    "PeopleCounts",
    "Pool",
    "ReferenceSequence",
    "RelativeAngle",
    "Reliability",
    "Samples",
    "SequenceErrors",
    "SequenceSummary",
    "Statistic",
    "Summary",
    "TrackingCounts",
    "TrackingScores",
    "WithinLimit",
    "average_precision",
    "axis_errors",
    "benchmark",
    "calibrate",
    "count_people",
    "direction_errors",
    "evaluate_sequence",
    "hidden_split",
    "match_people",
    "measure_sequence",
    "orientation_errors",
    "people_distances",
    "pool",
    "position_errors",
    "relative_angle_errors",
    "score_tracking",
    "statistic",
    "summarise",
    "tables",
    "true_states",
]
