"""Samples of one recording: every present person, as in the reference and as tracked.

Nothing is averaged here, so that recordings can be measured by several processes and pooled
afterwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only
from topview_lab.metrics.matching import PeopleCounts
from topview_lab.metrics.tracking import TrackingCounts

OUT_OF_VIEW: Final = "out of view"
CAUSES: Final = ("another person", "oneself", "an object", OUT_OF_VIEW)
"""What may hide a joint."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """N person-frames in which a reference person is present, found or not; J joints, B parts.

    Joints are those of `JOINT_NAMES`, parts those of `PART_NAMES`. Wrists and feet, the
    `END_NAMES`, are kept apart: they have a table of their own, and are in no other. Predictions
    are NaN where the person was missed, and everything is NaN where it is unknown.

    Attributes:
        person: [N] int64, which reference person of the recording (column).
        frame: [N] int64, number of the recording's frame.
        time_s: [N] of that frame; all 0 where the system tells no times.
        found: [N] bool.
        stature_m: [N] the scale of the constant offsets: the reference's, else the predicted one.
        reference_camera: [N, J, 3] metres.
        predicted_camera: [N, J, 3] metres.
        Rs_camera_true_part: [N, B, 3, 3] the reference's orientations.
        Rs_camera_part: [N, B, 3, 3] the predicted ones.
        joint_state: [N, J] uint8, an index into `topview.records.JOINT_STATE_NAMES`.
        joint_confidence: [N, J] 0..1.
        joint_covariance_m2: [N, J, 3, 3] of the predicted joints' errors, camera frame.
        hidden: [N, J, 4] share 0..1 of the joint that each of `CAUSES` hides.
        reference_ends_camera, predicted_ends_camera: [N, 4, 3] metres.
        end_state, end_confidence: [N, 4] as `joint_state` and `joint_confidence`.
        hidden_ends: [N, 4, 4] as `hidden`.
        action: [N] str, "" where unknown.
        body: [N] str, "" where unknown.
    """

    person: NDArray[np.int64]
    frame: NDArray[np.int64]
    time_s: NDArray[np.float64]
    found: NDArray[np.bool_]
    stature_m: NDArray[np.float64]
    reference_camera: NDArray[np.float64]
    predicted_camera: NDArray[np.float64]
    Rs_camera_true_part: NDArray[np.float64]
    Rs_camera_part: NDArray[np.float64]
    joint_state: NDArray[np.uint8]
    joint_confidence: NDArray[np.float64]
    joint_covariance_m2: NDArray[np.float64]
    hidden: NDArray[np.float64]
    reference_ends_camera: NDArray[np.float64]
    predicted_ends_camera: NDArray[np.float64]
    end_state: NDArray[np.uint8]
    end_confidence: NDArray[np.float64]
    hidden_ends: NDArray[np.float64]
    action: NDArray[np.str_]
    body: NDArray[np.str_]

    def __post_init__(self) -> None:
        for field in fields(self):
            read_only(getattr(self, field.name))

    @classmethod
    def pooled(cls, parts: Sequence[Samples]) -> Samples:
        """The samples of at least one recording, one after the other."""
        return cls(
            *(
                np.concatenate([getattr(part, field.name) for part in parts])
                for field in fields(cls)
            )
        )


@dataclass(frozen=True, slots=True, eq=False)
class SequenceErrors:
    """The record of one evaluated recording.

    Attributes:
        name: of the recording.
        samples: the people who were there.
        people: counts of people found, missed, false, swapped.
        tracking: counts behind HOTA and MOTP.
        false_confidence: [M, J] confidence of each joint of the M predicted person-frames that
            match nobody, NaN where the joint is not given.
        tracked_frames: how many frames the tracker was given.
        seconds: spent in the tracker, 0 where not measured.
    """

    name: str
    samples: Samples
    people: PeopleCounts
    tracking: TrackingCounts
    false_confidence: NDArray[np.float64]
    tracked_frames: int
    seconds: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """One or several measured recordings."""

    sequences: tuple[SequenceErrors, ...]

    @classmethod
    def pooled(cls, evaluations: Iterable[Evaluation]) -> Evaluation:
        return cls(tuple(s for evaluation in evaluations for s in evaluation.sequences))
