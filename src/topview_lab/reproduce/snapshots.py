"""Figs. 5.5, 5.6, 6.1 and 6.4: frames of what the tables measure, with the skeletons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from topview.track.methods.btvr import BtvrSettings
from topview_lab.datasets import EvaluatedRecording
from topview_lab.metrics import CAUSES, Samples
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.mhad import actions, boxers
from topview_lab.reproduce.runs import THESIS_RECIPE, Counterpart, Measured, Run, Variant
from topview_lab.reproduce.section import Section
from topview_lab.reproduce.strips import Shown, Tile, picture_of, strip, tiles_of

UPPER_BODY: Final = Variant(BtvrSettings())
_BY_ANOTHER: Final = CAUSES.index("another person")


def runs_5_5(context: Context) -> list[Run]:
    return [Run(UPPER_BODY, context.own_sequences()[0])]


def figure_5_5(context: Context, measured: Measured) -> Section:
    (run,) = runs_5_5(context)
    told = "One user alone, by bTVR."
    return Section(
        name="figure-5.5",
        title="Figure 5.5: bTVR, one user whose body hides parts of itself",
        text=("Frames of a sequence of Table 5.2, evenly over it.",),
        pictures=(strip(context, measured, run, "figure-5.5", told),),
    )


def runs_5_6(context: Context) -> list[Run]:
    return [Run(UPPER_BODY, context.dummy_sequences()[0])]


def figure_5_6(context: Context, measured: Measured) -> Section:
    (run,) = runs_5_6(context)
    told = "Two users, by bTVR; the share of the rear one's joints that the other hides."
    shown = Shown(note=_hidden)
    return Section(
        name="figure-5.6",
        title="Figure 5.6: bTVR, users who occlude each other",
        text=(
            "Frames of a sequence of Table 5.2, evenly over it. The thesis shows NiTE beside; that "
            "is a closed binary.",
        ),
        pictures=(strip(context, measured, run, "figure-5.6", told, shown),),
    )


def runs_figure_6_1(context: Context) -> list[Run]:
    return [Run(THESIS_RECIPE, r) for r in (*actions(context), *boxers(context))]


def figure_6_1(context: Context, measured: Measured) -> Section:
    """The middle frame of each recording of Tables 6.1 and 6.2."""
    told = "by the thesis's recipe, the middle frame of each recording."
    return Section(
        name="figure-6.1",
        title="Figure 6.1: bodies and actions of Tables 6.1 and 6.2",
        text=("The middle frame of every recording of the two tables.",),
        pictures=(
            picture_of(
                context, "figure-6.1-actions", f"Actions of Table 6.2, {told}",
                _middles(measured, actions(context), lambda own: own.scene.replace("_", " ")),
            ),
            picture_of(
                context, "figure-6.1-bodies", f"Bodies of Table 6.1, {told}",
                _middles(measured, boxers(context), lambda own: own.body),
            ),
        ),
    )  # fmt: skip


def _middles(
    measured: Measured,
    recordings: Sequence[EvaluatedRecording],
    short: Callable[[Counterpart], str],
) -> list[Tile]:
    """The middle frame of each; `short` names a simulated one."""
    return [
        replace(tile, caption=(_named(recording, short), tile.caption[0]))
        for recording in recordings
        for tile in tiles_of(Run(THESIS_RECIPE, recording), measured, Shown(tiles=1))
    ]


def _named(recording: EvaluatedRecording, short: Callable[[Counterpart], str]) -> str:
    return short(recording) if isinstance(recording, Counterpart) else recording.name


def runs_figure_6_4(context: Context) -> list[Run]:
    return [Run(THESIS_RECIPE, context.dummy_sequences()[0])]


def figure_6_4(context: Context, measured: Measured) -> Section:
    (run,) = runs_figure_6_4(context)
    told = "The rear user, by the thesis's recipe; the share of the joints that the other hides."
    shown = Shown(subject_alone=True, note=_hidden)
    return Section(
        name="figure-6.4",
        title="Figure 6.4: a user who is occluded by another",
        text=(
            "Frames of a sequence of Table 6.4, evenly over it. The user in front plays the dummy "
            "and is not drawn. The thesis shows the Kinect SDK beside; that is a closed binary.",
        ),
        pictures=(strip(context, measured, run, "figure-6.4", told, shown),),
    )


def _hidden(samples: Samples, frame: int) -> str:
    """How much of the first person another one hides."""
    where = (samples.frame == frame) & (samples.person == 0)
    shares = samples.hidden[where, :, _BY_ANOTHER]
    return f"{100 * shares.mean():.0f} % hidden" if where.any() else ""
