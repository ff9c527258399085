"""Fig. 5.2: hypotheses of the upper torso, right and wrong, and their top views."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, cos, degrees, radians
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.proportions import THESIS
from topview.geometry.rotations import rotations_from_angles
from topview.kernels.threads import use_threads
from topview.score.definition import Cylinder, top_view_cells
from topview.score.utvr import UtvrTerms, score_hypotheses
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.cylinders import AROUND, Observation
from topview_lab.reproduce.plots import IN_COLOR, POINTS_COLOR, drawn
from topview_lab.reproduce.runs import Counterpart
from topview_lab.reproduce.section import Picture, Row, Section, Table, number
from topview_lab.sim import SimulatedRecording, simulate_truth

TURNS_DEG: Final = np.arange(-75.0, 75.1, 5.0)
"""From the true torso, in pitch and in roll."""
LEAST_POINTS: Final = 0.5
"""A hypothesis is shown with this share of the best one's points inside, or more (ours)."""
CM: Final = 100.0


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """A hypothesis of the figure: what it is an example of, its turn and what it scores."""

    what: str
    cylinder: Cylinder
    pitch_deg: float
    roll_deg: float
    n_points: int
    reproj: float
    align: float

    @property
    def off_deg(self) -> float:
        """Angle between its axis and the true one."""
        return degrees(acos(cos(radians(self.pitch_deg)) * cos(radians(self.roll_deg))))


def scenes_5_2(context: Context) -> list[Counterpart]:
    return context.own_sequences()[:1]


def figure_5_2(context: Context) -> Section:
    use_threads(1)
    (sequence,) = scenes_5_2(context)
    recording = SimulatedRecording(sequence.make())
    truth = simulate_truth(recording.scene)
    observation = Observation.of(recording, truth, sequence.frames // 2)
    shown = exemplars(observation)
    path = context.picture("figure-5.2.png")
    _draw(path, observation, shown)
    return Section(
        name="figure-5.2",
        title="Figure 5.2: hypotheses of the upper torso and their top views",
        text=(
            "The middle frame of the first sequence of Table 6.4. Hypotheses of the upper torso "
            f"are turned away from the true one, every {TURNS_DEG[1] - TURNS_DEG[0]:g} degrees "
            "in pitch and roll. Of these the figure shows that with the least f_reproj × f_align; "
            "that with the greatest f_reproj; and, of those with no greater f_reproj than the "
            "first, that with the greatest f_align.",
        ),
        tables=(
            Table(
                ("hypothesis", "pitch, °", "roll, °", "axis off, °", "N_3D", "f_reproj",
                 "f_align", "product"),
                tuple(_row(each) for each in shown),
            ),
        ),
        pictures=(
            Picture(
                path,
                "Above: the user's points, those inside the cylinder in green, seen from an angle. "
                "Below: these seen along the cylinder's axis, and the cells that they occupy. The "
                "sensor's steps of depth are seen as stripes.",
            ),
        ),
        numbers={
            each.what: {
                "pitch_deg": each.pitch_deg, "roll_deg": each.roll_deg, "n_3d": each.n_points,
                "f_reproj": each.reproj, "f_align": each.align,
            }
            for each in shown
        },
    )  # fmt: skip


def exemplars(observation: Observation) -> list[Shown]:
    """The right one, the one with a high f_reproj, and the misaligned one with a low f_reproj."""
    pitch, roll = (a.ravel() for a in np.meshgrid(TURNS_DEG, TURNS_DEG, indexing="ij"))
    turns = rotations_from_angles(np.radians(np.stack([pitch, 0.0 * pitch, roll], axis=1)))
    cylinders = [observation.torso(turn, THESIS.waist) for turn in turns]
    terms = _scored(observation, cylinders)
    best = int(np.where(terms.has_evidence, terms.reproj * terms.align, np.inf).argmin())
    is_shown = terms.has_evidence & (terms.n_points >= LEAST_POINTS * terms.n_points[best])
    is_as_low = is_shown & (terms.reproj <= terms.reproj[best])
    chosen = {
        "least product": best,
        "high f_reproj": _greatest(terms.reproj, is_shown),
        "low f_reproj, high f_align": _greatest(terms.align, is_as_low),
    }
    return [
        Shown(
            what, cylinders[k], float(pitch[k]), float(roll[k]), int(terms.n_points[k]),
            float(terms.reproj[k]), float(terms.align[k]),
        )
        for what, k in chosen.items()
    ]  # fmt: skip


def _greatest(values: NDArray[np.float64], where: NDArray[np.bool_]) -> int:
    return int(np.where(where, values, -np.inf).argmax())


def _scored(observation: Observation, cylinders: list[Cylinder]) -> UtvrTerms:
    Ts = np.stack([cylinder.T_camera_part for cylinder in cylinders])
    return score_hypotheses(
        Ts[:, :3, :3],
        Ts[:, :3, 3],
        cylinders[0].length_m,
        np.array(cylinders[0].radii_m),
        observation.observed,
        np.empty((0, 15), np.float32),
        tolerance_m=0.05,
        threads=1,
    )


def _row(shown: Shown) -> Row:
    return Row((
        shown.what,
        f"{shown.pitch_deg:+.0f}",
        f"{shown.roll_deg:+.0f}",
        number(shown.off_deg, 0),
        str(shown.n_points),
        number(shown.reproj, 2),
        number(shown.align, 2),
        number(shown.reproj * shown.align, 2),
    ))  # fmt: skip


def _draw(path: Path, observation: Observation, shown: list[Shown]) -> None:
    with drawn(path, 2, len(shown), (3.5, 3.4)) as axes:
        for k, each in enumerate(shown):
            _draw_points(axes[0, k], observation, each)
            _draw_top_view(axes[1, k], observation, each)
            axes[0, k].set_title(f"({'abc'[k]}) {each.what}")
        axes[0, 0].set_ylabel("above the neck, m")
        axes[1, 0].set_ylabel("to the part's front, cm")


def _draw_points(ax: Any, observation: Observation, shown: Shown) -> None:
    points = observation.own_camera
    is_inside = shown.cylinder.contains(points)
    layers = [(points[~is_inside], POINTS_COLOR), (points[is_inside], IN_COLOR)]
    observation.draw(ax, "oblique", layers, shown.cylinder, size=2.5)
    ax.set(xlim=(-0.4, 0.4), ylim=(-0.5, 0.3))


def _draw_top_view(ax: Any, observation: Observation, shown: Shown) -> None:
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    cylinder = shown.cylinder
    inside = observation.own_camera[cylinder.contains(observation.own_camera)]
    cell_m = observation.observed.view.cell_m(float(cylinder.T_camera_part[2, 3]))
    cells_cm = CM * cell_m * top_view_cells(cylinder, inside, cell_m)
    squares = [Rectangle((x, z), CM * cell_m, CM * cell_m) for x, z in cells_cm]
    ax.add_collection(PatchCollection(squares, color=IN_COLOR, alpha=0.35, linewidth=0))
    x, _, z = CM * cylinder.points_part(inside).T
    ax.plot(x, z, ".", color=IN_COLOR, markersize=2.0)
    rx, rz = (CM * radius for radius in cylinder.radii_m)
    ax.plot(rx * np.sin(AROUND), rz * np.cos(AROUND), color=POINTS_COLOR, linewidth=2.0)
    ax.set(
        xlabel="to the part's right, cm",
        aspect="equal",
        xlim=(-1.1 * rx, 1.1 * rx),
        ylim=(-1.1 * rz, 1.1 * rz),
        title=f"f_reproj {shown.reproj:.2f},  f_align {shown.align:.2f}",
    )
