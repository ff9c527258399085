"""The tracker: one `update` per frame."""

from __future__ import annotations

from topview.records import Frame, Person
from topview.track.settings import TrackerSettings


class Tracker:
    """Tracks every person in a stream of frames.

    for frame in topview.open(path):
        people = tracker.update(frame)
    """

    def __init__(self, settings: TrackerSettings | None = None) -> None:
        self.settings = settings or TrackerSettings()

    def update(self, frame: Frame) -> list[Person]:
        """The people in the next frame, nearest first."""
        return []
