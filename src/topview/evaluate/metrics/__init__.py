"""Metrics over skeleton sequences, whoever made them: people found, joint distances, part axes.

`evaluate_sequence` measures one recording; `Evaluation.pooled` joins recordings; `summarise` turns
what was measured into the numbers of the tables.
"""

from topview.evaluate.metrics.errors import (
    BONES,
    Bone,
    Evaluation,
    Samples,
    SequenceErrors,
    evaluate_sequence,
    measure_sequence,
)
from topview.evaluate.metrics.matching import (
    GATE_M,
    PeopleCounts,
    count_people,
    match_people,
    mean_joint_distances,
)
from topview.evaluate.metrics.reference import ReferenceSequence
from topview.evaluate.metrics.summary import (
    Comparison,
    Offsets,
    SequenceSummary,
    Statistic,
    Summary,
    statistic,
    summarise,
)

__all__ = [
    "BONES",
    "GATE_M",
    "Bone",
    "Comparison",
    "Evaluation",
    "Offsets",
    "PeopleCounts",
    "ReferenceSequence",
    "Samples",
    "SequenceErrors",
    "SequenceSummary",
    "Statistic",
    "Summary",
    "count_people",
    "evaluate_sequence",
    "match_people",
    "mean_joint_distances",
    "measure_sequence",
    "statistic",
    "summarise",
]
