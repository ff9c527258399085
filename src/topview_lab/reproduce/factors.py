"""Table 6.3: the contribution of each factor of f_uTVR, by occlusion of the torso."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from topview.score.utvr import MIN_POINTS_INSIDE
from topview.track.methods.utvr import UtvrSettings
from topview_lab.metrics import DIRECTION_GROUPS, Statistic, direction_errors, pool
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import BANDS, is_in_band, is_subject, torso_hidden
from topview_lab.reproduce.printed import OCCLUSIONS, TABLE_6_3, Occlusion, Printed
from topview_lab.reproduce.runs import DEFAULT_VARIANT, Measured, Run, Variant
from topview_lab.reproduce.section import (
    Kind,
    Row,
    Section,
    Table,
    Verdict,
    as_json,
    compared,
    conclusion,
    number,
    statistic_cells,
)

ALL_FACTORS: Final = "all (f_uTVR)"
VARIANTS: Final[dict[str, Variant]] = {
    "reproj × align": Variant(UtvrSettings(factors=("reproj", "align"), descent=0)),
    "align × discr": Variant(UtvrSettings(factors=("align", "discr"), descent=0)),
    "reproj × discr": Variant(UtvrSettings(factors=("reproj", "discr"), descent=0)),
    ALL_FACTORS: Variant(UtvrSettings(descent=0)),
}
"""Without the descent, which knows none of the factors and would hide what they bring."""
TOPVIEW: Final = "topview, the default"

Statistics = dict[Occlusion, Statistic]


def runs_6_3(context: Context) -> list[Run]:
    return [
        Run(variant, recording)
        for variant in (*VARIANTS.values(), DEFAULT_VARIANT)
        for recording in context.own_sequences()
    ]


def table_6_3(context: Context, measured: Measured) -> Section:
    ours = {
        name: torso_errors(context, measured, variant)
        for name, variant in (*VARIANTS.items(), (TOPVIEW, DEFAULT_VARIANT))
    }
    rows = []
    for name, printed in TABLE_6_3.items():
        rows.append(_row(f"thesis: {name}", printed, "printed"))
        rows.append(_row(f"utvr, the thesis's recipe: {name}", ours[name]))
    rows.append(_row(TOPVIEW, ours[TOPVIEW]))
    bands = ", ".join(f"{level}: {low:.0%} to {high:.0%}" for level, (low, high) in BANDS.items())
    header = [f"{level}: μE, °" if i == 0 else unit for level in OCCLUSIONS
              for i, unit in enumerate(("", "σE, °", "A, 10°"))]  # fmt: skip
    return Section(
        name="table-6.3",
        title="Table 6.3: the torso with a factor of f_uTVR left out",
        text=(
            "Angles between the estimated and the true directions of neck to mid torso, mid torso "
            "to hips, and shoulder to shoulder. Frames are sorted by how much of the torso's "
            f"joints other people and objects hide ({bands}). Factors are left out of the choice "
            "among hypotheses. A hypothesis has evidence if "
            f"{MIN_POINTS_INSIDE} of the user's points or more are inside (N_3D), and the factors "
            "that are asked are finite. The last row is the default tracker, "
            "which does not choose the torso by the score.",
        ),
        tables=(Table(("score", *header), tuple(rows)),),
        verdicts=(*_comparisons(ours), *_conclusions(ours)),
        numbers={
            name: {level: as_json(s) for level, s in by_level.items()}
            for name, by_level in ours.items()
        },
    )


def torso_errors(context: Context, measured: Measured, variant: Variant) -> Statistics:
    """Of the user who is looked at, by how much of the torso is hidden; degrees."""
    pooled = pool(measured.of(Run(variant, r) for r in context.own_sequences()))
    errors = direction_errors(pooled).of(DIRECTION_GROUPS["torso joints"])
    hidden = torso_hidden(pooled)
    return {
        level: errors.compare(is_subject(pooled) & is_in_band(hidden, level)).raw
        for level in OCCLUSIONS
    }


def _row(name: str, by_level: Mapping[Occlusion, Statistic | Printed], kind: Kind = "ours") -> Row:
    cells = [cell for level in OCCLUSIONS for cell in statistic_cells(by_level[level])]
    return Row((name, *cells), kind)


def _comparisons(ours: dict[str, Statistics]) -> list[Verdict]:
    printed = TABLE_6_3[ALL_FACTORS]
    return [
        compared(
            f"Table 6.3, torso {level} occluded, {name}", ours[key][level], printed[level], "°"
        )
        for name, key in (("the recipe of Sec. 5.3", ALL_FACTORS), ("topview", TOPVIEW))
        for level in OCCLUSIONS
    ]


def _conclusions(ours: dict[str, Statistics]) -> list[Verdict]:
    means = {name: {level: s.mean for level, s in found.items()} for name, found in ours.items()}
    full = means[ALL_FACTORS]

    def cost(left_out: str, level: Occlusion) -> float:
        return means[left_out][level] - full[level]

    def told(left_out: str) -> str:
        return ", ".join(f"{cost(left_out, level):+.1f}° at {level}" for level in OCCLUSIONS)

    def checked(claim: str, holds: bool, evidence: str) -> Verdict:
        known = (mean for by_level in means.values() for mean in by_level.values())
        return conclusion(f"{claim} (Sec. 6.1.2)", holds, evidence, known)

    return [
        checked(
            "f_reproj is a strong indicator: leaving it out costs",
            all(cost("align × discr", level) > 0 for level in OCCLUSIONS),
            told("align × discr"),
        ),
        checked(
            "f_discr handles severe occlusion: leaving it out costs, at 60 % above all",
            cost("reproj × align", "60 %") > 0,
            told("reproj × align"),
        ),
        checked(
            "f_align matters less than the other two",
            all(
                cost("reproj × discr", level)
                < max(cost("align × discr", level), cost("reproj × align", level))
                for level in OCCLUSIONS
            ),
            told("reproj × discr"),
        ),
        checked(
            "errors grow with occlusion",
            full["0 %"] <= full["30 %"] <= full["60 %"],
            ", ".join(f"{number(full[level])}° at {level}" for level in OCCLUSIONS),
        ),
    ]
