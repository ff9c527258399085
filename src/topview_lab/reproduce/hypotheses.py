"""Fig. 6.3: the error of every part over the number of hypotheses that are propagated."""

from __future__ import annotations

from typing import Final

import numpy as np

from topview.track.methods.utvr import UtvrSettings
from topview_lab.metrics import PART_GROUPS, direction_errors, pool
from topview_lab.metrics.errors import total_share
from topview_lab.metrics.samples import CAUSES
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import is_subject
from topview_lab.reproduce.plots import OCCLUDED_COLOR, OVERALL_COLOR, drawn
from topview_lab.reproduce.runs import Measured, Run, Variant
from topview_lab.reproduce.section import (
    Picture,
    Row,
    Section,
    Table,
    Verdict,
    conclusion,
    number,
)

HIDDEN_PART_SHARE: Final = 0.3
"""Share of a part's joints that others hide in the frames with significant occlusion (ours)."""
FEW_HYPOTHESES: Final = 3
"""The effect is the mean error with up to this many hypotheses against that with more (ours)."""
MOBILE: Final = ("upper arms", "forearms", "lower legs")
STIFF: Final = ("upper torso", "lower torso", "upper legs")
_OTHERS: Final = [CAUSES.index("another person"), CAUSES.index("an object")]

Curves = dict[str, dict[int, float]]
"""Mean error in degrees by group of parts and number of hypotheses."""


def numbers_of_hypotheses(context: Context) -> tuple[int, ...]:
    return (1, 11) if context.quick else tuple(range(1, 12))


def _variant(n_best: int) -> Variant:
    """Without the descent, which would hide what more hypotheses bring."""
    return Variant(UtvrSettings(n_best=n_best, descent=0))


def runs_figure_6_3(context: Context) -> list[Run]:
    return [
        Run(_variant(n), recording)
        for n in numbers_of_hypotheses(context)
        for recording in context.own_sequences()
    ]


def figure_6_3(context: Context, measured: Measured) -> Section:
    overall: Curves = {group: {} for group in PART_GROUPS}
    occluded: Curves = {group: {} for group in PART_GROUPS}
    for n in numbers_of_hypotheses(context):
        runs = [Run(_variant(n), r) for r in context.own_sequences()]
        pooled = pool(measured.of(runs))
        subject = is_subject(pooled)[:, None]
        for group, bones in PART_GROUPS.items():
            errors = direction_errors(pooled).of(bones)
            hidden = total_share(errors.hidden[..., _OTHERS]) >= HIDDEN_PART_SHARE
            overall[group][n] = errors.compare(np.broadcast_to(subject, hidden.shape)).raw.mean
            occluded[group][n] = errors.compare(subject & hidden).raw.mean
    path = context.picture("figure-6.3.png")
    with drawn(path, 3, 2, (3.6, 2.1)) as axes:
        for ax, group in zip(axes.flat, PART_GROUPS, strict=True):
            for curves, color, label in (
                (overall, OVERALL_COLOR, "all frames"),
                (occluded, OCCLUDED_COLOR, "occluded"),
            ):
                ax.plot(*zip(*curves[group].items(), strict=True), "o-", color=color, label=label,
                        markersize=3)  # fmt: skip
            ax.set(title=group, ylim=(0, None), xticks=numbers_of_hypotheses(context))
        axes[0, 0].legend()
        for ax in axes[-1]:
            ax.set_xlabel("hypotheses propagated, N")
        for ax in axes[:, 0]:
            ax.set_ylabel("mean error, °")
    ns = [str(n) for n in numbers_of_hypotheses(context)]
    rows = [
        Row((f"{group}, {which}", *(number(error) for error in curves[group].values())))
        for group in PART_GROUPS
        for which, curves in (("all", overall), ("occluded", occluded))
    ]
    return Section(
        name="figure-6.3",
        title="Figure 6.3: error over the number of propagated hypotheses",
        text=(
            "The thesis's recipe with N hypotheses of every part propagated from frame to frame, "
            "on the sequences of Table 6.4. Mean angle between estimated and true directions of a "
            "part's bones (upper torso: with the line of the shoulders). Occluded: frames in which "
            f"others hide {HIDDEN_PART_SHARE:.0%} or more of the part's joints.",
        ),
        tables=(Table(("mean error, °, with N =", *ns), tuple(rows)),),
        pictures=(Picture(path, "Mean error over N; the thesis prints curves without numbers."),),
        verdicts=_conclusions(overall, occluded),
        numbers={"all": _as_json(overall), "occluded": _as_json(occluded)},
    )


def gain(curve: dict[int, float]) -> float:
    """Degrees by which more than a few hypotheses beat a few."""
    few = [error for n, error in curve.items() if n <= FEW_HYPOTHESES]
    many = [error for n, error in curve.items() if n > FEW_HYPOTHESES]
    return float(np.mean(few) - np.mean(many))


def _conclusions(overall: Curves, occluded: Curves) -> tuple[Verdict, ...]:
    gains = {group: gain(curve) for group, curve in overall.items()}
    hidden_gains = {group: gain(curve) for group, curve in occluded.items()}
    mean_gain = float(np.mean(list(gains.values())))
    mean_hidden = float(np.nanmean(list(hidden_gains.values())))
    mobile, stiff = (float(np.mean([gains[g] for g in groups])) for groups in (MOBILE, STIFF))
    told = ", ".join(f"{group} {value:+.1f}°" for group, value in gains.items())
    return (
        conclusion(
            "errors drop with the number of hypotheses (Sec. 6.1.2)",
            mean_gain > 0,
            f"more than {FEW_HYPOTHESES} against up to {FEW_HYPOTHESES}: {told}",
            [mean_gain],
        ),
        conclusion(
            "the effect is larger where parts are occluded (Sec. 6.1.2)",
            mean_hidden > mean_gain,
            f"{mean_hidden:+.1f}° occluded, {mean_gain:+.1f}° in all",
            [mean_hidden, mean_gain],
        ),
        conclusion(
            "the effect is larger for arms and lower legs than for torso and upper legs (Sec. "
            "6.1.2)",
            mobile > stiff,
            f"{mobile:+.1f}° against {stiff:+.1f}°",
            [mobile, stiff],
        ),
    )


def _as_json(curves: Curves) -> dict[str, dict[str, float]]:
    return {group: {str(n): error for n, error in c.items()} for group, c in curves.items()}
