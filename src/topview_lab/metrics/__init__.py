"""Metrics over skeleton sequences of any system.

`evaluate_sequence` measures one recording; `Evaluation.pooled` joins recordings; `summarise` turns
what was measured into the numbers of the tables. For a custom selection: `pool` the
evaluation, take the errors of a family (`position_errors`, `end_errors`, `direction_errors`,
`relative_angle_errors`, `axis_errors`, `orientation_errors`), choose person-frames by
`Pool.hidden_share` and the samples' labels, and `compare`.
"""

from topview_lab.metrics.angles import (
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
from topview_lab.metrics.calibration import Calibration, Reliability, calibrate, true_states
from topview_lab.metrics.depth_benchmarks import (
    BODY_HALVES,
    WithinLimit,
    average_precision,
    benchmark,
)
from topview_lab.metrics.errors import Errors, Offsets, Pool, end_errors, pool, position_errors
from topview_lab.metrics.facing import Held, facing, turns_deg
from topview_lab.metrics.losses import LEAST_SEEN, LOST_AFTER_S, times_lost
from topview_lab.metrics.matching import (
    PERSON_GATE_M,
    PeopleCounts,
    count_people,
    match_people,
    people_distances,
)
from topview_lab.metrics.measure import evaluate_sequence, measure_sequence
from topview_lab.metrics.reacquired import comebacks, reacquired
from topview_lab.metrics.reference import ReferenceSequence
from topview_lab.metrics.samples import (
    CAUSES,
    Evaluation,
    Samples,
    SequenceErrors,
)
from topview_lab.metrics.splits import ALL, UNHIDDEN, hidden_split
from topview_lab.metrics.statistics import Comparison, Statistic, statistic
from topview_lab.metrics.summary import SequenceSummary, SplitRecall, Summary, summarise, tables
from topview_lab.metrics.tracking import TrackingCounts, TrackingScores, score_tracking

__all__ = [
    "ALL",
    "BODY_HALVES",
    "BONES",
    "CAUSES",
    "DIRECTIONS",
    "DIRECTION_GROUPS",
    "LEAST_SEEN",
    "LOST_AFTER_S",
    "PART_GROUPS",
    "PERSON_GATE_M",
    "RELATIVE_ANGLES",
    "RELATIVE_ANGLE_GROUPS",
    "UNHIDDEN",
    "Bone",
    "Calibration",
    "Comparison",
    "Errors",
    "Evaluation",
    "Held",
    "Offsets",
    "PeopleCounts",
    "Pool",
    "ReferenceSequence",
    "RelativeAngle",
    "Reliability",
    "Samples",
    "SequenceErrors",
    "SequenceSummary",
    "SplitRecall",
    "Statistic",
    "Summary",
    "TrackingCounts",
    "TrackingScores",
    "WithinLimit",
    "average_precision",
    "axis_errors",
    "benchmark",
    "calibrate",
    "comebacks",
    "count_people",
    "direction_errors",
    "end_errors",
    "evaluate_sequence",
    "facing",
    "hidden_split",
    "match_people",
    "measure_sequence",
    "orientation_errors",
    "people_distances",
    "pool",
    "position_errors",
    "reacquired",
    "relative_angle_errors",
    "score_tracking",
    "statistic",
    "summarise",
    "tables",
    "times_lost",
    "true_states",
    "turns_deg",
]
