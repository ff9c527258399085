"""What scripts share that track with single things left out."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final, Protocol, TypeVar
from unittest import mock

from topview_lab.evaluate.run import run_all

DEFAULT: Final = "all, the default"
# By their names below `topview`, what takes the place of what.
Patches = Mapping[str, Any]
# By name, what is left out of each variant.
Variants = Mapping[str, Callable[[], Patches]]


class HasProblems(Protocol):
    """What a job of one recording gives."""

    @property
    def problems(self) -> tuple[str, ...]: ...


Result = TypeVar("Result", bound=HasProblems)
Recording = TypeVar("Recording")


@contextmanager
def left_out(patches: Patches) -> Iterator[None]:
    """While these take the places of what there is."""
    with ExitStack() as stack:
        for name, value in patches.items():
            stack.enter_context(mock.patch(f"topview.{name}", value))
        yield


def parser_of(doc: str | None) -> argparse.ArgumentParser:
    """Of a script that is told recordings and which variants to take."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", type=Path)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--only", nargs="+", metavar="WORD", default=[""])
    parser.add_argument("--json", type=Path)
    return parser


def chosen(variants: Variants, words: list[str]) -> list[str]:
    """The names of those that have one of the words, and the default first."""
    return [name for name in variants if name == DEFAULT or any(word in name for word in words)]


def run_without(
    names: Sequence[str],
    recordings: Sequence[Recording],
    job_of: Callable[[str, Recording], Callable[[], Result]],
    workers: int,
) -> dict[str, list[Result]]:
    """Each recording without each thing, by the variants' names; says what could not be read."""
    jobs = [job_of(name, recording) for name in names for recording in recordings]
    done = run_all(jobs, workers)
    results = [result for result in done.results if result is not None]
    problems = [problem for result in results for problem in result.problems]
    for problem in dict.fromkeys([*problems, *done.problems]):
        print(problem)
    count = len(recordings)
    return {
        name: [r for r in done.results[index * count : (index + 1) * count] if r is not None]
        for index, name in enumerate(names)
    }


def nothing(*_: object, **__: object) -> None:
    """Nothing is found, or done."""
