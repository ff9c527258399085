"""The measured numbers, as tables for a terminal and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
from rich.console import Console
from rich.table import Table
from rich.text import Text

from topview.io.writers import write_atomically
from topview_lab.evaluate import tables
from topview_lab.metrics import (
    ALL,
    BODY_HALVES,
    CAUSES,
    DIRECTION_GROUPS,
    PART_GROUPS,
    RELATIVE_ANGLE_GROUPS,
    Calibration,
    Comparison,
    Evaluation,
    Offsets,
    Summary,
    hidden_split,
    summarise,
)
from topview_lab.metrics.splits import ACTION_PREFIX, BODY_PREFIX, HIDDEN_SHARES, UNHIDDEN

OFFSET_MEANING: dict[Offsets, str] = {
    "set": "one constant offset per joint for the whole set",
    "person": "one constant offset per joint for each person of each recording",
}
SHARE_SPLITS: Final = (UNHIDDEN, *map(hidden_split, HIDDEN_SHARES))
BY_PERSON: Final = hidden_split(HIDDEN_SHARES[0], CAUSES[0])

ByName = Mapping[str, Comparison]
BySplit = Mapping[str, ByName]


def print_report(
    evaluation: Evaluation,
    console: Console,
    title: str = "error against the reference",
    offsets: Offsets = "set",
    per_sequence: bool = False,
    detail: bool = False,
) -> Summary:
    """Print the tables, and return the numbers in them."""
    summary = summarise(evaluation, offsets)
    print_summary(summary, console, title, per_sequence, detail)
    return summary


def print_brief(evaluation: Evaluation, console: Console, title: str) -> None:
    """What matters most, in some ten lines; `print_report` has the rest."""
    summary = summarise(evaluation, "set")
    joints, found = summary.joints_cm, summary.people
    rows = {_hidden_by(split): joints[split][ALL] for split in (ALL, UNHIDDEN, BY_PERSON)}
    rows = {name: row for name, row in rows.items() if row.raw.count}
    console.print(tables.error_table(f"{title}, cm", "joints hidden by", "cm", rows))
    console.print(
        f"people: {found.missed} of {found.person_frames} missed, "
        f"{found.false_person_frames} false, {found.id_swaps} exchanged; "
        f"{summary.frames_per_second:.1f} frames per second"
    )


def print_summary(
    summary: Summary,
    console: Console,
    title: str,
    per_sequence: bool = False,
    detail: bool = False,
) -> None:
    """Print the tables of numbers that are there already; `detail`: every one of them."""
    console.print(Text(f"\n{title}", style="bold"))
    console.print(f"offset out: {OFFSET_MEANING[summary.offsets]}, in the frame of its part")
    for table in (*_main_tables(summary, detail), *(_detail_tables(summary) if detail else ())):
        console.print(table)
    console.print(tables.people_table(summary))
    console.print(_confidence_line(summary.calibration))
    if per_sequence:
        console.print(tables.sequence_table(summary.sequences))


def write_json(
    path: Path, summary: Summary, title: str, settings: Mapping[str, Any], problems: Sequence[str]
) -> None:
    """All numbers and what made them; NaN becomes null.

    Raises:
        InputError: the file cannot be written.
    """
    report = {"title": title, "settings": settings, "problems": problems, "summary": summary}
    write_atomically(path, msgspec.json.format(msgspec.json.encode(report), indent=2) + b"\n")


def _main_tables(summary: Summary, detail: bool) -> Iterator[Table]:
    yield tables.error_table("distance of each joint, cm", "joint", "cm", summary.joints_cm[ALL])
    yield tables.error_table("angles, degrees", "angle", "°", _angle_rows(summary))
    yield from _occlusion_table("distance by what hides the joint", "cm", summary.joints_cm, detail)
    within = summary.within_10_cm
    yield tables.within_table(
        within if detail else {name: within[name] for name in (*BODY_HALVES, ALL)}
    )


def _detail_tables(summary: Summary) -> Iterator[Table]:
    if ends := summary.ends_cm:
        title = "distance of wrists and feet, cm (in no other table)"
        yield tables.error_table(title, "joint", "cm", ends[ALL])
        yield from _occlusion_table("distance of these by what hides them", "cm", ends, True)
    directions = summary.directions_deg
    yield from _occlusion_table("bone directions by what hides the bone", "°", directions, True)
    for of, by_split, groups in (
        ("relative angles", summary.relative_angles_deg, RELATIVE_ANGLE_GROUPS),
        ("bone directions", directions, DIRECTION_GROUPS | PART_GROUPS),
    ):
        for split in (ALL, BY_PERSON):
            rows = {name: by_split[split][name] for name in groups}
            if by_split[split][ALL].raw.count:
                yield tables.error_table(f"{of}, {split}, degrees", "of", "°", rows)
    for title, by_split in (
        ("angle of each part's axis, degrees", summary.axes_deg),
        ("rotation of each part, degrees", summary.orientations_deg),
    ):
        if by_split:
            yield tables.error_table(title, "part", "°", by_split[ALL])
    for what, prefix in (("action", ACTION_PREFIX), ("body", BODY_PREFIX)):
        yield from _label_table(f"distance by {what}", what, prefix, "cm", summary.joints_cm)
        yield from _label_table(f"bone directions by {what}", what, prefix, "°", directions)
    found = {
        _hidden_by(split): found
        for split, found in summary.found.items()
        if found.count and not split.startswith((ACTION_PREFIX, BODY_PREFIX))
    }
    if len(found) > 1:
        yield tables.found_table(found)
    yield tables.calibration_table(summary.calibration)
    over_time = {
        "facing within 45°, after the first second": summary.facing,
        "joints that come back from behind another within 10 cm": summary.reacquired,
    }
    if over_time := {name: held for name, held in over_time.items() if held.count}:
        yield tables.over_time_table(over_time)
    yield tables.reliability_table(summary.calibration)
    if summary.calibration.told_states:
        yield tables.state_table(summary.calibration)


def _occlusion_table(title: str, unit: str, by_split: BySplit, detail: bool) -> Iterator[Table]:
    """Errors by hidden share and cause, if occlusion is known."""
    shares = HIDDEN_SHARES if detail else HIDDEN_SHARES[:1]
    causes = [hidden_split(share, cause) for cause in CAUSES for share in shares]
    named = [*SHARE_SPLITS, *(split for split in causes if by_split[split][ALL].raw.count)]
    if any(by_split[split][ALL].raw.count for split in named):
        rows = {_hidden_by(split): by_split[split][ALL] for split in (ALL, *named)}
        yield tables.error_table(f"{title}, {unit}", "hidden by", unit, rows)


def _label_table(
    title: str, what: str, prefix: str, unit: str, by_split: BySplit
) -> Iterator[Table]:
    rows = {
        split.removeprefix(prefix): table[ALL]
        for split, table in by_split.items()
        if split.startswith(prefix)
    }
    if rows:
        yield tables.error_table(f"{title}, {unit}", what, unit, rows)


def _angle_rows(summary: Summary) -> dict[str, Comparison]:
    """The rows of Table 6.4 in both readings, and all part axes."""
    relative, directions = summary.relative_angles_deg[ALL], summary.directions_deg[ALL]
    return {
        **{f"{name}, relative": relative[name] for name in RELATIVE_ANGLE_GROUPS},
        **{f"{name}, bones": directions[name] for name in DIRECTION_GROUPS},
        "axes of all parts": summary.axes_deg[ALL][ALL],
    }


def _hidden_by(split: str) -> str:
    return split.removeprefix("hidden by ")


def _confidence_line(calibration: Calibration) -> str:
    overall = calibration.overall
    return (
        f"\nconfidence of joints: {tables.percent(overall.confidence)} stated, "
        f"{tables.percent(overall.holds)} within 10 cm; expected calibration error "
        f"{tables.number(calibration.expected_error, 3)}, Brier score "
        f"{tables.number(calibration.brier, 3)}"
    )
