"""Does the tracker treat left and right alike? A recording against its mirror image."""

from __future__ import annotations

from topview.io import MirroredRecording
from topview.records import Recording
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.metrics.mirror import Apart, measure_apart, mirrored_joints


def compare_with_mirror_image(recording: Recording, settings: TrackerSettings) -> Apart:
    """Track a recording and its images flipped left-right; how far the first lies from the second,
    flipped back. Random numbers are not mirrored, so that some way remains."""
    seen, flipped = (
        track_recording(each, settings).skeletons.joints_camera
        for each in (recording, MirroredRecording(recording))
    )
    return measure_apart(seen, mirrored_joints(flipped))


def compare_with_other_seed(
    recording: Recording, settings: TrackerSettings, other: TrackerSettings
) -> Apart:
    """How far two trackings of a recording lie apart that differ in their settings, as the seed:
    what random numbers alone do."""
    first, second = (
        track_recording(recording, each).skeletons.joints_camera for each in (settings, other)
    )
    return measure_apart(first, second)
