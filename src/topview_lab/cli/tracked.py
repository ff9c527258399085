"""What every `topview evaluate` command that tracks has in common: options, running, telling."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Protocol, TypeVar

import msgspec
from cyclopts import Parameter
from rich.table import Table

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import compile_kernels, warn
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.detect.detectors import DetectorName
from topview.detect.joints.proposers import ProposalsName
from topview.io import write_atomically
from topview.records import InputError
from topview.track import Tracker, TrackerSettings
from topview_lab.evaluate.run import run_all
from topview_lab.metrics import Offsets

DEFAULTS = TrackerSettings()


@Parameter(name="*")
@dataclass(frozen=True)
class TrackedOptions:
    """What everything that is tracked to be measured takes.

    Attributes:
        sequences: globs over the names of the sequences, separated by commas.
        method: the tracker's method.
        detector: how people's heads are found.
        seed: of every random number.
        proposals: what proposes joints to methods that ask for it.
        weights: file of the network's weights.
        json: file for all numbers.
        force: replace the file that is there.
        workers: processes, 0 for one per core; the numbers do not depend on it.
        per_sequence: add a table of the sequences, worst first.
    """

    sequences: str = "*"
    method: str = DEFAULTS.method
    detector: DetectorName = DEFAULTS.detector
    seed: int = DEFAULTS.seed
    proposals: ProposalsName = DEFAULTS.proposals
    weights: Path | None = None
    json: Path | None = None
    force: Annotated[bool, Parameter(negative="")] = False
    workers: int = 0
    per_sequence: Annotated[bool, Parameter(negative="")] = False

    @property
    def settings(self) -> TrackerSettings:
        return TrackerSettings(
            self.method, self.detector, self.seed, 1, self.proposals, self.weights
        )


@Parameter(name="*")
@dataclass(frozen=True)
class EvaluateOptions(TrackedOptions):
    """What every data set with skeletons takes.

    Attributes:
        detail: add tables by cause of occlusion, part, action and body, and of the confidences.
        offsets: one constant offset per joint for the whole set, or for each person of each
            recording.
        offline: look both ways in time, as `topview track --offline` does.
        predictions: measure the skeletons of these files instead of the tracker: a folder with
            NAME.npz or NAME/skeletons.npz of each sequence, or one file.
        map: names of their joints in ours, like nose=head,chest=torso, besides the known ones.
        worst: file for a picture (PNG) of the worst moments of the ten worst recordings.
    """

    detail: Annotated[bool, Parameter(negative="")] = False
    offsets: Offsets = "set"
    offline: Annotated[bool, Parameter(negative="")] = False
    predictions: Path | None = None
    map: str = ""
    worst: Path | None = None

    def made_by(self) -> dict[str, Any]:
        """What the measured skeletons come from, for the file of numbers."""
        if self.predictions is None:
            return self.settings.as_json() | ({"offline": True} if self.offline else {})
        return {"predictions": str(self.predictions), "map": self.map}


TRACKED_OPTIONS = TrackedOptions()
DEFAULT_OPTIONS = EvaluateOptions()


class Outcome(Protocol):
    """What a job gives."""

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be read, one line each."""
        ...


AnyOutcome = TypeVar("AnyOutcome", bound=Outcome)


@dataclass(frozen=True)
class Told:
    """What is told of some outcomes.

    Attributes:
        measured: how many of them were measured.
        tables: to be printed.
        each: those of single sequences.
        numbers: all of them by what they are, in JSON types.
    """

    measured: int
    tables: Sequence[Table]
    each: Sequence[Table]
    numbers: dict[str, Any]


def measure_all(
    jobs: Sequence[Callable[[], AnyOutcome]],
    options: TrackedOptions,
    tell: Callable[[Sequence[AnyOutcome]], Told],
) -> int:
    """Do the jobs, tell what they gave, and write it; the exit status.

    Raises:
        InputError: the tracker or the file cannot be used, or nothing could be measured.
    """
    check_output(options)
    check_tracker(options)
    run = run_all(jobs, options.workers)
    done = [outcome for outcome in run.results if outcome is not None]
    warn(*(problem for outcome in done for problem in outcome.problems), *run.problems)
    told = tell(done)
    if told.measured:
        console = plain_console()
        for table in (*told.tables, *(told.each if options.per_sequence else ())):
            console.print(table)
        if options.json is not None:
            report = {"settings": options.settings.as_json(), **told.numbers}
            write_atomically(options.json, msgspec.json.format(msgspec.json.encode(report)))
    return status(told.measured, len(jobs), run.interrupted)


def numbers(option: str, text: str) -> tuple[int, ...]:
    """Whole numbers and ranges of them, like 1,2,3 or 1-20.

    Raises:
        InputError: it is something else.
    """
    if not re.fullmatch("[0-9]{1,9}(-[0-9]{1,9})?(,[0-9]{1,9}(-[0-9]{1,9})?)*", text):
        raise InputError(f"{option} is {text!r}; it must be whole numbers like 1,2,3 or 1-20")
    return tuple(number for part in text.split(",") for number in _range(option, part))


MOST_NUMBERS = 10_000  # of one range; ours


def _range(option: str, text: str) -> Iterator[int]:
    first, _, last = text.partition("-")
    count = int(last or first) - int(first) + 1
    if not 1 <= count <= MOST_NUMBERS:
        raise InputError(
            f"{option} has {text!r}; a range must go up, by {MOST_NUMBERS} numbers at most"
        )
    yield from range(int(first), int(first) + count)


def check_output(options: TrackedOptions) -> None:
    """Not to find out after the last recording."""
    if options.json is not None:
        prepare_output_file("--json", options.json, options.force)


def check_tracker(options: TrackedOptions) -> None:
    """What cannot be used is told once, not for each recording."""
    Tracker(options.settings)
    compile_kernels()


def status(measured: int, planned: int, interrupted: bool) -> int:
    """Exit status after so many of the planned recordings were measured."""
    if interrupted:
        warn(f"interrupted: {measured} of {planned} recordings")
        return INTERRUPTED
    if not measured:
        raise InputError(f"none of the {planned} recordings could be evaluated")
    return 0 if measured == planned else UNUSABLE_INPUT
