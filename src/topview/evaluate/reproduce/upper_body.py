"""Table 5.2: the torso by bTVR, the thesis's upper-body tracker, in all frames and occluded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from topview.evaluate.metrics import DIRECTION_GROUPS, Statistic, direction_errors, pool
from topview.evaluate.reproduce.context import Context
from topview.evaluate.reproduce.occlusion import INTERACTION, is_occluded, is_subject
from topview.evaluate.reproduce.printed import TABLE_5_2, Part, Printed
from topview.evaluate.reproduce.runs import DEFAULT, THESIS, Measured, Run, Variant
from topview.evaluate.reproduce.section import (
    Row,
    Section,
    Table,
    as_json,
    compared,
    number,
)

BTVR: Final = "topview, btvr"
METHODS: Final[dict[str, Variant]] = {
    BTVR: Variant("btvr"),
    "topview, thesis's full-body recipe": THESIS,
    "topview, utvr": DEFAULT,
}
PARTS: Final[tuple[Part, ...]] = ("overall", "occluded")


def runs_5_2(context: Context) -> list[Run]:
    return [Run(v, r) for v in METHODS.values() for r in context.own_sequences()]


def table_5_2(context: Context, measured: Measured) -> Section:
    ours = {name: _torso_errors(context, measured, v) for name, v in METHODS.items()}
    rows = [
        *(Row(_cells(f"thesis: {who}", parts), "printed") for who, parts in TABLE_5_2.items()),
        *(Row(_cells(name, parts)) for name, parts in ours.items()),
    ]
    return Section(
        name="table-5.2",
        title="Table 5.2: the torso by bTVR",
        text=(
            "Angles between the estimated and the true directions of neck to mid torso, mid torso "
            "to hips, and shoulder to shoulder, on the sequences of Table 6.4. Occluded: frames in "
            f"which another user hides {INTERACTION:.0%} or more of the one who is looked at.",
        ),
        tables=(Table(("method", "μE, °", "σE, °", "occluded: μE, °", "σE, °"), tuple(rows)),),
        verdicts=tuple(
            compared(f"Table 5.2, torso, {part}, btvr", ours[BTVR][part], printed, "°")
            for part, printed in TABLE_5_2["bTVR"].items()
        ),
        numbers={
            name: {part: as_json(statistic) for part, statistic in parts.items()}
            for name, parts in ours.items()
        },
    )


def _torso_errors(context: Context, measured: Measured, variant: Variant) -> dict[Part, Statistic]:
    pooled = pool(measured.of(Run(variant, r) for r in context.own_sequences()))
    errors = direction_errors(pooled).of(DIRECTION_GROUPS["torso joints"])
    subject = is_subject(pooled)
    where = {"overall": subject, "occluded": subject & is_occluded(pooled)}
    return {part: errors.compare(where[part]).raw for part in PARTS}


def _cells(name: str, parts: Mapping[Part, Statistic | Printed]) -> tuple[str, ...]:
    numbers = (number(v, 2) for part in PARTS for v in (parts[part].mean, parts[part].std))
    return name, *numbers
