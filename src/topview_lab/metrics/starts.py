"""How soon somebody is tracked who is there in the first frame, in whatever pose (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from topview.records import JointState
from topview_lab.metrics.calibration import true_states
from topview_lab.metrics.facing import FACING_DEG, turns_deg
from topview_lab.metrics.samples import SequenceErrors
from topview_lab.metrics.statistics import CM_PER_M, share

START_AFTER_S: Final = 0.5  # ours; what a user waits
START_WITHIN_CM: Final = 15.0  # ours; of a joint whose limb is known
START_SHARE: Final = 0.9  # ours; of visible joints, and of frames that face right
FRAME_ROUNDING_S: Final = 1e-6  # of times that are frames over their rate


@dataclass(frozen=True, slots=True)
class StartScore:
    """One start, over all its frames from `START_AFTER_S` on.

    Attributes:
        joints: share 0..1 of the visible joints that are within `START_WITHIN_CM`, as they are;
            NaN where none is visible.
        facing: share 0..1 of the frames whose trunk is turned by `FACING_DEG` at most.
        found: share 0..1 of the frames in which the person is found; in others nothing holds.
    """

    joints: float
    facing: float
    found: float

    @property
    def holds(self) -> bool:
        """Whether both are `START_SHARE` or more."""
        return self.joints >= START_SHARE and self.facing >= START_SHARE


def score_start(errors: SequenceErrors) -> StartScore:
    """Of a recording of one person; where nobody is found, nothing holds."""
    samples = errors.samples
    is_late = samples.time_s >= START_AFTER_S - FRAME_ROUNDING_S
    truth, found = samples.reference_camera[is_late], samples.predicted_camera[is_late]
    is_visible = true_states(samples.hidden[is_late]) == JointState.VISIBLE
    is_visible &= np.isfinite(truth).all(-1)
    near = np.linalg.norm(found - truth, axis=-1) * CM_PER_M <= START_WITHIN_CM
    faces = turns_deg(truth, found) <= FACING_DEG
    return StartScore(
        share(int((near & is_visible).sum()), int(is_visible.sum())),
        share(int(faces.sum()), len(faces)),
        share(int(samples.found[is_late].sum()), len(faces)),
    )


@dataclass(frozen=True, slots=True)
class StartsSummary:
    """Of several starts.

    Attributes:
        count: how many.
        joints, facing, found: means of theirs, 0..1.
        holds: share 0..1 of the starts that hold.
    """

    count: int
    joints: float
    facing: float
    found: float
    holds: float


def summarise_starts(scores: Sequence[StartScore]) -> StartsSummary:
    """Of at least one start; starts without a visible joint are left out of `joints`."""
    joints = np.array([score.joints for score in scores])
    return StartsSummary(
        len(scores),
        float(np.nanmean(joints)) if np.isfinite(joints).any() else float("nan"),
        float(np.mean([score.facing for score in scores])),
        float(np.mean([score.found for score in scores])),
        float(np.mean([score.holds for score in scores])),
    )
