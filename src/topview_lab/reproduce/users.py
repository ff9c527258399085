"""Sec. 6.2: one, two and four users in long sequences; the thesis shows pictures, we count too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from topview_lab.metrics import (
    ALL,
    LEAST_SEEN,
    LOST_AFTER_S,
    Summary,
    hidden_split,
    summarise,
    times_lost,
)
from topview_lab.reproduce.context import QUICK_FRAMES, Context
from topview_lab.reproduce.runs import (
    DEFAULT_VARIANT,
    RECIPE_AND_NETWORK,
    THESIS_RECIPE,
    Counterpart,
    Measured,
    Run,
    Variant,
)
from topview_lab.reproduce.section import (
    Row,
    Section,
    Table,
    Verdict,
    conclusion,
    number,
    percent,
)
from topview_lab.reproduce.strips import strip

OCCLUDED_SPLIT = hidden_split(0.3, "another person")
THESIS_FPS = (3.0, 4.0)
"""Frames per second on one core, as the thesis says."""
USERS_METHODS: Final[dict[str, Variant]] = {
    "topview, the default": DEFAULT_VARIANT,
    "utvr, the recipe of Sec. 5.3": THESIS_RECIPE,
    "utvr, its people found with the network": RECIPE_AND_NETWORK,
}
USERS_HEADER: Final = (
    "sequence, method", "frames", "μE, cm", "offsets out", "A, 10 cm", "occluded: μE, cm",
    "recall", "precision", "exchanges", "lost", "MOTA", "HOTA", "frames/s",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class TrackedUsers:
    """One sequence by one method: its numbers, and how often somebody was lost."""

    summary: Summary
    lost: int

    @property
    def exchanges(self) -> int:
        return self.summary.people.id_swaps


def sequences(context: Context) -> dict[str, Counterpart]:
    """One, two and four users; the last has 1500 frames, as the thesis's (Fig. 6.7)."""
    return {
        "one user": context.counterpart("single_user", 70, context.size(600, QUICK_FRAMES)),
        "two users": context.counterpart("two_users", 71, context.size(600, QUICK_FRAMES)),
        "four users": context.counterpart("four_users", 72, context.size(1500, QUICK_FRAMES)),
    }


def runs_of_users(context: Context) -> list[Run]:
    return [
        Run(variant, recording)
        for variant in USERS_METHODS.values()
        for recording in sequences(context).values()
    ]


def users(context: Context, measured: Measured) -> Section:
    tracked = {
        method: {
            name: tracked_users(measured, variant, recording)
            for name, recording in sequences(context).items()
        }
        for method, variant in USERS_METHODS.items()
    }
    return Section(
        name="users",
        title="Section 6.2, Figures 6.5 to 6.7: one, two and four users",
        text=(
            "Sequences as long as the thesis's, which are shown in its Figs. 6.5 to 6.7 without "
            "numbers. The people finder is the same, but the default method's asks the network who "
            "is there, the thesis's does not (`--proposals finder` lets it), and it separates "
            "touching users by the bodies of the method.",
            "Exchanges: somebody continues under another identity, or appears under one that was "
            "somebody else's. Lost: somebody who was tracked before is matched by no track for "
            f"{LOST_AFTER_S:g} s or more, though in view and to be seen by {LEAST_SEEN:.0%} or "
            "more. Recall: tracked share of all person-frames in view, hidden or not. Frames per "
            "second are those of the tracker alone on one core, while other recordings are tracked "
            "on the others.",
        ),
        tables=(
            Table(
                USERS_HEADER,
                tuple(
                    Row((f"{name}, {method}", *_cells(tracked[method][name])))
                    for name in sequences(context)
                    for method in USERS_METHODS
                ),
            ),
        ),
        pictures=tuple(
            strip(
                context, measured, Run(THESIS_RECIPE, recording), f"figure-6.{k}",
                f"Fig. 6.{k}: {name}, by the thesis's recipe, evenly over the sequence.",
            )
            for k, (name, recording) in enumerate(sequences(context).items(), start=5)
        ),
        verdicts=tuple(
            verdict
            for method, by_sequence in tracked.items()
            for verdict in _verdicts(method, by_sequence)
        ),
        numbers={
            method: {name: _as_json(each) for name, each in by_sequence.items()}
            for method, by_sequence in tracked.items()
        },
    )  # fmt: skip


def tracked_users(measured: Measured, variant: Variant, recording: Counterpart) -> TrackedUsers:
    evaluation = measured.of([Run(variant, recording)])
    fps = recording.make().fps
    lost = sum(times_lost(errors.samples, fps) for errors in evaluation.sequences)
    return TrackedUsers(summarise(evaluation), lost)


def _verdicts(method: str, by_sequence: Mapping[str, TrackedUsers]) -> tuple[Verdict, Verdict]:
    exchanges = sum(each.exchanges for each in by_sequence.values())
    lost = sum(each.lost for each in by_sequence.values())
    slowest = min(each.summary.frames_per_second for each in by_sequence.values())
    return (
        conclusion(
            f"tracking stays consistent over long sequences with occlusions (Sec. 6.2), {method}",
            exchanges == 0 and lost == 0,
            f"{exchanges} exchanges of identity, people lost {lost} times",
        ),
        Verdict(
            "ahead" if slowest >= THESIS_FPS[1] else "behind",
            f"Speed, one core, {method}",
            f"{number(slowest)} frames per second or more, thesis {THESIS_FPS[0]:g} to "
            f"{THESIS_FPS[1]:g} on its machine",
        ),
    )


def _cells(tracked: TrackedUsers) -> tuple[str, ...]:
    summary = tracked.summary
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
        str(tracked.exchanges),
        str(tracked.lost),
        percent(summary.tracking.mota),
        percent(summary.tracking.hota),
        number(summary.frames_per_second),
    )


def _as_json(tracked: TrackedUsers) -> dict[str, Any]:
    summary = tracked.summary
    return {
        "recall": summary.recall,
        "precision": summary.precision,
        "missed": summary.people.missed,
        "id_swaps": tracked.exchanges,
        "lost": tracked.lost,
        "mota": summary.tracking.mota,
        "hota": summary.tracking.hota,
        "frames_per_second": summary.frames_per_second,
    }
