"""Fig. 5.4: f_bTVR over pitch and roll has its minimum at the true torso, occluded or not."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import UPPER_TORSO
from topview.body.proportions import THESIS
from topview.camera.projection import pixel_rays
from topview.camera.pyramid import DepthView
from topview.geometry.rotations import rotations_from_angles, unit
from topview.kernels.threads import use_threads
from topview.score.utvr import placed_parts, score_hypotheses
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.occlusion import is_in_band, true_torso_hidden
from topview_lab.reproduce.plots import figure
from topview_lab.reproduce.printed import OCCLUSIONS, Occlusion
from topview_lab.reproduce.section import (
    Picture,
    Row,
    Section,
    Table,
    conclusion,
    number,
    percent,
)
from topview_lab.sim import GroundTruth, SimulatedRecording, simulate_truth

Array = NDArray[np.float64]

ANGLES_DEG: Final = np.arange(-60.0, 60.1, 4.0)
"""Distance of the hypotheses from the truth, in pitch and in roll."""
ADDED_RADIUS_M: Final = 0.02
"""Added to the radii, so that the points on the surface lie inside (ours)."""
MOST_M: Final = 0.3
"""How far the trunk's surface lies from the line between shoulders and hips, at most (ours)."""
SHOWN: Final = 5.0
"""Plots end at so many times the least value."""
NEAR_DEG: Final = 10.0
"""A minimum is at the truth within so much (the accuracy of Ch. 6)."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """f_bTVR [pitch, roll] of one frame, infinite without evidence."""

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
    surfaces = _surfaces(context)
    shown: dict[Occlusion, Surface] = {
        level: _median(found) for level, found in surfaces.items() if found
    }
    path = context.picture("figure-5.4.png")
    _draw(path, shown)
    errors = {level: np.array([s.error_deg for s in found]) for level, found in surfaces.items()}
    return Section(
        name="figure-5.4",
        title="Figure 5.4: f_bTVR over pitch and roll",
        text=(
            "The torso as one elliptic cylinder in simulated frames of two users, one of whom "
            "occludes the other. Hypotheses are turned away from the true torso about its upper "
            f"end; f_bTVR (Eq. 5.1) every {ANGLES_DEG[1] - ANGLES_DEG[0]:g} degrees. How far its "
            "least value lies from the truth, which is where the anatomical centres of shoulders "
            "and hips are.",
        ),
        tables=(
            Table(
                ("torso occluded", "frames", "minimum off, mean °", "median °", "within 10°",
                 "its pitch, °", "its roll, °"),
                tuple(_row(level, found) for level, found in surfaces.items()),
            ),
        ),
        pictures=(
            Picture(
                path,
                "f_bTVR of one frame for each share of occlusion (that with the median distance); "
                "the truth is at (0, 0), the cross is the minimum.",
            ),
        ),
        verdicts=(
            conclusion(
                "f_bTVR has its global minimum at or close to the truth for 0, 30 and 60 % "
                "occlusion (Sec. 5.1.5)",
                all(median(error) <= NEAR_DEG for error in errors.values()),
                "median distance "
                + ", ".join(f"{number(median(error))}° at {k}" for k, error in errors.items()),
                [median(error) for error in errors.values()],
            ),
        ),
        numbers={
            "angles_deg": ANGLES_DEG.tolist(),
            "minimum_off_deg": {level: error.tolist() for level, error in errors.items()},
        },
    )  # fmt: skip


def median(values: Array) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _row(level: Occlusion, found: list[Surface]) -> Row:
    if not found:
        return Row((level, "0", *["–"] * 5))
    error = np.array([surface.error_deg for surface in found])
    pitch, roll = np.array([surface.least_deg for surface in found]).T
    return Row((
        level,
        str(len(found)),
        number(float(error.mean())),
        number(median(error)),
        percent(float((error <= NEAR_DEG).mean())),
        f"{pitch.mean():+.1f} ± {pitch.std():.1f}",
        f"{roll.mean():+.1f} ± {roll.std():.1f}",
    ))  # fmt: skip


def _surfaces(context: Context) -> dict[Occlusion, list[Surface]]:
    """Of some frames of each share of occlusion, evenly over those that there are."""
    use_threads(1)
    sequences = context.dummy_sequences()
    wanted = context.size(48, 8) // len(sequences)
    found: dict[Occlusion, list[Surface]] = {level: [] for level in OCCLUSIONS}
    for sequence in sequences:
        recording = SimulatedRecording(sequence.make())
        truth = simulate_truth(recording.scene)
        hidden = true_torso_hidden(truth)[:, 0]
        for level in OCCLUSIONS:
            frames = np.flatnonzero(is_in_band(hidden, level))
            for frame in frames[:: max(1, len(frames) // wanted)][:wanted]:
                found[level].append(surface(recording, truth, int(frame)))
    return found


def surface(recording: SimulatedRecording, truth: GroundTruth, frame: int) -> Surface:
    """f_bTVR around the true torso of the first person."""
    simulated = recording.simulate(frame)
    camera = recording.camera
    depth_m = simulated.depth_mm.astype(np.float32) / np.float32(1000.0)
    points = (pixel_rays(camera) * depth_m[..., None])[(simulated.mask == 1) & (depth_m > 0)]
    joints = dict(zip(truth.names, truth.joints[frame, 0].astype(np.float64), strict=True))
    model = BodyModel.of(float(truth.stature[0]), THESIS)
    radii_m = model.radii_m[UPPER_TORSO] + ADDED_RADIUS_M
    R_true, top, length_m = _true_torso(joints)
    top = top + _to_surface(points, R_true, top, length_m, radii_m)

    pitch, roll = np.radians(np.meshgrid(ANGLES_DEG, ANGLES_DEG, indexing="ij"))
    turns = np.stack([pitch, np.zeros_like(pitch), roll], axis=-1).reshape(-1, 3)
    Rs = R_true @ rotations_from_angles(turns)
    x, y, z = (np.ascontiguousarray(column, np.float32) for column in points.T)
    terms = score_hypotheses(
        Rs,
        top,
        length_m,
        radii_m,
        (x, y, z),
        DepthView(depth_m, camera.fx, camera.fy, camera.cx, camera.cy),
        placed_parts(np.empty((0, 3, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 2))),
        tolerance_m=0.05,
        threads=1,
    )
    hidden_area = float(truth.person_occ_person[frame, 0])
    score = np.where(terms.has_evidence, terms.btvr(hidden_area), np.inf)
    return Surface(score.reshape(pitch.shape))


def _true_torso(joints: dict[str, Array]) -> tuple[Array, Array, float]:
    """R_camera_torso, its upper end in metres and its length, from shoulders and hips."""
    top = 0.5 * (joints["shoulder_l"] + joints["shoulder_r"])
    down = joints["pelvis"] - top
    y = unit(down)
    across = joints["shoulder_r"] - joints["shoulder_l"]
    x = unit(across - y * (across @ y))
    return np.stack([x, y, np.cross(x, y)], axis=1), top, float(np.linalg.norm(down))


def _to_surface(
    points: Array, R_camera_torso: Array, top: Array, length_m: float, radii_m: Array
) -> Array:
    """[3] shift along the torso's front that brings the cylinder's surface to the points: the
    anatomical centres do not lie in the middle of the trunk."""
    x, y, z = ((points - top) @ R_camera_torso).T
    is_torso = (np.abs(x) < 0.7 * radii_m[0]) & (y > 0) & (y < length_m) & (np.abs(z) < MOST_M)
    side = np.sign(np.median(z[is_torso])) if is_torso.any() else 0.0
    surface = side * radii_m[1] * np.sqrt(1.0 - (x[is_torso] / radii_m[0]) ** 2)
    shift_m = float(np.median(z[is_torso] - surface)) if is_torso.any() else 0.0
    return shift_m * R_camera_torso[:, 2]


def _median(surfaces: list[Surface]) -> Surface:
    return sorted(surfaces, key=lambda s: s.error_deg)[len(surfaces) // 2]


def _draw(path: Path, shown: dict[Occlusion, Surface]) -> None:
    pitch, roll = np.meshgrid(ANGLES_DEG, ANGLES_DEG, indexing="ij")
    with figure(path, (10.5, 6.6)) as fig:
        for k, (level, surface_) in enumerate(shown.items()):
            score = np.minimum(surface_.score, SHOWN * surface_.score.min())
            ax = fig.add_subplot(2, 3, k + 1, projection="3d")
            ax.plot_surface(pitch, roll, score, cmap="viridis", linewidth=0)
            ax.set(xlabel="pitch, °", ylabel="roll, °", title=f"{level} occluded")
            flat = fig.add_subplot(2, 3, k + 4)
            image = flat.pcolormesh(ANGLES_DEG, ANGLES_DEG, score, cmap="viridis", shading="auto")
            best_pitch, best_roll = surface_.least_deg
            flat.plot(best_roll, best_pitch, "x", color="white", markersize=9, markeredgewidth=2)
            flat.axhline(0, color="white", alpha=0.4, linewidth=0.8)
            flat.axvline(0, color="white", alpha=0.4, linewidth=0.8)
            flat.grid(False)
            flat.set(xlabel="roll, °", ylabel="pitch, °", aspect="equal")
            fig.colorbar(image, ax=flat, shrink=0.8, label="f_bTVR")
        fig.tight_layout()
