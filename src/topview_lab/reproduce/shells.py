"""Fig. 3.2: the re-projection ratio of a cylinder's shell has its minimum at the top view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from topview.geometry.rotations import rotations_from_angles
from topview.score.definition import Cylinder, top_view_cells
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.plots import OVERALL_COLOR, drawn
from topview_lab.reproduce.section import (
    Picture,
    Row,
    Section,
    Table,
    conclusion,
    number,
    percent,
)

Array = NDArray[np.float64]

LENGTH_M: Final = 0.5
SPACING_M: Final = 0.01
"""Between neighbouring points: a Kinect's at 2.6 m, every second pixel (ours); and the cells."""
VIEW_TILTS_DEG: Final = np.arange(-90.0, 90.1, 3.0)
DEEP: Final = 0.25
"""A second minimum counts if it is this deep, as a share of the first one's depth (ours)."""


@dataclass(frozen=True, slots=True)
class Shell:
    """The surface of an elliptic cylinder as points.

    Attributes:
        radii_m: semi-axes.
        seen_rad: which part of the circumference is there, centred on the front.
        hidden: another object hides this much of the length, and of what is there of the
            circumference.
        noise_m: standard deviation of the points' distances from the axis.
    """

    name: str
    radii_m: tuple[float, float]
    seen_rad: float = 2 * np.pi
    hidden: tuple[float, float] = (0.0, 0.0)
    noise_m: float = 0.0

    def points(self, rng: np.random.Generator) -> Array:
        """[N, 3] evenly spread points in the cylinder's frame, y along it from 0."""
        a, b = self.radii_m
        girth_m = 2 * np.pi * np.sqrt((a * a + b * b) / 2)  # of the whole ellipse, nearly
        angles = rng.uniform(-np.pi, np.pi, int(girth_m * LENGTH_M / SPACING_M**2))
        heights = rng.uniform(0.0, 1.0, len(angles))
        is_seen = np.abs(angles) <= self.seen_rad / 2
        length, girth = self.hidden
        is_hidden = (heights < length) & (angles / self.seen_rad + 0.5 < girth)
        angles, heights = angles[is_seen & ~is_hidden], heights[is_seen & ~is_hidden]
        noise_m = self.noise_m * rng.standard_normal(len(angles))
        x, z = (a + noise_m) * np.sin(angles), (b + noise_m) * np.cos(angles)
        return np.stack([x, LENGTH_M * heights, z], axis=1)


CIRCLE: Final = (0.12, 0.12)
ELLIPSE: Final = (0.17, 0.11)
SHELLS: Final[tuple[Shell, ...]] = (
    Shell("full, circular", CIRCLE),
    Shell("full, elliptic", ELLIPSE),
    Shell("half, circular", CIRCLE, np.pi),
    Shell("half, elliptic", ELLIPSE, np.pi),
    Shell("half, elliptic, 30 % occluded", ELLIPSE, np.pi, (0.6, 0.5)),
    Shell("half, elliptic, 60 % occluded", ELLIPSE, np.pi, (0.8, 0.75)),
    Shell("half, elliptic, noise of 1 cm", ELLIPSE, np.pi, noise_m=0.01),
    Shell("the same, 60 % occluded", ELLIPSE, np.pi, (0.8, 0.75), 0.01),
)


def ratios(shell: Shell, rng: np.random.Generator) -> Array:
    """[T] f_reproj (Eq. 3.1) seen along axes that are tilted about x by `VIEW_TILTS_DEG`."""
    points = shell.points(rng)
    tilts = np.zeros((len(VIEW_TILTS_DEG), 3))
    tilts[:, 0] = np.radians(VIEW_TILTS_DEG)
    result = []
    for R in rotations_from_angles(tilts):
        T = np.eye(4)
        T[:3, :3] = R
        cells = top_view_cells(Cylinder(T, LENGTH_M, shell.radii_m), points, SPACING_M)
        result.append(len(cells) / len(points))
    return np.array(result)


def minima(ratio: Array) -> list[int]:
    """Places of the local minima that are deep enough, the deepest first."""
    depth = float(ratio.max() - ratio.min())
    padded = np.concatenate([[ratio.max()], ratio, [ratio.max()]])
    places, _ = find_peaks(-padded, prominence=DEEP * depth)
    return sorted((int(place) - 1 for place in places), key=lambda place: float(ratio[place]))


def figure_3_2(context: Context) -> Section:
    rng = np.random.default_rng(context.seed)
    curves = {shell: ratios(shell, rng) for shell in SHELLS}
    path = context.picture("figure-3.2.png")
    with drawn(path, 2, 4, (2.6, 2.3)) as axes:
        for ax, (shell, ratio) in zip(axes.flat, curves.items(), strict=True):
            best = int(ratio.argmin())
            ax.plot(VIEW_TILTS_DEG, ratio, color=OVERALL_COLOR)
            ax.plot(VIEW_TILTS_DEG[best], ratio[best], "o", color=OVERALL_COLOR)
            ax.set(title=shell.name, xticks=range(-90, 91, 45), ylim=(0, 1))
        for ax in axes[-1]:
            ax.set_xlabel("view to axis, degrees")
        for ax in axes[:, 0]:
            ax.set_ylabel("f_reproj")
    rows, is_single = [], True
    for shell, ratio in curves.items():
        found = minima(ratio)
        is_single &= len(found) == 1 and bool(abs(VIEW_TILTS_DEG[found[0]]) <= 3.0)
        rows.append(
            Row((
                shell.name,
                f"{VIEW_TILTS_DEG[found[0]]:+.0f}°",
                str(len(found)),
                number(float(ratio.min()), 2),
                number(float(ratio.max()), 2),
                percent(1.0 - float(ratio.min() / ratio.max())),
            ))
        )  # fmt: skip
    return Section(
        name="figure-3.2",
        title="Figure 3.2: f_reproj over the angle of view",
        text=(
            f"Points on the shells of cylinders {LENGTH_M:g} m long, {100 * SPACING_M:g} cm apart "
            "as a depth camera would have them, looked at along axes that are tilted away from the "
            "cylinder's own. Occupied cells over points, Eq. 3.1.",
        ),
        tables=(
            Table(("shell", "minimum at", "minima", "least", "greatest", "depth"), tuple(rows)),
        ),
        pictures=(Picture(path, "f_reproj over the angle; the dot is the least value."),),
        verdicts=(
            conclusion(
                "f_reproj has one minimum, at the top view (Sec. 3.1)",
                is_single,
                f"{len(rows)} shells, full and half, circular and elliptic, occluded or not, with "
                "noise or without",
            ),
        ),
        numbers={
            "tilts_deg": VIEW_TILTS_DEG.tolist(),
            "f_reproj": {shell.name: ratio.tolist() for shell, ratio in curves.items()},
        },
    )
