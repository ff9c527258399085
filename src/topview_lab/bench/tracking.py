"""Time the tracker frame by frame, on simulated scenes and on recordings of any kind."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from statistics import median
from time import perf_counter
from typing import Final

from topview.records import Camera, Frame
from topview.track import Tracker, TrackerSettings
from topview_lab.sim import SimulatedRecording, scene_by_name

WARM_UP_FRAMES: Final = 3
"""Frames at the start of a recording that are tracked and not timed: the first finds the people
and starts their poses, the next ones follow them (ours)."""
TWO_USERS_SCENE: Final = "pass_by"
"""The scene of `topview demo`: one person stands, another one passes in front."""


@dataclass(frozen=True, slots=True)
class FrameTime:
    """One tracked frame: its number, how many people were tracked, and milliseconds in all and in
    each stage that ran."""

    index: int
    people: int
    ms: float
    stages_ms: dict[str, float]


@dataclass(frozen=True, slots=True)
class GroupTime:
    """Medians over the frames in which the same number of people was tracked, in milliseconds.

    Attributes:
        ms_per_person: a frame's time over its number of people; None if there was nobody.
    """

    frames: int
    ms_per_frame: float
    ms_per_person: float | None


@dataclass(frozen=True, slots=True)
class TrackingTime:
    """Medians over the timed frames of one recording, in milliseconds.

    Attributes:
        width, height: of its images.
        people: in the simulated scene; None for a recording of unknown content.
        threads: that the kernels used.
        frames: how many were timed.
        ms_per_person: a frame's time over the number of people tracked in it; None if nobody was.
        p90_ms_per_frame: nine frames of ten take no longer.
        stages_ms: over the frames in which the stage ran.
        stages_ms_per_person: the same over the number of people, where anybody was tracked.
        by_people: the frames sorted by the number of people tracked in them.
    """

    width: int
    height: int
    people: int | None
    threads: int
    frames: int
    ms_per_frame: float
    ms_per_person: float | None
    p90_ms_per_frame: float
    stages_ms: dict[str, float]
    stages_ms_per_person: dict[str, float]
    by_people: dict[int, GroupTime]


def simulated_frames(
    camera: Camera, people: int, frames: int, scene_name: str = TWO_USERS_SCENE
) -> Iterator[Frame]:
    """`WARM_UP_FRAMES` and then `frames` frames of a scene of the simulator."""
    scene = scene_by_name(scene_name, camera=camera, people=people, frames=WARM_UP_FRAMES + frames)
    yield from SimulatedRecording(scene)


def time_frames(frames: Iterable[Frame], settings: TrackerSettings) -> Iterator[FrameTime]:
    """Track frames with a new tracker, and time all but the first `WARM_UP_FRAMES`.

    Making or reading the frames is not timed.
    """
    tracker = Tracker(settings)
    rest = iter(frames)
    for frame in islice(rest, WARM_UP_FRAMES):
        tracker.update(frame)
    for frame in rest:
        start = perf_counter()
        people = len(tracker.update(frame))
        ms = 1e3 * (perf_counter() - start)
        stages_ms = {name: 1e3 * seconds for name, seconds in tracker.clock.seconds.items()}
        yield FrameTime(frame.index, people, ms, stages_ms)


def summarise_times(
    times: Sequence[FrameTime], camera: Camera, threads: int, people: int | None = None
) -> TrackingTime:
    """The medians of at least one frame's times; `people` as in `TrackingTime`."""
    counts = sorted({time.people for time in times})
    stages = dict.fromkeys(name for time in times for name in time.stages_ms)
    peopled = [time for time in times if time.people]
    whole = _group(times)
    return TrackingTime(
        width=camera.width,
        height=camera.height,
        people=people,
        threads=threads,
        frames=whole.frames,
        ms_per_frame=whole.ms_per_frame,
        ms_per_person=whole.ms_per_person,
        p90_ms_per_frame=_p90(time.ms for time in times),
        stages_ms={
            name: median(time.stages_ms[name] for time in times if name in time.stages_ms)
            for name in stages
        },
        stages_ms_per_person={
            name: median(shares)
            for name in stages
            if (shares := [t.stages_ms[name] / t.people for t in peopled if name in t.stages_ms])
        },
        by_people={
            count: _group([time for time in times if time.people == count]) for count in counts
        },
    )


def _group(times: Sequence[FrameTime]) -> GroupTime:
    shares = [time.ms / time.people for time in times if time.people]
    return GroupTime(
        len(times), median(time.ms for time in times), median(shares) if shares else None
    )


def _p90(values: Iterable[float]) -> float:
    """The least value that nine of ten do not exceed."""
    ranked = sorted(values)
    return ranked[-(-9 * len(ranked) // 10) - 1]
