"""Track a whole recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.camera import undistorted
from topview.records import Frame, Person, Recording
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track.backwards import tracked_backwards
from topview.track.offline import looked_at_both_ways
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker
from topview.version import installed_version

OnFrame = Callable[[Frame, list[Person]], None]
KeepFrame = Callable[[TrackedFrame], None]


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


class TrackingRun:
    """A recording on its way through a tracker.

    Attributes:
        about: what belongs to no frame.
        frame_count: how many frames were tracked so far.
        seconds: spent in `Tracker.update` alone.
        interrupted: True once Ctrl-C has ended it.
    """

    def __init__(
        self,
        recording: Recording,
        tracker: Tracker,
        gravity_camera: Sequence[float] | None = None,
        *,
        offline: bool = False,
    ) -> None:
        """
        Args:
            recording: what to track.
            tracker: a new one.
            gravity_camera: [3] points down in the camera's frame, in place of what the recording
                and the floor say.
            offline: the frames are going to be looked at both ways in time
                (`topview.track.offline`), which the settings then tell.

        Raises:
            InputError: gravity does not point down.
        """
        self._recording = recording
        self._tracker = tracker
        self._floor_camera: tuple[float, ...] | None = None
        settings: dict[str, Any] = {"recording": recording.name, **tracker.settings_as_json()}
        if getattr(recording, "is_mirrored", False):
            settings["mirrored"] = True
        if offline:
            settings["offline"] = True
        camera = recording.camera
        if gravity_camera is not None:
            camera = replace(camera, gravity_camera=np.array(gravity_camera))
        self.about = About(
            OUTPUT_JOINT_NAMES,
            PART_NAMES,
            settings,
            camera,
            installed_version(),
        )
        self.frame_count = 0
        self.seconds = 0.0
        self.interrupted = False

    def follow(self, keep: KeepFrame, on_frame: OnFrame | None = None) -> None:
        """Track every readable frame, or all until Ctrl-C. Each is kept as soon as it is done, then
        `on_frame` is told of it, undistorted. Errors of the recording, the tracker and both
        functions are raised."""
        try:
            for frame in map(undistorted, self._recording):
                start = perf_counter()
                people = self._tracker.update(frame)
                self.seconds += perf_counter() - start
                keep(self._tracked(frame, people))
                self.frame_count += 1
                if on_frame is not None:
                    on_frame(frame, people)
        except KeyboardInterrupt:
            self.interrupted = True

    def backwards(self) -> Iterator[TrackedFrame]:
        """The frames once more, as a new tracker with the same settings sees them from the last to
        the first (`topview.track.backwards`); the recording is read again."""
        return tracked_backwards(read_again(self._recording), self._tracker.settings, self.about)

    @property
    def frames_per_second(self) -> float:
        return self.frame_count / self.seconds if self.seconds > 0 else 0.0

    def _tracked(self, frame: Frame, people: list[Person]) -> TrackedFrame:
        floor = self._tracker.finder.floor
        if floor is not None:
            self._floor_camera = (*floor.normal_camera.tolist(), float(floor.distance_m))
        name = frame.name or str(frame.index)
        packed = self.about.packed(people)
        return TrackedFrame(frame.index, frame.timestamp_s, name, packed, self._floor_camera)


def read_again(recording: Recording) -> Iterator[Frame]:
    """The frames of a stored recording that was read before, undistorted; what cannot be read is
    not told of once more."""
    problems = list(recording.problems)
    try:
        yield from map(undistorted, recording)
    finally:
        recording.problems[:] = problems


def track_recording(
    recording: Recording,
    settings: TrackerSettings | None = None,
    on_frame: OnFrame | None = None,
    tracker: Tracker | None = None,
    *,
    offline: bool = False,
) -> TrackingResult:
    """Run a new tracker, made of `settings` or given, over every readable frame, as
    `TrackingRun.follow`; all is kept in memory. With `offline` the frames are then looked at both
    ways in time, for which the recording is read and tracked once more, backwards, unless the
    tracker was given, as nobody else could make such a one; `on_frame` is told of them before."""
    run = TrackingRun(recording, tracker or Tracker(settings), offline=offline)
    frames: list[TrackedFrame] = []
    run.follow(frames.append, on_frame)
    if offline and frames:
        backward: Iterator[TrackedFrame] = iter(())
        if tracker is None and not run.interrupted:
            backward = run.backwards()
        frames = list(looked_at_both_ways(frames, run.about.settings, backward))
    skeletons = SkeletonSequence.from_frames(frames, run.about)
    return TrackingResult(skeletons, run.seconds, run.interrupted)


def track_offline(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """As `track_recording` with `offline`."""
    return track_recording(recording, settings, offline=True)
