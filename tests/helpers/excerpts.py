"""The first frames of a recording, read once and kept, to be tracked more than once."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from topview.records import Frame, Recording
from topview.track.run import track_recording
from topview.track.settings import TrackerSettings
from topview_lab.metrics import Evaluation, ReferenceSequence, Summary, measure_sequence, summarise


class Excerpt:
    """The first `count` frames."""

    def __init__(self, recording: Recording, count: int) -> None:
        self.name = recording.name
        self.camera = recording.camera
        self._frames = list(islice(recording, count))
        self.problems = list(recording.problems)

    @property
    def frame_count(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self._frames)


def measured(
    recording: Recording, reference: ReferenceSequence, settings: TrackerSettings
) -> Summary:
    """Track and compare with the truth."""
    skeletons = track_recording(recording, settings).skeletons
    return summarise(Evaluation((measure_sequence(skeletons, reference, recording.name),)))
