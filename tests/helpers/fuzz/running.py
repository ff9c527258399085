"""Runs cases in one process, with a limit on memory and an alarm for each, and says how they ended.

`run_apart` starts that process, and another one after the case at which one has died.
"""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from fuzz.cases import Case, cases, write_bases
from topview.lines import MOST_CHARACTERS

MOST_BYTES: Final = 4 * 2**30  # of addresses; imports and compiled kernels take one and a half
MOST_WRITTEN_BYTES: Final = 2**28  # of a file
MOST_SECONDS: Final = 120.0  # of a case, which mostly takes a tenth; a busy machine is no failure
MOST_LINES: Final = 8
MOST_LONGEST: Final = MOST_CHARACTERS + 100  # of a line; the command's name comes before it
FINE: Final = ("result", "clean line")
NOT_MADE: Final = "not made"


@dataclass(frozen=True, slots=True)
class Ending:
    """How a case ended.

    Attributes:
        case: as text.
        outcome: one of `FINE`, or "traceback", "hang", "over memory", "noise", "killed",
            "status N" or `NOT_MADE`.
        said: on stderr, its end; with where a traceback comes from.
        seconds: that it took.
        arguments: of the command.
    """

    case: str
    outcome: str
    said: str
    seconds: float
    arguments: list[str]

    @property
    def is_fine(self) -> bool:
        return self.outcome in FINE


class Overdue(BaseException):
    """The alarm."""


def outcome_of(status: int, said: str) -> str:
    """What an exit status and all that was said on stderr amount to."""
    lines = said.splitlines()
    if status == 1 or "Traceback" in said or "a bug of topview" in said:
        return "traceback"
    if re.search("not enough memory|[Uu]nable to allocate|MemoryError", said):
        return "over memory"
    if status not in (0, 2):
        return f"status {status}"
    is_clean = all(line.startswith("topview: ") for line in lines) and len(lines) <= MOST_LINES
    longest = max(map(len, lines), default=0)
    if not is_clean or longest > MOST_LONGEST or (status and not lines):
        return "noise"
    return "clean line" if status else "result"


def run_case(case: Case, bases: Path, command: Callable[[list[str]], None]) -> Ending:
    """Prepare a case in a folder of its own, and run it there in this process."""
    before = os.getcwd()
    folder = Path(tempfile.mkdtemp(prefix="case-", dir=bases.parent))
    try:
        try:
            arguments = case.prepare(folder, bases)
        except Exception:  # a fault of the corpus, which is to be seen as one
            return Ending(str(case), NOT_MADE, traceback.format_exc()[-3000:], 0.0, [])
        os.chdir(folder)
        start = time.perf_counter()
        status, said = _ended(command, arguments)
        seconds = time.perf_counter() - start
    finally:
        os.chdir(before)
        shutil.rmtree(folder, ignore_errors=True)
    outcome = "hang" if status is None else outcome_of(status, said)
    shown = [argument[:80] for argument in arguments]
    return Ending(str(case), outcome, _with_traceback(said)[-3000:], seconds, shown)


def _ended(command: Callable[[list[str]], None], arguments: list[str]) -> tuple[int | None, str]:
    """The exit status, None if the alarm came first, and what was said on stderr by anybody, C
    libraries too."""
    kept = [os.dup(1), os.dup(2)]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        _direct(out.fileno(), errors.fileno())
        try:
            status = _status_of(command, arguments)
        finally:
            _direct(*kept)
            for number in kept:
                os.close(number)
        errors.seek(0)
        return status, errors.read(2**20).decode("utf-8", "replace")


def _direct(out: int, errors: int) -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    os.dup2(out, 1)
    os.dup2(errors, 2)


def _status_of(command: Callable[[list[str]], None], arguments: list[str]) -> int | None:
    signal.signal(signal.SIGALRM, _on_alarm)
    signal.setitimer(signal.ITIMER_REAL, MOST_SECONDS)
    unlimited = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_WRITTEN_BYTES, unlimited[1]))
    try:
        command(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    except Overdue:
        return None
    except BaseException as error:
        print(f"Traceback: {type(error).__name__}: {error}"[:2000], file=sys.stderr)
        return 1
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        resource.setrlimit(resource.RLIMIT_FSIZE, unlimited)
    return 0


def _on_alarm(*_: object) -> None:
    raise Overdue


def _with_traceback(said: str) -> str:
    """Put the end of a traceback that lies in a file after what was said; remove the file."""
    for name in re.findall(r"\S*topview-bug-\w+\.txt", said):
        path = Path(name)
        if path.exists():
            said += path.read_text()[-1200:]
            path.unlink()
    return said


def run_here(
    numbers: Iterable[int], chosen: list[Case], tell: Callable[[dict[str, Any]], None]
) -> None:
    """Run some of the cases in this process, within limits; each is told of before and after."""
    from topview.cli.main import main

    with tempfile.TemporaryDirectory(prefix="topview-fuzz-") as folder:
        bases = Path(folder) / "bases"
        write_bases(bases)
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        for number in numbers:
            tell({"begins": number})
            tell({"ended": asdict(run_case(chosen[number], bases, main))})


def run_apart(count: int, seed: int, only: str = "") -> Iterator[Ending]:
    """The endings of so many cases, run in one process, or in more where cases have killed one.

    Args:
        count: how many; with `only`, how many of it.
        seed: of the first.
        only: a family; all if empty.
    """
    chosen, begun = chosen_cases(count, seed, only), 0
    while begun < len(chosen):
        command = [sys.executable, "-m", "fuzz.running", str(count), str(seed), only, str(begun)]
        run = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=_environment())
        with run:
            assert run.stdout is not None
            current: int | None = None
            for line in run.stdout:
                told = json.loads(line)
                current = told.get("begins")
                if current is not None:
                    begun = current + 1
                else:
                    yield Ending(**told["ended"])
        if current is not None:
            yield Ending(str(chosen[current]), "killed", f"exit status {run.returncode}", 0.0, [])
        elif run.returncode:
            raise RuntimeError(f"the process that runs the cases ended with {run.returncode}")


def chosen_cases(count: int, seed: int, only: str = "") -> list[Case]:
    if only:
        return [Case(only, seed + n) for n in range(count)]
    return list(cases(count, seed))


def _environment() -> dict[str, str]:
    helpers = Path(__file__).resolve().parents[1]
    places = [str(helpers), str(helpers.parents[1] / "src"), os.environ.get("PYTHONPATH", "")]
    return os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, places)),
        "PYTHONIOENCODING": "utf-8:strict",  # as a terminal has it
        "COLUMNS": "100",
    }


def table(endings: Iterable[Ending]) -> str:
    """How many cases ended in each way."""
    counts = Counter(ending.outcome for ending in endings)
    names = [*FINE, *sorted(counts.keys() - set(FINE))]
    return "\n".join(f"{counts[name]:6d}  {name}" for name in names)


def _main() -> None:
    count, seed, only, start = sys.argv[1:]
    chosen = chosen_cases(int(count), int(seed), only)
    reports = os.fdopen(os.dup(1), "w", buffering=1)
    run_here(
        range(int(start), len(chosen)),
        chosen,
        lambda told: print(json.dumps(told), file=reports),
    )


if __name__ == "__main__":
    _main()
