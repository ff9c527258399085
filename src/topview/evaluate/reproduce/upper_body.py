"""Table 5.2: the torso by bTVR; the thesis's numbers, ours are still to come."""

from __future__ import annotations

from topview.evaluate.reproduce.context import Context
from topview.evaluate.reproduce.printed import TABLE_5_2
from topview.evaluate.reproduce.section import Row, Section, Table, number


def table_5_2(context: Context) -> Section:
    """The table with its places left open."""
    rows = [
        Row(
            (
                f"thesis: {who}",
                *(number(value, 2) for part in parts.values() for value in (part.mean, part.std)),
            ),
            "printed",
        )
        for who, parts in TABLE_5_2.items()
    ]
    return Section(
        name="table-5.2",
        title="Table 5.2: the torso by bTVR",
        text=("topview has no tracker of its own for the upper body alone yet (Sec. 5.1).",),
        tables=(
            Table(
                ("method", "μE, °", "σE, °", "occluded: μE, °", "σE, °"),
                (*rows, Row(("topview, btvr", "", "", "", ""), "open")),
            ),
        ),
    )
