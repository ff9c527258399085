"""Sec. 6.2: one, two and four users in long sequences; the thesis shows pictures, we count."""

from __future__ import annotations

from topview_lab.metrics import ALL, Summary, hidden_split, summarise
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.runs import DEFAULT_VARIANT, Counterpart, Measured, Run
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    Verdict,
    conclusion,
    number,
    percent,
)

OCCLUDED_SPLIT = hidden_split(0.3, "another person")
THESIS_FPS = (3.0, 4.0)
"""Frames per second on one core, as the thesis says."""


def sequences(context: Context) -> dict[str, Counterpart]:
    """One, two and four users; the last has 1500 frames, as the thesis's (Fig. 6.7)."""
    return {
        "one user": context.counterpart("single_user", 70, context.size(600, 60)),
        "two users": context.counterpart("two_users", 71, context.size(600, 60)),
        "four users": context.counterpart("four_users", 72, context.size(1500, 60)),
    }


def runs_of_users(context: Context) -> list[Run]:
    return [Run(DEFAULT_VARIANT, recording) for recording in sequences(context).values()]


def users(context: Context, measured: Measured) -> Section:
    summaries = {
        name: summarise(measured.of([Run(DEFAULT_VARIANT, recording)]))
        for name, recording in sequences(context).items()
    }
    rows = tuple(Row((name, *_cells(summary))) for name, summary in summaries.items())
    swaps = sum(summary.people.id_swaps for summary in summaries.values())
    slowest = min(summary.frames_per_second for summary in summaries.values())
    return Section(
        name="users",
        title="Section 6.2: one, two and four users",
        text=(
            "The default tracker on sequences as long as the thesis's, which are shown in its "
            "Figs. 6.5 to 6.7 without numbers. Speed is that of the tracker alone on one core, "
            "while other recordings are tracked on the others.",
        ),
        tables=(
            Table(
                ("sequence", "frames", "μE, cm", "offsets out", "A, 10 cm", "occluded: μE, cm",
                 "recall", "precision", "id swaps", "MOTA", "HOTA", "frames/s"),
                rows,
            ),
        ),
        verdicts=(
            conclusion(
                "tracking stays consistent over long sequences with occlusions (Sec. 6.2)",
                swaps == 0,
                f"{swaps} exchanges of identity",
            ),
            Verdict(
                "ahead" if slowest >= THESIS_FPS[1] else "behind",
                "Speed, one core",
                f"{number(slowest)} frames per second or more, thesis {THESIS_FPS[0]:g} to "
                f"{THESIS_FPS[1]:g} on its machine",
            ),
        ),
        numbers={
            name: {
                "recall": s.recall,
                "precision": s.precision,
                "id_swaps": s.people.id_swaps,
                "mota": s.tracking.mota,
                "hota": s.tracking.hota,
                "frames_per_second": s.frames_per_second,
            }
            for name, s in summaries.items()
        },
    )  # fmt: skip


def _cells(summary: Summary) -> tuple[str, ...]:
    joints = summary.joints_cm[ALL][ALL]
    occluded = summary.joints_cm[OCCLUDED_SPLIT][ALL]
    return (
        str(summary.people.frames),
        number(joints.raw.mean),
        number(joints.offset_out.mean),
        percent(joints.raw.within_10),
        number(occluded.raw.mean),
        percent(summary.recall),
        percent(summary.precision),
        str(summary.people.id_swaps),
        percent(summary.tracking.mota),
        percent(summary.tracking.hota),
        number(summary.frames_per_second),
    )
