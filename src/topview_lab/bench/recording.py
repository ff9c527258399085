"""Time the tracker on a recording of one's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from topview.records import Frame, InputError, Recording
from topview.track.settings import TrackerSettings
from topview_lab.bench.tracking import (
    WARM_UP_FRAMES,
    FrameTime,
    TrackingTime,
    summarise_times,
    time_frames,
)

DEFAULTS = TrackerSettings()


@dataclass(frozen=True, slots=True)
class TimedRecording:
    """Which frames of a recording were timed, and how long they took.

    Attributes:
        name: of the recording.
        first_frame, last_frame: numbers of the first and the last timed frame.
        warm_up_frames: tracked before them, and not timed.
        colored_frames: timed frames that have a colour image.
        problems: frames that could not be read, one line each.
        tracking: the times, one entry for each number of threads.
    """

    name: str
    first_frame: int
    last_frame: int
    warm_up_frames: int
    colored_frames: int
    problems: tuple[str, ...]
    tracking: tuple[TrackingTime, ...]

    @property
    def frames(self) -> int:
        """How many were timed."""
        return self.tracking[0].frames


def time_recording(
    recording: Recording,
    thread_counts: Sequence[int],
    frames: int | None = None,
    on_frame: Callable[[], None] = lambda: None,
    settings: TrackerSettings = DEFAULTS,
) -> TimedRecording:
    """Track the start of a recording once with each number of threads.

    Args:
        recording: iterated over once for each number of threads.
        thread_counts: one or more.
        frames: to time, all of them if None.
        on_frame: called after each timed frame.
        settings: of the tracker; its threads are those of `thread_counts`.

    Raises:
        InputError: there are too few frames that can be read.
    """
    end = None if frames is None else WARM_UP_FRAMES + frames
    tracking: list[TrackingTime] = []
    problems: dict[str, None] = {}
    times: list[FrameTime] = []
    colored: set[int] = set()
    for threads in thread_counts:
        times = []
        colored.clear()
        noted = _noting_color(islice(recording, end), colored)
        for time in time_frames(noted, replace(settings, threads=threads)):
            times.append(time)
            on_frame()
        problems |= dict.fromkeys(recording.problems)
        if not times:
            raise InputError(
                f"{recording.name}: too few of its frames could be read{_of(recording)}; there "
                f"must be more than {WARM_UP_FRAMES}, as the first {WARM_UP_FRAMES} are not timed"
            )
        tracking.append(summarise_times(times, recording.camera, threads))
    return TimedRecording(
        name=recording.name,
        first_frame=times[0].index,
        last_frame=times[-1].index,
        warm_up_frames=WARM_UP_FRAMES,
        colored_frames=sum(time.index in colored for time in times),
        problems=tuple(problems),
        tracking=tuple(tracking),
    )


def _of(recording: Recording) -> str:
    count = recording.frame_count
    return "" if count is None else f" (it has {count})"


def _noting_color(frames: Iterator[Frame], colored: set[int]) -> Iterator[Frame]:
    """The same frames; adds the numbers of those that have a colour image to `colored`."""
    for frame in frames:
        if frame.color is not None:
            colored.add(frame.index)
        yield frame
