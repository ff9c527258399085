"""Track a whole recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

from topview.body import JOINT_NAMES, PART_NAMES
from topview.camera import undistorted
from topview.records import Frame, Person, Recording, SkeletonSequence
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker

OnFrame = Callable[[Frame, list[Person]], None]


@dataclass(frozen=True, slots=True)
class TrackingResult:
    """A tracked recording.

    Attributes:
        skeletons: every frame that could be read and was tracked.
        seconds: spent in `Tracker.update` alone, reading and writing left out.
        interrupted: True if Ctrl-C ended it early; `skeletons` then holds what was tracked so far.
    """

    skeletons: SkeletonSequence
    seconds: float
    interrupted: bool

    @property
    def frames_per_second(self) -> float:
        return len(self.skeletons.frame_index) / self.seconds if self.seconds > 0 else 0.0


def track_recording(
    recording: Recording,
    settings: TrackerSettings | None = None,
    on_frame: OnFrame | None = None,
    tracker: Tracker | None = None,
) -> TrackingResult:
    """Run a new tracker, made of `settings` or given, over every readable frame; `on_frame` is told
    of each, undistorted, as it is done."""
    tracker = tracker or Tracker(settings)
    tracked: list[tuple[int, float, list[Person]]] = []
    seconds = 0.0
    interrupted = False
    try:
        for frame in map(undistorted, recording):
            start = perf_counter()
            people = tracker.update(frame)
            seconds += perf_counter() - start
            tracked.append((frame.index, frame.timestamp_s, people))
            if on_frame is not None:
                on_frame(frame, people)
    except KeyboardInterrupt:
        interrupted = True
    skeletons = SkeletonSequence.from_people(
        tracked,
        JOINT_NAMES,
        PART_NAMES,
        {"recording": recording.name, **tracker.settings_as_json()},
    )
    return TrackingResult(skeletons, seconds, interrupted)
