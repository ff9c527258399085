"""Fig. 5.7: what the pixels of a hypothesis are, for a torso that somebody else hides in part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from topview.body.proportions import THESIS
from topview.geometry.rotations import rotations_from_angles
from topview.score.definition import Cylinder, Pixels, characterise
from topview.track.methods.utvr import UtvrSettings
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.cylinders import Layer, Observation, ViewName
from topview_lab.reproduce.occlusion import true_torso_hidden
from topview_lab.reproduce.plots import (
    HIDDEN_COLOR,
    IN_COLOR,
    OUT_COLOR,
    POINTS_COLOR,
    SUBJECT_COLOR,
    drawn,
)
from topview_lab.reproduce.runs import Counterpart
from topview_lab.reproduce.section import Picture, Row, Section, Table, percent
from topview_lab.sim import SimulatedRecording, simulate_truth

WANTED_HIDDEN: Final = 0.4
"""The frame is shown in which the share of the torso that is hidden is nearest to this (ours)."""
TURN_DEG: Final = (-5.0, 0.0, 15.0)
"""Of the hypothesis from the true torso, so that it has pixels of each kind (ours)."""


def scenes_5_7(context: Context) -> list[Counterpart]:
    return context.dummy_sequences()[-1:]


def figure_5_7(context: Context) -> Section:
    observation = _observation(context)
    hypothesis = observation.torso(
        rotations_from_angles(np.radians(TURN_DEG)), length_share=THESIS.torso
    )
    pixels = characterise(hypothesis, observation.observed.view, UtvrSettings().tolerance_m)
    path = context.picture("figure-5.7.png")
    _draw(path, observation, hypothesis, pixels)
    kinds = {"inliers": pixels.is_in, "outliers": pixels.is_out, "occluded": pixels.is_occluded}
    total = len(pixels.surface_camera)
    return Section(
        name="figure-5.7",
        title="Figure 5.7: what the pixels of a hypothesis are",
        text=(
            "The torso of a user whom another one hides in part, as one cylinder as in the "
            f"thesis's figure; turned by {TURN_DEG[0]:g} degrees in pitch and {TURN_DEG[2]:g} in "
            "roll from the true one. Inliers lie within T of the observed surface, occluded pixels "
            "behind it by more, outliers before it by more or where nothing was seen.",
        ),
        tables=(
            Table(
                ("pixels of the hypothesis", "number", "share"),
                tuple(
                    Row((kind, str(is_kind.sum()), percent(float(is_kind.mean()))))
                    for kind, is_kind in kinds.items()
                ),
            ),
        ),
        pictures=(
            Picture(
                path,
                "(a) the colour image; (b, c) the points of both users and the hypothesis, from "
                "the front and from the side; (d, e) D_3D, the user's points inside, in green and "
                "the rest of the two users in red; (f) the hypothesis's pixels from the front: "
                "inliers green, outliers red, occluded blue.",
            ),
        ),
        numbers={"pixels": total, **{kind: int(is_kind.sum()) for kind, is_kind in kinds.items()}},
    )


def _observation(context: Context) -> Observation:
    """The frame in which the dummy hides about as much as is wanted."""
    (sequence,) = scenes_5_7(context)
    recording = SimulatedRecording(sequence.make())
    truth = simulate_truth(recording.scene)
    frame = int(np.abs(true_torso_hidden(truth)[:, 0] - WANTED_HIDDEN).argmin())
    return Observation.of(recording, truth, frame)


def _draw(path: Path, observation: Observation, hypothesis: Cylinder, pixels: Pixels) -> None:
    own, other = observation.own_camera, observation.other_camera
    is_inside = hypothesis.contains(own)
    people: list[Layer] = [(other, POINTS_COLOR), (own, SUBJECT_COLOR)]
    parts: list[Layer] = [
        (np.concatenate([other, own[~is_inside]]), OUT_COLOR),
        (own[is_inside], IN_COLOR),
    ]
    kinds: list[Layer] = [
        (np.concatenate([other, own]), POINTS_COLOR),
        (pixels.surface_camera[pixels.is_occluded], HIDDEN_COLOR),
        (pixels.surface_camera[pixels.is_out], OUT_COLOR),
        (pixels.surface_camera[pixels.is_in], IN_COLOR),
    ]
    panels: list[tuple[str, ViewName, Sequence[Layer]]] = [
        ("(b) the hypothesis, front", "front", people),
        ("(c) the hypothesis, side", "side", people),
        ("(d) D_3D and D_all, front", "front", parts),
        ("(e) D_3D and D_all, side", "side", parts),
        ("(f) kinds of pixels, front", "front", kinds),
    ]
    with drawn(path, 2, 3, (3.5, 3.5)) as axes:
        _draw_color(axes[0, 0], observation)
        for ax, (title, view, layers) in zip(axes.flat[1:], panels, strict=True):
            observation.draw(ax, view, layers, hypothesis, size=2.0)
            ax.set(title=title, ylabel="above the neck, m", **_limits(observation, view))
        axes[1, 2].set(xlim=(-0.4, 0.4), ylim=(-0.7, 0.1))


def _limits(observation: Observation, view: ViewName) -> dict[str, tuple[float, float]]:
    """A square that holds both users, without the noise at their edges."""
    points = np.concatenate([observation.own_camera, observation.other_camera])
    low, high = np.percentile(observation.flat(points, view), (1.0, 99.0), axis=0)
    middle, half = (low + high) / 2, 0.55 * float((high - low).max())
    return {
        f"{axis}lim": (float(m - half), float(m + half))
        for axis, m in zip("xy", middle, strict=True)
    }


def _draw_color(ax: Any, observation: Observation) -> None:
    ax.imshow(observation.color)
    ax.set(title="(a) colour", xticks=[], yticks=[])
    ax.grid(False)
