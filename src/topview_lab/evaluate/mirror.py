"""Does the tracker treat left and right alike? A recording against its mirror image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES
from topview.io import MirroredRecording
from topview.records import Recording
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.metrics.mirror import Apart, measure_apart, mirrored_joints


def compare_with_mirror_image(recording: Recording, settings: TrackerSettings) -> Apart:
    """Track a recording and its images flipped left-right; how far the first lies from the second,
    flipped back. Random numbers are not mirrored, so that some way remains."""
    seen, flipped = (
        _joints_tracked(each, settings) for each in (recording, MirroredRecording(recording))
    )
    return measure_apart(seen, mirrored_joints(flipped))


def compare_with_other_seed(
    recording: Recording, settings: TrackerSettings, other: TrackerSettings
) -> Apart:
    """How far two trackings of a recording lie apart that differ in their settings, as the seed:
    what random numbers alone do."""
    first, second = (_joints_tracked(recording, each) for each in (settings, other))
    return measure_apart(first, second)


def _joints_tracked(recording: Recording, settings: TrackerSettings) -> NDArray[np.float64]:
    """[F, S, 16, 3] in the order of `JOINT_NAMES`, metres."""
    skeletons = track_recording(recording, settings).skeletons
    columns = [skeletons.joint_names.index(name) for name in JOINT_NAMES]
    return skeletons.joints_camera[:, :, columns]
