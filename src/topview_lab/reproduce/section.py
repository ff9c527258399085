"""Report of an experiment: text, tables, pictures, and comparisons with the thesis."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any, Literal

from topview_lab.metrics import Statistic
from topview_lab.reproduce.printed import Printed

Kind = Literal["ours", "printed", "open"]


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a table; `kind` says whose numbers these are, "open": nobody's yet."""

    cells: tuple[str, ...]
    kind: Kind = "ours"


@dataclass(frozen=True, slots=True)
class Table:
    """A table; the first column holds names, the others numbers. `foot` is told below it."""

    header: tuple[str, ...]
    rows: tuple[Row, ...]
    caption: str = ""
    foot: str = ""


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture in the report's folder."""

    path: Path
    caption: str


Word = Literal["ahead", "behind", "mixed", "confirmed", "not confirmed", "open"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is compared with the thesis, or a conclusion of it that is checked.

    Attributes:
        word: of a comparison "ahead", "behind" or "mixed" (in the mean, but not in the share within
            10, or the other way round); of a conclusion "confirmed" or "not confirmed"; of either
            "open" where a number is missing.
        claim: what is asked.
        evidence: the numbers.
        is_conclusion: a conclusion of the thesis, else a comparison with its numbers.
    """

    word: Word
    claim: str
    evidence: str
    is_conclusion: bool = False


@dataclass(frozen=True, slots=True)
class Section:
    """One table or figure of the thesis, reproduced.

    Attributes:
        name: as the command line has it, such as "table-6.1".
        title: for people.
        text: paragraphs: what was done, on what.
        tables, pictures, verdicts: in the order in which they are shown.
        numbers: everything behind them, plain JSON types.
    """

    name: str
    title: str
    text: tuple[str, ...]
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    numbers: dict[str, Any] = field(default_factory=dict)


def number(value: float, digits: int = 1) -> str:
    return f"{value:.{digits}f}" if isfinite(value) else "–"


def percent(share: float | None) -> str:
    return "–" if share is None or not isfinite(share) else f"{share:.1%}".replace("%", " %")


def statistic_cells(statistic: Statistic | Printed) -> tuple[str, str, str]:
    """Mean, standard deviation, share within 10."""
    return (
        number(statistic.mean, 2),
        number(statistic.std, 2),
        percent(statistic.within_10),
    )


def conclusion(claim: str, holds: bool, evidence: str, numbers: Iterable[float] = ()) -> Verdict:
    """A conclusion of the thesis, open where one of the numbers behind it is missing."""
    word: Word = "confirmed" if holds else "not confirmed"
    known = all(isfinite(number) for number in numbers)
    return Verdict(word if known else "open", claim, evidence, is_conclusion=True)


def compared(what: str, ours: Statistic, printed: Printed, unit: str) -> Verdict:
    """Our numbers beside the thesis's; the unit follows the numbers as it is."""
    evidence = f"mean error {number(ours.mean, 2)}{unit}, thesis {printed.mean:.2f}{unit}"
    is_ahead = {ours.mean <= printed.mean}
    if printed.within_10 is not None:
        is_ahead.add(ours.within_10 >= printed.within_10)
        evidence += (
            f"; within 10{unit} {percent(ours.within_10)}, thesis {percent(printed.within_10)}"
        )
    word: Word = "mixed" if len(is_ahead) > 1 else "ahead" if is_ahead.pop() else "behind"
    return Verdict(word if isfinite(ours.mean) else "open", what, evidence)


def as_json(statistic: Statistic | Printed) -> dict[str, float | int | None]:
    values = {name: getattr(statistic, name, None) for name in ("mean", "std", "within_10")}
    if isinstance(statistic, Statistic):
        values["count"] = statistic.count
    return values
