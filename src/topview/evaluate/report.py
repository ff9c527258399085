"""What was measured, as tables for a terminal and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec
from rich import box
from rich.console import Console
from rich.table import Table

from topview.evaluate.metrics import (
    Comparison,
    Evaluation,
    Offsets,
    SequenceSummary,
    Statistic,
    Summary,
    summarise,
)
from topview.evaluate.metrics.summary import ALL
from topview.io.writers import write_atomically

OFFSET_MEANING: dict[Offsets, str] = {
    "set": "one constant offset per joint for the whole set",
    "person": "one constant offset per joint for each person of each recording",
}


def print_report(
    evaluation: Evaluation,
    console: Console,
    title: str = "error against the reference",
    offsets: Offsets = "set",
    per_sequence: bool = False,
) -> Summary:
    """Print the tables, and return the numbers in them."""
    summary = summarise(evaluation, offsets)
    print_summary(summary, console, title, per_sequence)
    return summary


def print_summary(
    summary: Summary, console: Console, title: str, per_sequence: bool = False
) -> None:
    """Print the tables of numbers that are there already."""
    console.print(f"\n[bold]{title}[/bold]")
    console.print(f"offset out: {OFFSET_MEANING[summary.offsets]}, in the frame of its part")
    console.print(_error_table("distance of each joint, cm", "joint", "cm", summary.joints_cm[ALL]))
    console.print(
        _error_table("angle of each part's axis, degrees", "part", "°", summary.axes_deg[ALL])
    )
    for title_, tables, unit in (
        ("distance by what another person hides, cm", summary.joints_cm, "cm"),
        ("axis angle by what another person hides, degrees", summary.axes_deg, "°"),
    ):
        in_all = {occlusion: table[ALL] for occlusion, table in tables.items()}
        if any(comparison.raw.count for name, comparison in in_all.items() if name != ALL):
            console.print(_error_table(title_, "hidden share", unit, in_all))
    console.print(_people_table(summary))
    if per_sequence:
        console.print(_sequence_table(summary.sequences))


def write_json(
    path: Path, summary: Summary, title: str, settings: Mapping[str, Any], problems: Sequence[str]
) -> None:
    """All numbers and what made them; NaN becomes null.

    Raises:
        InputError: the file cannot be written.
    """
    report = {"title": title, "settings": settings, "problems": problems, "summary": summary}
    write_atomically(path, msgspec.json.format(msgspec.json.encode(report), indent=2) + b"\n")


def _error_table(title: str, what: str, unit: str, rows: Mapping[str, Comparison]) -> Table:
    table = _table(title, what)
    for variant in ("", "offset out\n"):
        for column in (f"{variant}mean", "std", f"≤ 10 {unit}"):
            table.add_column(column, justify="right")
    table.add_column("count", justify="right")
    for name, comparison in rows.items():
        table.add_row(
            name,
            *_cells(comparison.raw),
            *_cells(comparison.offset_out),
            str(comparison.raw.count),
            style="bold" if name == ALL else None,
        )
    return table


def _people_table(summary: Summary) -> Table:
    people = summary.people
    table = _table("people", "in all")
    table.add_column("", justify="right")
    rows: dict[str, str] = {
        "frames evaluated": str(people.frames),
        "frames not read": str(people.frames_unread),
        "people present, summed over frames": str(people.person_frames),
        "of them missed": f"{people.missed} ({_percent(1 - summary.recall)})",
        "false people, summed over frames": str(people.false_person_frames),
        "false people": str(people.false_people),
        "id swaps": str(people.id_swaps),
        "frames lost (nobody found)": str(people.frames_lost),
        "frames per second (tracker alone)": _number(summary.frames_per_second),
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def _sequence_table(sequences: Sequence[SequenceSummary]) -> Table:
    """Worst first: by mean distance with the offsets out, those without anybody found on top."""
    table = _table("per sequence, worst first", "sequence", gap=0)
    for column in (
        *("mean\ncm", "offset\nout", "≤ 10\ncm", "axes\n°"),
        *("missed", "false", "swaps", "lost", "fps"),
    ):
        table.add_column(column, justify="right")
    for sequence in sorted(sequences, key=_badness, reverse=True):
        people = sequence.people
        table.add_row(
            sequence.name,
            _number(sequence.joints.raw.mean),
            _number(sequence.joints.offset_out.mean),
            _percent(sequence.joints.offset_out.within_10, digits=0),
            _number(sequence.axes.raw.mean),
            *map(str, (people.missed, people.false_person_frames)),
            *map(str, (people.id_swaps, people.frames_lost)),
            _number(sequence.frames_per_second, digits=0),
        )
    return table


def _badness(sequence: SequenceSummary) -> float:
    mean_cm = sequence.joints.offset_out.mean
    return mean_cm if isfinite(mean_cm) else float("inf")


def _table(title: str, first_column: str, gap: int = 1) -> Table:
    """An empty table; `gap`: by how much its columns stand further apart than one space."""
    table = Table(
        title=f"\n{title}",
        title_justify="left",
        title_style="bold",
        header_style="",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, gap, 0, 0),
    )
    table.add_column(first_column, no_wrap=True)
    return table


def _cells(statistic: Statistic) -> tuple[str, str, str]:
    return _number(statistic.mean), _number(statistic.std), _percent(statistic.within_10)


def _number(value: float, digits: int = 1) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else "–"


def _percent(share: float, digits: int = 1) -> str:
    return f"{share:.{digits}%}" if isfinite(share) else "–"
