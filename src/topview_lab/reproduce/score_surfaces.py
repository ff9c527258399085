"""Fig. 5.4: f_bTVR over pitch and roll has its minimum at the true torso, occluded or not.

Cylinders hang below the true head. They are scored as `--method btvr` does it as printed, and as
it does by default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import rotations_from_angles
from topview.kernels.threads import use_threads
from topview.track.methods.btvr import BTVR_AS_PRINTED, BtvrSettings
from topview.track.methods.btvr.torso import (
    TorsoSettings,
    necks_below,
    upright_costs,
    view_scores,
)
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import is_in_band, true_torso_hidden
from topview_lab.reproduce.plots import figure
from topview_lab.reproduce.printed import OCCLUSIONS, Occlusion
from topview_lab.reproduce.section import (
    Picture,
    Row,
    Section,
    Table,
    Verdict,
    conclusion,
    number,
    percent,
)
from topview_lab.reproduce.true_torsos import TrueTorso
from topview_lab.sim import SimulatedRecording, simulate_truth

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

ANGLES_DEG: Final = np.arange(-60.0, 60.1, 4.0)
"""Distance of the hypotheses from the truth, in pitch and in roll."""
SHOWN: Final = 5.0
"""Plots end at so many times the least value."""
NEAR_DEG: Final = 10.0
"""A minimum is at the truth within so much (the accuracy of Ch. 6)."""
PRINTED_SCORE: Final = "btvr as printed"
DEFAULT_SCORE: Final = "btvr, the default"


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A score [pitch, roll] of one frame, infinite without evidence."""

    score: Array

    @property
    def least_deg(self) -> tuple[float, float]:
        """Pitch and roll of the global minimum."""
        pitch, roll = np.unravel_index(int(self.score.argmin()), self.score.shape)
        return float(ANGLES_DEG[pitch]), float(ANGLES_DEG[roll])

    @property
    def error_deg(self) -> float:
        """Angle between the axis of the minimum and the true one."""
        pitch, roll = (radians(angle) for angle in self.least_deg)
        return degrees(np.arccos(np.cos(pitch) * np.cos(roll)))


def figure_5_4(context: Context) -> Section:
    found = _surfaces(context)
    path = context.picture("figure-5.4.png")
    _draw(path, {name: _medians(surfaces) for name, surfaces in found.items()})
    errors: dict[str, dict[Occlusion, Array]] = {
        name: {level: np.array([s.error_deg for s in each]) for level, each in surfaces.items()}
        for name, surfaces in found.items()
    }
    return Section(
        name="figure-5.4",
        title="Figure 5.4: f_bTVR over pitch and roll",
        text=(
            "The torso as one elliptic cylinder in simulated frames of two users, one of whom "
            "occludes the other. Hypotheses are turned away from the true torso, every "
            f"{ANGLES_DEG[1] - ANGLES_DEG[0]:g} degrees. How far the least score lies from the "
            "truth, which is where the anatomical centres of shoulders and hips are.",
            "The cylinders hang below the true head. As printed, f_bTVR (Eq. 5.1) alone scores a "
            "cylinder as wide as the shoulders. The default leaves hidden pixels out of f_align "
            "and adds that people stand upright, the more the more of them is hidden.",
        ),
        tables=(
            Table(
                ("score, torso occluded", "frames", "minimum off, mean °", "median °",
                 "within 10°", "its pitch, °", "its roll, °"),
                tuple(
                    _row(f"{name}, {level}", each)
                    for name, surfaces in found.items()
                    for level, each in surfaces.items()
                ),
            ),
        ),
        pictures=(
            Picture(
                path,
                "The score of one frame for each share of occlusion (that with the median "
                "distance); the truth is at (0, 0), the cross is the minimum.",
            ),
        ),
        verdicts=tuple(_verdict(name, each) for name, each in errors.items()),
        numbers={
            "angles_deg": ANGLES_DEG.tolist(),
            "minimum_off_deg": {
                name: {level: error.tolist() for level, error in each.items()}
                for name, each in errors.items()
            },
        },
    )  # fmt: skip


def median(values: Array) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _verdict(name: str, errors: Mapping[Occlusion, Array]) -> Verdict:
    return conclusion(
        "f_bTVR has its global minimum at or close to the truth for 0, 30 and 60 % occlusion "
        f"(Sec. 5.1.5), {name}",
        all(median(error) <= NEAR_DEG for error in errors.values()),
        "median distance "
        + ", ".join(f"{number(median(error))}° at {k}" for k, error in errors.items()),
        [median(error) for error in errors.values()],
    )


def _row(name: str, found: list[Surface]) -> Row:
    if not found:
        return Row((name, "0", *["–"] * 5))
    error = np.array([surface.error_deg for surface in found])
    pitch, roll = np.array([surface.least_deg for surface in found]).T
    return Row((
        name,
        str(len(found)),
        number(float(error.mean())),
        number(median(error)),
        percent(float((error <= NEAR_DEG).mean())),
        f"{pitch.mean():+.1f} ± {pitch.std():.1f}",
        f"{roll.mean():+.1f} ± {roll.std():.1f}",
    ))  # fmt: skip


def _surfaces(context: Context) -> dict[str, dict[Occlusion, list[Surface]]]:
    """By each score, of some frames of each share of occlusion, evenly over all that there are."""
    use_threads(1)
    sequences = context.dummy_sequences()
    wanted = context.size(48, 8) // len(sequences)
    found: dict[str, dict[Occlusion, list[Surface]]] = {
        name: {level: [] for level in OCCLUSIONS} for name in SCORES
    }
    for sequence in sequences:
        recording = SimulatedRecording(sequence.make())
        truth = simulate_truth(recording.scene)
        hidden = true_torso_hidden(truth)[:, 0]
        for level in OCCLUSIONS:
            frames = np.flatnonzero(is_in_band(hidden, level))
            for frame in frames[:: max(1, len(frames) // wanted)][:wanted]:
                torso = TrueTorso.of(recording, truth, int(frame))
                for name, score in SCORES.items():
                    found[name][level].append(surface(torso, score))
    return found


def surface(torso: TrueTorso, score: Score) -> Surface:
    """A score around the true torso."""
    pitch, roll = np.radians(np.meshgrid(ANGLES_DEG, ANGLES_DEG, indexing="ij"))
    turns = np.stack([pitch, np.zeros_like(pitch), roll], axis=-1).reshape(-1, 3)
    Rs = torso.R_camera_torso @ rotations_from_angles(turns)
    return Surface(score(torso, Rs).reshape(pitch.shape))


def _score(torso: TrueTorso, Rs: Array, settings: TorsoSettings) -> Array:
    """[M] what `--method btvr` minimises."""
    necks = necks_below(torso.head_camera, Rs, torso.stature_m, settings.shape)
    scores = view_scores(
        Rs, necks, torso.stature_m, torso.observed, torso.hidden_share, settings,
        threads=1,
    )  # fmt: skip
    if settings.best_view:
        return scores
    return scores * np.exp(upright_costs(Rs[:, :, 1], torso.up_camera, torso.hidden_share))


Score = Callable[[TrueTorso, Array], Array]
SCORES: Final[dict[str, Score]] = {
    PRINTED_SCORE: partial(_score, settings=BTVR_AS_PRINTED.torso),
    DEFAULT_SCORE: partial(_score, settings=BtvrSettings().torso),
}


def _medians(surfaces: Mapping[Occlusion, list[Surface]]) -> dict[Occlusion, Surface]:
    """The surface of each share of occlusion whose distance is the median."""
    return {
        level: sorted(found, key=lambda s: s.error_deg)[len(found) // 2]
        for level, found in surfaces.items()
        if found
    }


def _draw(path: Path, shown: Mapping[str, Mapping[Occlusion, Surface]]) -> None:
    """f_bTVR as the thesis shows it, and all scores as maps below."""
    pitch, roll = np.meshgrid(ANGLES_DEG, ANGLES_DEG, indexing="ij")
    rows, columns = 1 + len(shown), len(OCCLUSIONS)
    with figure(path, (10.5, 3.3 * rows)) as fig:
        for level, each in shown[PRINTED_SCORE].items():
            place = 1 + OCCLUSIONS.index(level)
            ax = fig.add_subplot(rows, columns, place, projection="3d")
            ax.plot_surface(pitch, roll, _shown(each), cmap="viridis", linewidth=0)
            ax.set(xlabel="pitch, °", ylabel="roll, °", title=f"{level} occluded, {PRINTED_SCORE}")
        for row, (name, surfaces) in enumerate(shown.items(), start=1):
            for level, each in surfaces.items():
                place = row * columns + 1 + OCCLUSIONS.index(level)
                _draw_map(fig, fig.add_subplot(rows, columns, place), each, name)
        fig.tight_layout()


def _draw_map(fig: Figure, ax: Axes, surface_: Surface, name: str) -> None:
    image = ax.pcolormesh(ANGLES_DEG, ANGLES_DEG, _shown(surface_), cmap="viridis", shading="auto")
    best_pitch, best_roll = surface_.least_deg
    ax.plot(best_roll, best_pitch, "x", color="white", markersize=9, markeredgewidth=2)
    ax.axhline(0, color="white", alpha=0.4, linewidth=0.8)
    ax.axvline(0, color="white", alpha=0.4, linewidth=0.8)
    ax.grid(False)
    ax.set(xlabel="roll, °", ylabel="pitch, °", aspect="equal", title=name)
    fig.colorbar(image, ax=ax, shrink=0.8)


def _shown(surface_: Surface) -> Array:
    return np.minimum(surface_.score, SHOWN * surface_.score.min())
