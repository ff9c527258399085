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
    names: list[str] = []
    floor: FloorPlane | None = None
    seconds = 0.0
    interrupted = False
    try:
        for frame in map(undistorted, recording):
            start = perf_counter()
            people = tracker.update(frame)
            seconds += perf_counter() - start
            tracked.append((frame.index, frame.timestamp_s, people))
            names.append(frame.name or str(frame.index))
            floor = tracker.finder.floor or floor
            if on_frame is not None:
                on_frame(frame, people)
    except KeyboardInterrupt:
        interrupted = True
    skeletons = SkeletonSequence.from_people(
        tracked,
        JOINT_NAMES,
        PART_NAMES,
        {"recording": recording.name, **tracker.settings_as_json()},
        frame_names=tuple(names),
        camera=recording.camera,
        topview_version=_version(),
        **_vertical(floor),
    )
    return TrackingResult(skeletons, seconds, interrupted)


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
