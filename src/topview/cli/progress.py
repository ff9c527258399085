"""Tracking with a progress bar, and what is said of it afterwards; shared by the subcommands."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from time import perf_counter
from typing import Final

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TaskProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)

from topview.cli.printing import plain_console
from topview.kernels.caching import lasts
from topview.kernels.compiling import compile_ahead, is_compiled
from topview.lines import as_line
from topview.records import Frame, Person, Recording
from topview.skeletons import TrackedFrame
from topview.track import KeepFrame, TrackingRun
from topview.view import Viewer

REPORT_S: Final = 30.0  # ours; between two lines where there is no bar


def compile_kernels() -> None:
    """Compile what the tracker calls, if that has not been done before, and say so on stderr."""
    if is_compiled():
        return
    said = "compiling (once)" if lasts() else "compiling (at every start: no folder to keep it in)"
    console = plain_console(stderr=True)
    if not console.is_terminal:
        warn(said)
    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn()
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as progress:
        bar = progress.add_task(said, total=1.0)
        compile_ahead(lambda share: progress.update(bar, completed=share))


def progress_bar(*more: ProgressColumn) -> Progress:
    """A bar on stderr that vanishes at the end; none where stderr is not a terminal."""
    console = plain_console(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        *more,
    )
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


def follow_with_progress(
    run: TrackingRun, recording: Recording, viewer: Viewer, keep: KeepFrame
) -> None:
    """Track a recording, keeping every frame, showing it to the viewer, and the bar on stderr; or
    a line there now and then, where that is no terminal."""
    compile_kernels()
    told_of = TextColumn(
        "{task.fields[rate]:.1f} frames/s  {task.fields[people]} in view{task.fields[late]}"
    )
    with progress_bar(told_of, TimeRemainingColumn()) as progress:
        bar = progress.add_task(
            f"tracking {recording.name}", total=recording.frame_count, rate=0, people=0, late=""
        )
        say = _now_and_then(progress)
        start = perf_counter()
        done = 0

        def on_frame(frame: Frame, people: list[Person]) -> None:
            nonlocal done
            done += 1
            rate = done / (perf_counter() - start)
            progress.update(
                bar, advance=1, rate=rate, people=len(people), late=_lateness(recording)
            )
            say(_so_far(done, recording.frame_count, rate))
            viewer.show(frame, people)

        run.follow(keep, on_frame)


def with_progress(
    frames: Iterable[TrackedFrame], said: str, frame_count: int
) -> Iterator[TrackedFrame]:
    """The same frames, with the bar on stderr, or a line there now and then."""
    with progress_bar(TimeRemainingColumn()) as progress:
        bar = progress.add_task(said, total=frame_count)
        say = _now_and_then(progress)
        start = perf_counter()
        for done, frame in enumerate(frames, start=1):
            progress.update(bar, advance=1)
            say(f"{said}: {_so_far(done, frame_count, done / (perf_counter() - start))}")
            yield frame


def _now_and_then(progress: Progress) -> Callable[[str], None]:
    """Says a line on stderr where there is no bar, unless one was said a moment ago."""
    told = perf_counter()

    def say(line: str) -> None:
        nonlocal told
        now = perf_counter()
        if progress.disable and now - told > REPORT_S:
            told = now
            warn(line)

    return say


def _lateness(recording: Recording) -> str:
    """How late the skeletons of a live camera are; empty for what is stored."""
    latencies_s = getattr(recording, "latencies_s", None)
    return f"  {1e3 * latencies_s[-1]:.0f} ms late" if latencies_s else ""


def _so_far(done: int, frame_count: int | None, rate: float) -> str:
    """How far a run has come, and how many seconds are left if anybody can know."""
    if frame_count is None:
        return f"{done} frames, {rate:.1f} frames/s"
    left_s = (frame_count - done) / rate
    return f"{done} of {frame_count} frames, {rate:.1f} frames/s, {left_s:.0f} s left"


def print_frames(run: TrackingRun, recording: Recording, *, ended_early: bool = False) -> None:
    """How many frames were read and how fast, on stdout; what was not, on stderr, unless the run
    ended before it came to them."""
    tracked = run.frame_count
    expected = tracked if recording.frame_count is None else recording.frame_count
    print(f"{tracked} of {expected} frames, {run.frames_per_second:.1f} frames/s")
    if tracked < expected and not (run.interrupted or ended_early):
        warn(f"{expected - tracked} of {expected} frames could not be read")


def warn(*lines: str) -> None:
    """One line each on stderr."""
    for line in lines:
        print(f"topview: {as_line(line)}", file=sys.stderr)
