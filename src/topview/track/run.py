"""Track a whole recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, PART_NAMES
from topview.camera import undistorted
from topview.people.floor import FloorPlane
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


class TrackingRun:
    """A recording on its way through a tracker; what was tracked so far can be had at any time,
    whatever ended it."""

    def __init__(self, recording: Recording, tracker: Tracker) -> None:
        self._recording = recording
        self._tracker = tracker
        self._tracked: list[tuple[int, float, list[Person]]] = []
        self._names: list[str] = []
        self._floor: FloorPlane | None = None
        self._seconds = 0.0
        self._interrupted = False

    @property
    def frame_count(self) -> int:
        """How many frames were tracked so far."""
        return len(self._tracked)

    def follow(self, on_frame: OnFrame | None = None) -> None:
        """Track every readable frame, or all until Ctrl-C; `on_frame` is told of each, undistorted,
        as it is done. Other errors are raised."""
        try:
            for frame in map(undistorted, self._recording):
                start = perf_counter()
                people = self._tracker.update(frame)
                self._seconds += perf_counter() - start
                self._names.append(frame.name or str(frame.index))
                self._tracked.append((frame.index, frame.timestamp_s, people))
                self._floor = self._tracker.finder.floor or self._floor
                if on_frame is not None:
                    on_frame(frame, people)
        except KeyboardInterrupt:
            self._interrupted = True

    def result(self) -> TrackingResult:
        """What was tracked so far."""
        skeletons = SkeletonSequence.from_people(
            self._tracked,
            JOINT_NAMES,
            PART_NAMES,
            {"recording": self._recording.name, **self._tracker.settings_as_json()},
            frame_names=tuple(self._names[: self.frame_count]),
            camera=self._recording.camera,
            topview_version=_version(),
            **_vertical(self._floor),
        )
        return TrackingResult(skeletons, self._seconds, self._interrupted)


def track_recording(
    recording: Recording,
    settings: TrackerSettings | None = None,
    on_frame: OnFrame | None = None,
    tracker: Tracker | None = None,
) -> TrackingResult:
    """Run a new tracker, made of `settings` or given, over every readable frame; as
    `TrackingRun.follow`."""
    run = TrackingRun(recording, tracker or Tracker(settings))
    run.follow(on_frame)
    return run.result()


def _vertical(floor: FloorPlane | None) -> dict[str, NDArray[np.float64]]:
    """The floor as it was seen last, and what is down by it."""
    if floor is None:
        return {}
    return {
        "floor_camera": np.append(floor.normal_camera, floor.distance_m),
        "gravity_camera": -floor.normal_camera,
    }


def _version() -> str:
    """Of this package; empty where it was never installed."""
    try:
        return version("topview")
    except PackageNotFoundError:
        return ""
