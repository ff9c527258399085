"""Run trackers over recordings in several processes, and measure each recording there."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from topview.records import InputError, Recording
from topview.track.run import TrackingResult, track_recording
from topview.track.settings import TrackerSettings
from topview_lab.datasets import EvaluatedRecording, KnowsReference, check_same_frames
from topview_lab.metrics import Evaluation, SequenceErrors, measure_sequence

Track = Callable[[Recording, TrackerSettings], TrackingResult]


@dataclass(frozen=True, slots=True)
class Outcome:
    """One recording: its errors, or None and why; what could not be read, one line each."""

    errors: SequenceErrors | None
    problems: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EvaluationRun:
    """A data set that was run through.

    Attributes:
        evaluation: the recordings that were measured, in the order that they were given.
        problems: what could not be read, one line each.
        planned: how many recordings were given.
        interrupted: True if Ctrl-C ended it early.
    """

    evaluation: Evaluation
    problems: tuple[str, ...]
    planned: int
    interrupted: bool


@dataclass(frozen=True, slots=True)
class Job:
    """One recording to be tracked and measured, in any process.

    Attributes:
        recording: what to track.
        settings: of the tracker.
        track: the tracker, importable by its name; another one can be measured in its place.
    """

    recording: EvaluatedRecording
    settings: TrackerSettings
    track: Track = track_recording

    def __call__(self) -> Outcome:
        name = self.recording.name
        try:
            recording = self.recording.open()
            if isinstance(recording, KnowsReference):
                result = tracked_whole(recording, self.settings, self.track)
                reference = recording.reference()
            else:  # the reference first: it may be unreadable
                reference = self.recording.reference()
                check_same_frames(recording, reference)
                result = tracked_whole(recording, self.settings, self.track)
            errors = measure_sequence(result.skeletons, reference, name, result.seconds)
        except InputError as error:
            return Outcome(None, (f"{name}: {error}",))
        problems = tuple(f"{name}: {problem}" for problem in recording.problems)
        return Outcome(errors, problems)


def tracked_whole(recording: Recording, settings: TrackerSettings, track: Track) -> TrackingResult:
    """A recording that was tracked to its end; Ctrl-C ends all that is measured."""
    result = track(recording, settings)
    if result.interrupted:
        raise KeyboardInterrupt
    return result


def run_evaluation(
    recordings: Sequence[EvaluatedRecording],
    settings: TrackerSettings,
    workers: int = 0,
    track: Track = track_recording,
    console: Console | None = None,
) -> EvaluationRun:
    """Track and measure every recording, with a progress bar.

    The numbers do not depend on `workers` (the speed aside): each recording has a tracker of its
    own with one thread. An unreadable recording is named in `problems`, the rest goes on. Ctrl-C
    ends the run and keeps the recordings that are done.

    Args:
        recordings: what to track.
        settings: of the tracker; `threads` is taken to be 1.
        workers: processes, 0 for one per core. More than one start anew, so a script that calls
            this must guard its start with `if __name__ == "__main__"`.
        track: the tracker, importable by its name; another one can be measured in its place.
        console: where the progress bar goes, stderr if None.
    """
    settings = replace(settings, threads=1)
    return run_jobs([Job(recording, settings, track) for recording in recordings], workers, console)


def run_jobs(
    jobs: Sequence[Callable[[], Outcome]],
    workers: int = 0,
    console: Console | None = None,
    what: str = "tracking",
) -> EvaluationRun:
    """As `run_evaluation`, for jobs of any kind that measure a recording each."""
    done = run_all(jobs, workers, console, what)
    outcomes = [outcome for outcome in done.results if outcome is not None]
    return EvaluationRun(
        Evaluation(tuple(outcome.errors for outcome in outcomes if outcome.errors is not None)),
        tuple(problem for outcome in outcomes for problem in outcome.problems) + done.problems,
        len(jobs),
        done.interrupted,
    )


Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class JobResults(Generic[Result]):
    """Results of many jobs.

    Attributes:
        results: of each job, None if it was not done.
        problems: other failures, one line each.
        interrupted: True if Ctrl-C ended it early.
    """

    results: tuple[Result | None, ...]
    problems: tuple[str, ...]
    interrupted: bool


def run_all(
    jobs: Sequence[Callable[[], Result]],
    workers: int = 0,
    console: Console | None = None,
    what: str = "tracking",
) -> JobResults[Result]:
    """Do picklable jobs in several processes, with a progress bar; see `run_evaluation`."""
    if workers < 0:
        raise InputError(f"workers is {workers}; it must be 0 (one per core) or more")
    workers = min(workers or os.cpu_count() or 1, len(jobs))
    results: list[Result | None] = [None] * len(jobs)
    interrupted = False
    died: tuple[str, ...] = ()
    with _progress_bar(console) as progress:
        task = progress.add_task(what, total=len(jobs))
        try:
            for i, result in _results(jobs, workers):
                results[i] = result
                progress.advance(task)
        except KeyboardInterrupt:
            interrupted = True
        except BrokenProcessPool:
            died = (
                f"one of {workers} processes was killed, for lack of memory perhaps; use fewer",
            )
    return JobResults(tuple(results), died, interrupted)


def _call(job: Callable[[], Result]) -> Result:
    return job()


def _results(jobs: Sequence[Callable[[], Result]], workers: int) -> Iterator[tuple[int, Result]]:
    """Index and result of each job, as they are done."""
    if workers <= 1:
        yield from ((i, job()) for i, job in enumerate(jobs))
        return
    others = multiprocessing.active_children()
    # Spawned, not forked: the parent's threads would not survive a fork.
    executor = ProcessPoolExecutor(
        workers, multiprocessing.get_context("spawn"), initializer=_ignore_interrupts
    )
    try:
        index = {executor.submit(_call, job): i for i, job in enumerate(jobs)}
        for future in as_completed(index):
            yield index[future], future.result()
    except BaseException:
        # Without waiting for the jobs that are under way.
        executor.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()).difference(others):
            child.terminate()
        raise
    executor.shutdown()


def _ignore_interrupts() -> None:
    """Ctrl-C reaches every process of the terminal; the parent alone decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _progress_bar(console: Console | None) -> Progress:
    console = console or Console(stderr=True)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=console,
        disable=not console.is_terminal,
    )
