"""What a tracker without proposals has seen of people whose truth is known."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.body.kinematics import joints_from_parts
from topview.body.model import BodyModel
from topview.detect.joints.proposers import NOTHING
from topview.records import InputError
from topview.track import Tracker, TrackerSettings
from topview.track.body_tracker import BodyMethod
from topview.track.pose import Pose
from topview_lab.datasets import EvaluatedRecording

Array = NDArray[np.float64]

# All ours.
SAME_PERSON_M: Final = 0.5  # from a true person's joints to a found one's, on average
TAKEN_EVERY: Final = 4  # frames, of which one is fitted to


@dataclass(frozen=True, slots=True, eq=False)
class SeenPose:
    """A pose that was found, of a body, and [T] traits of it."""

    pose: Pose
    model: BodyModel
    traits: Array

    @property
    def joints_camera(self) -> Array:
        """[16, 3] metres."""
        return joints_from_parts(self.model, self.pose.transforms(self.model))


Seen = TypeVar("Seen", bound=SeenPose)


def found_people(
    recording: EvaluatedRecording, method: BodyMethod, seen: list[Seen]
) -> Iterator[tuple[Seen, Array]]:
    """What is seen of each person in every `TAKEN_EVERY`-th frame of a recording, and the person's
    true joints, [16, 3] metres, camera frame.

    Args:
        recording: with truth.
        method: which tracks it without proposals, and adds to `seen` what it sees of each person.
        seen: which is emptied before each frame.

    Raises:
        InputError: nobody is found.
    """
    reference = recording.reference()
    order = [reference.joint_names.index(name) for name in JOINT_NAMES]
    true_camera = dict(
        zip(reference.frame_index.tolist(), reference.joints_camera[:, :, order], strict=True)
    )
    is_anybody = False
    tracker = Tracker(TrackerSettings(threads=1, proposals=NOTHING), body=method)
    for frame in recording.open():
        seen.clear()
        tracker.update(frame)
        if frame.index % TAKEN_EVERY or frame.index not in true_camera:
            continue
        for own in seen:
            off_m = np.linalg.norm(true_camera[frame.index] - own.joints_camera, axis=-1)
            mean_m = np.where(np.isfinite(off_m).all(1), off_m.mean(1), np.inf)
            if mean_m.min(initial=np.inf) < SAME_PERSON_M:
                is_anybody = True
                yield own, true_camera[frame.index][int(np.argmin(mean_m))]
    if not is_anybody:
        raise InputError("nobody was found whose joints are known")
