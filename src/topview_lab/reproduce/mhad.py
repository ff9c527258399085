"""Tables 6.1 and 6.2: joint positions over bodies and over actions, after Berkeley MHAD."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from topview.track.methods.utvr import AS_PRINTED
from topview_lab.datasets import EvaluatedRecording
from topview_lab.datasets.berkeley_mhad import find_berkeley_mhad
from topview_lab.metrics import Comparison, summarise
from topview_lab.metrics.summary import ALL
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.printed import TABLE_6_1, TABLE_6_2, Printed
from topview_lab.reproduce.runs import (
    DEFAULT_VARIANT,
    NETWORK_ALONE,
    THESIS_RECIPE,
    WITHOUT_NETWORK,
    Measured,
    Run,
    Variant,
)
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    as_json,
    compared,
    statistic_cells,
)
from topview_lab.rivals.swarm import SwarmSettings, perturbed_swarm
from topview_lab.sim import TWELVE_PEOPLE
from topview_lab.sim.actions import MHAD_ACTIONS

POSITION_METHODS: Final[dict[str, Variant]] = {
    "topview, the default": DEFAULT_VARIANT,
    "utvr, the thesis's recipe": THESIS_RECIPE,
}
SLOW_METHODS: Final[dict[str, Variant]] = {
    "topview without the network": WITHOUT_NETWORK,
    "joints, the network alone": NETWORK_ALONE,
    "utvr, as printed": Variant(AS_PRINTED),
    "bPSO, as topview has it": Variant(SwarmSettings()),
    "pPSO, as topview has it": Variant(perturbed_swarm()),
}
"""The recipe without what we add to it, and swarms as `topview_lab.rivals.swarm` has them; left out
of the quick form."""
CLOSED_RIVALS: Final = (
    "NiTE is a closed binary, and HYBRID takes the sizes of the body from it: both have the "
    "thesis's numbers alone, of its recordings."
)
SUBJECT: Final = 9
"""Of Table 6.2, counted from 1."""


def boxers(context: Context) -> Sequence[EvaluatedRecording]:
    """Twelve people boxing, one recording each."""
    if context.mhad is not None:
        return find_berkeley_mhad(context.mhad, "s*_a04_r01")
    appearances = TWELVE_PEOPLE[: context.size(len(TWELVE_PEOPLE), 2)]
    return [
        context.counterpart(
            "boxing", k, context.size(150, 40), body=f"body{k:02}", appearance=appearance
        )
        for k, appearance in enumerate(appearances, start=1)
    ]


def actions(context: Context) -> Sequence[EvaluatedRecording]:
    """One person and the eleven actions."""
    if context.mhad is not None:
        return find_berkeley_mhad(context.mhad, f"s{SUBJECT:02}_a*_r01")
    names = MHAD_ACTIONS[:: context.size(1, 5)]
    appearance = TWELVE_PEOPLE[SUBJECT - 1]
    return [
        context.counterpart(
            name, 20 + k, context.size(180, 40), body=f"body{SUBJECT:02}", appearance=appearance
        )
        for k, name in enumerate(names)
    ]


def methods(context: Context) -> dict[str, Variant]:
    return POSITION_METHODS if context.quick else POSITION_METHODS | SLOW_METHODS


def runs_6_1(context: Context) -> list[Run]:
    return [Run(v, r) for v in methods(context).values() for r in boxers(context)]


def runs_6_2(context: Context) -> list[Run]:
    return [Run(v, r) for v in methods(context).values() for r in actions(context)]


def table_6_1(context: Context, measured: Measured) -> Section:
    """Over bodies."""
    what = "12 subjects" if context.mhad else f"{len(boxers(context))} simulated bodies"
    return _section(
        "table-6.1", f"Table 6.1: {what}, boxing", "body", TABLE_6_1, boxers(context), context,
        measured,
    )  # fmt: skip


def table_6_2(context: Context, measured: Measured) -> Section:
    """Over actions."""
    what = "subject" if context.mhad else "simulated body"
    return _section(
        "table-6.2", f"Table 6.2: {what} {SUBJECT:02}, {len(actions(context))} actions", "action",
        TABLE_6_2, actions(context), context, measured,
    )  # fmt: skip


def _section(
    name: str,
    title: str,
    one: str,
    printed: Mapping[str, Printed],
    recordings: Sequence[EvaluatedRecording],
    context: Context,
    measured: Measured,
) -> Section:
    summaries = {
        method: summarise(measured.of(Run(variant, r) for r in recordings))
        for method, variant in methods(context).items()
    }
    totals = {method: summary.joints_cm[ALL][ALL] for method, summary in summaries.items()}
    rows = [Row((f"thesis: {who}", *statistic_cells(p)), "printed") for who, p in printed.items()]
    for method, total in totals.items():
        rows.append(Row((method, *statistic_cells(total.raw))))
        rows.append(Row((f"{method}, offsets out", *statistic_cells(total.offset_out))))
    default = summaries["topview, the default"]
    data = "Berkeley MHAD, Kinect 1" if context.mhad else "simulated counterparts of Berkeley MHAD"
    return Section(
        name=name,
        title=title,
        text=(
            f"Distance of estimated from true joints on {data}. The thesis's recipe is "
            "Sec. 5.3, but for what docs/method.md names; topview, the default, is what this "
            "project makes of it. Offsets out: without each joint's constant offset, one for all "
            "recordings, since truth and model do not mean the same place by 'shoulder'.",
        ),
        tables=(
            Table(("method", "μE, cm", "σE, cm", "A, 10 cm"), tuple(rows), foot=CLOSED_RIVALS),
            _by_recording(one, {s.name: s.joints for s in default.sequences}),
        ),
        verdicts=tuple(
            compared(f"{title}: {method}", totals[method].raw, printed["uTVR"], " cm")
            for method in POSITION_METHODS
        ),
        numbers={
            method: {"raw": as_json(total.raw), "offset_out": as_json(total.offset_out)}
            for method, total in totals.items()
        },
    )


def _by_recording(one: str, joints: Mapping[str, Comparison]) -> Table:
    rows = [
        Row((name, *statistic_cells(j.raw), *statistic_cells(j.offset_out)))
        for name, j in joints.items()
    ]
    columns = ("μE, cm", "σE, cm", "A, 10 cm")
    return Table(
        (one, *columns, *(f"{column}, offsets out" for column in columns)),
        tuple(rows),
        "topview, the default, by recording",
    )
