"""The tables of a report, for a terminal 80 characters wide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from rich import box
from rich.table import Table

from topview.records import JOINT_STATE_NAMES
from topview_lab.metrics import (
    ALL,
    Calibration,
    Comparison,
    Held,
    Reliability,
    SequenceSummary,
    SplitRecall,
    Statistic,
    Summary,
    WithinLimit,
)

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

STATE_HEADS: Final = dict(
    zip(JOINT_STATE_NAMES, ("absent", "visible", "self", "person", "object", "out"), strict=True)
)


def error_table(title: str, what: str, unit: str, rows: Mapping[str, Comparison]) -> Table:
    """Mean, deviation, accuracy of each row, as they are and with the offsets out."""
    table = empty_table(title, what)
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


def within_table(rows: Mapping[str, WithinLimit]) -> Table:
    """Shares within 10 cm as depth benchmarks count them."""
    table = empty_table("within 10 cm, missed people counting as wrong (mAP)", "joints")
    for column in ("share", "offset\nout", "ranked\nprecision", "offset\nout", "count"):
        table.add_column(column, justify="right")
    for name, row in rows.items():
        shares = (row.raw, row.offset_out, row.ranked, row.ranked_offset_out)
        style = "bold" if name == ALL else None
        table.add_row(name, *map(percent, shares), str(row.count), style=style)
    return table


def people_table(summary: Summary) -> Table:
    """Detection, identities and speed."""
    people, tracking = summary.people, summary.tracking
    table = empty_table("people", "in all")
    table.add_column("", justify="right")
    rows: dict[str, str] = {
        "frames evaluated": str(people.frames),
        "frames not read": str(people.frames_unread),
        "people present, summed over frames": str(people.person_frames),
        "of them missed": f"{people.missed} ({percent(1 - summary.recall)})",
        "false people, summed over frames": str(people.false_person_frames),
        "false people": str(people.false_people),
        "id swaps": str(people.id_swaps),
        "frames lost (nobody found)": str(people.frames_lost),
        "HOTA (detection, association)": f"{percent(tracking.hota)} "
        f"({percent(tracking.detection)}, {percent(tracking.association)})",
        "MOTA": percent(tracking.mota),
        "MOTP, cm": number(tracking.motp_cm),
        "frames per second (tracker alone)": number(summary.frames_per_second),
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def found_table(rows: Mapping[str, SplitRecall]) -> Table:
    """Recall by split."""
    table = empty_table("people found, by what is hidden of them", "hidden by")
    table.add_column("found", justify="right")
    table.add_column("people, summed\nover frames", justify="right")
    for name, found in rows.items():
        table.add_row(name, percent(found.recall), str(found.count))
    return table


def over_time_table(rows: Mapping[str, Held]) -> Table:
    """What is only seen over time, and how often it held."""
    table = empty_table("over time", "what")
    table.add_column("holds", justify="right")
    table.add_column("count", justify="right")
    for name, held in rows.items():
        table.add_row(name, percent(held.share), str(held.count))
    return table


def reliability_table(calibration: Calibration) -> Table:
    """By confidence, and by the state told."""
    table = empty_table("confidence: does it hold that often?", "stated")
    for column in ("mean\nconfidence", "within\n10 cm", "count"):
        table.add_column(column, justify="right")
    step = 1.0 / len(calibration.bins)
    rows = {
        **{f"{b * step:.1f} to {(b + 1) * step:.1f}": r for b, r in enumerate(calibration.bins)},
        **calibration.states,
        ALL: calibration.overall,
    }
    for name, row in rows.items():
        table.add_row(name, *_reliability_cells(row), style="bold" if name == ALL else None)
    return table


def calibration_table(calibration: Calibration) -> Table:
    """By what hides the joint: are confidences and ellipsoids what they say?"""
    table = empty_table("how sure joints are: is it true?", "joints")
    for column in (
        *("mean\nconfidence", "within\n10 cm", "expected\nerror"),
        *("in the ellipsoid\nof 90 %", "count"),
    ):
        table.add_column(column, justify="right")
    for name, split in calibration.splits.items():
        confidence, holds, count = _reliability_cells(split.stated)
        expected = number(split.expected_error, 3)
        table.add_row(name, confidence, holds, expected, percent(split.inside_90), count)
    return table


def state_table(calibration: Calibration) -> Table:
    """The predicted states of the joints in each true state."""
    table = empty_table("state of joints: the reference's, and as told", "reference")
    for head in STATE_HEADS.values():
        table.add_column(head, justify="right")
    table.add_column("count", justify="right")
    for true_state, told in calibration.told_states.items():
        shares = (percent(told[state]) for state in STATE_HEADS)
        table.add_row(true_state, *shares, str(calibration.true_states[true_state]))
    return table


def sequence_table(sequences: Sequence[SequenceSummary]) -> Table:
    """Worst first: by mean distance with the offsets out, those without anybody found on top."""
    table = empty_table("per sequence, worst first", "sequence", gap=0)
    for column in (
        *("mean\ncm", "offset\nout", "≤ 10\ncm", "axes\n°"),
        *("missed", "false", "swaps", "lost", "fps"),
    ):
        table.add_column(column, justify="right")
    for sequence in sorted(sequences, key=_badness, reverse=True):
        people = sequence.people
        table.add_row(
            sequence.name,
            number(sequence.joints.raw.mean),
            number(sequence.joints.offset_out.mean),
            percent(sequence.joints.offset_out.within_10, digits=0),
            number(sequence.axes.raw.mean),
            *map(str, (people.missed, people.false_person_frames)),
            *map(str, (people.id_swaps, people.frames_lost)),
            number(sequence.frames_per_second, digits=0),
        )
    return table


def number(value: float, digits: int = 1) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else "–"


def percent(share: float, digits: int = 1) -> str:
    return f"{share:.{digits}%}" if isfinite(share) else "–"


def rows_as_json(rows: Mapping[str, DataclassInstance]) -> dict[str, Any]:
    """JSON types."""
    return {name: asdict(row) for name, row in rows.items()}


def _badness(sequence: SequenceSummary) -> float:
    mean_cm = sequence.joints.offset_out.mean
    return mean_cm if isfinite(mean_cm) else float("inf")


def empty_table(title: str, first_column: str, gap: int = 1) -> Table:
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
    return number(statistic.mean), number(statistic.std), percent(statistic.within_10)


def _reliability_cells(reliability: Reliability) -> tuple[str, str, str]:
    mean, holds = percent(reliability.confidence), percent(reliability.holds)
    return mean, holds, str(reliability.count)
