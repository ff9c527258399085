"""`topview train-people --joints-out`: the joint network's last layers; what both steps share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final, TypeVar

from rich.table import Table

from topview.cli.progress import compile_kernels, warn
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.evaluate.run import run_all
from topview_lab.evaluate.tables import empty_table, percent
from topview_lab.training.people import KnownPeople
from topview_lab.training.people_fit import fit_person_head, windows_called_right
from topview_lab.training.people_windows import (
    CollectedWindows,
    PosturesJob,
    WindowRows,
    WindowsJob,
)
from topview_lab.training.person_head import PersonHead, head_in, with_head

# Ours: of so many recordings one is held back.
HELD_BACK: Final = 4

Row = TypeVar("Row")


def collected(
    jobs: Sequence[Callable[[], Row]], workers: int, what: str
) -> list[Row | None] | None:
    """Of each recording in turn, None for one that failed; None if Ctrl-C ended it early."""
    compile_kernels()
    run = run_all(jobs, workers, what=what)
    warn(*run.problems)
    if run.interrupted:
        done = sum(row is not None for row in run.results)
        warn(f"interrupted: {done} of {len(jobs)} recordings; nothing is learnt")
        return None
    return list(run.results)


def split(results: Sequence[Row]) -> tuple[Sequence[Row], Sequence[Row]]:
    """Those to learn from, and those that are held back."""
    is_back = [index % HELD_BACK == HELD_BACK - 1 for index in range(len(results))]
    return (
        [each for each, back in zip(results, is_back, strict=True) if not back],
        [each for each, back in zip(results, is_back, strict=True) if back],
    )


def learn_head(
    given: Sequence[KnownPeople],
    others: Sequence[KnownPeople],
    postures: int,
    workers: int,
    out: Path,
    network: Path,
) -> Table | None:
    """Fit the head of a network on what was given, and on so many people in postures; write it, and
    measure it on the others, or on what is held back if there are none; None if Ctrl-C ended it
    early."""
    weights = network.read_bytes()
    before = head_in(weights)
    own_jobs = [
        *_jobs(given, network),
        *(PosturesJob(number, network) for number in range(postures)),
    ]
    results = collected([*own_jobs, *_jobs(others, network)], workers, "collecting windows")
    if results is None:
        return None
    warn(*(each.problem for each in results if each is not None and each.problem))
    learnt, measured = results[: len(own_jobs)], results[len(own_jobs) :]
    if not others:
        learnt, measured = split(learnt)
    own, other = _joined(learnt), _joined(measured)
    if own is None:
        raise InputError(f"none of the {len(given)} recordings could be used")
    now = fit_person_head(before, own)
    write_atomically(out, with_head(weights, now))
    sets = {"fitted": own, "others" if others else "held back": other}
    return _windows_table(sets, (before, now))


def _jobs(recordings: Sequence[KnownPeople], network: Path) -> list[WindowsJob]:
    """Each with the folder of the next that has one, for another room."""
    folders: list[Path | None] = [getattr(recording, "path", None) for recording in recordings]
    jobs = []
    for index, (recording, folder) in enumerate(zip(recordings, folders, strict=True)):
        others = [*folders[index + 1 :], *folders[:index]]
        room = next((other for other in others if other is not None), None)
        jobs.append(WindowsJob(recording, folder, room, network))
    return jobs


def _joined(results: Sequence[CollectedWindows | None]) -> WindowRows | None:
    rows = [each.rows for each in results if each is not None and each.rows is not None]
    return WindowRows.joined(rows) if rows else None


def _windows_table(sets: Mapping[str, WindowRows | None], heads: Sequence[PersonHead]) -> Table:
    table = empty_table("windows that the network tells right", "recordings")
    table.add_column("windows")
    for column in ("with a\nperson", "people,\nbefore", "now", "others,\nbefore", "now"):
        table.add_column(column, justify="right")
    for name, rows in sets.items():
        if rows is None:
            continue
        for kind, is_varied in (("asked about", False), ("varied", True)):
            is_kind = rows.is_varied == is_varied
            right = [windows_called_right(rows, head, is_varied) for head in heads]
            shares = [percent(each[of]) for of in (0, 1) for each in right]
            people = str((rows.is_person & is_kind).sum())
            table.add_row(name, f"{is_kind.sum()} {kind}", people, *shares)
    return table
