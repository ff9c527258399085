"""The torso's yaw: a belief over all yaws, from the ellipses that its points fit (Sec. 5.1.4).

An elliptic torso looks alike from front and back, and seen from the side, little tells its yaw. So
the filter keeps a probability of every yaw, and of how fast it changes (ours), and carries both
from frame to frame: whoever turns round goes on turning. What tells front from back is in
`topview.track.methods.btvr.yaw_cues`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.filter.turning import (
    N_YAWS,
    RATES_RAD,
    YAWS_RAD,
    evidence_share,
    normalised,
    of_somebody_new,
    turned_on,
    wrapped,
)
from topview.track.methods.btvr.ellipses import CENTRE_SIGMA_M, fit_ellipses
from topview.track.methods.btvr.torso_shape import TorsoShape

Array = NDArray[np.float64]

# All ours.
FIRST_YAW_SIGMA_RAD: Final = 1.2  # of somebody new, from facing the camera
OUTLIER_LIKELIHOOD: Final = 1e-4  # added to every yaw's: the evidence may be wrong altogether
MEAN_WITHIN_RAD: Final = 0.6  # the mean is taken over the yaws this near to the likeliest
LEAST_SECTION_POINTS: Final = 15  # fewer tell nothing
MOST_SECTION_POINTS: Final = 100  # of more, a share: neighbours tell the same
FREE_CENTRE_SIGMA_M: Final = 1.0  # of the centre of an ellipse that goes wherever it fits


@dataclass(frozen=True, slots=True)
class Section:
    """A piece of the torso that is seen along its axis, as shares of the stature.

    Attributes:
        top, bottom: from the neck joint down.
        semi_axes: of its ellipse, across and from back to front.
        reach: points this near to the axis belong to it.
    """

    top: float
    bottom: float
    semi_axes: tuple[float, float]
    reach: float


SHOULDER_SECTION: Final = Section(0.0, 0.07, (0.13, 0.06), 0.16)  # ours
TRUNK_SECTION: Final = Section(0.08, 0.31, (0.095, 0.065), 0.12)  # ours


class YawFilter:
    """One person's yaw over time, 0 for facing the camera; whoever is new faces it more or less, as
    the thesis finds people by their faces, or may face any way."""

    def __init__(self, any_first_yaw: bool = False) -> None:
        yaws = np.exp(-0.5 * (YAWS_RAD / FIRST_YAW_SIGMA_RAD) ** 2)
        facing_camera = normalised(np.repeat(yaws[None], len(RATES_RAD), axis=0))
        self._belief = of_somebody_new() if any_first_yaw else facing_camera  # [rates, yaws]

    @property
    def yaw_rad(self) -> float:
        """The mean of the yaws around the likeliest one."""
        belief = self._belief.sum(0)
        near = np.convolve(np.tile(belief, 3), np.ones(5), "same")[N_YAWS : 2 * N_YAWS]
        middle = YAWS_RAD[int(np.argmax(near))]
        off = wrapped(YAWS_RAD - middle)
        weights = np.where(np.abs(off) < MEAN_WITHIN_RAD, belief, 0.0)
        return float(wrapped(middle + (weights @ off) / weights.sum()))

    def update(self, points: Array, stature_m: float, behind: float, frames: float = 1.0) -> float:
        """The yaw in the next frame.

        Args:
            points: [N, 3] metres in the frame of a torso of yaw 0, with its origin below the head,
                at the height of the neck joint.
            stature_m: of the person.
            behind: share of it by which the torso's axis is behind the head.
            frames: of `FRAME_S` that have gone by.
        """
        self._belief = turned_on(self._belief, frames)
        costs = np.zeros(N_YAWS)
        for section in (SHOULDER_SECTION, TRUNK_SECTION):
            costs += _costs(points, stature_m, behind, section)
        log_likelihood = -0.5 * evidence_share(frames) * (costs - costs.min())
        alike = np.maximum(log_likelihood, np.roll(log_likelihood, N_YAWS // 2))
        self._belief = normalised(self._belief * (np.exp(alike) + OUTLIER_LIKELIHOOD))
        return self.yaw_rad

    def fuse(self, log_likelihood: Array) -> None:
        """Multiply the belief by the likelihood of other evidence, [N_YAWS] for `YAWS_RAD`."""
        self._belief = normalised(self._belief * np.exp(log_likelihood))


class EllipseYaw:
    """One person's yaw by the best ellipse of each frame alone (Fig. 5.3 a), 0 for facing the
    camera.

    The ellipse is as large as the cylinder. Of the two opposite yaws that it fits alike, the one
    that faces the camera is taken: the thesis finds people by their faces.
    """

    def __init__(self, shape: TorsoShape) -> None:
        self._shape = shape
        self.yaw_rad = 0.0

    def update(self, points: Array, stature_m: float, behind: float, frames: float = 1.0) -> float:
        """The yaw in the next frame, as `YawFilter.update`."""
        shape = self._shape
        section = Section(0.0, shape.length, shape.semi_axes, shape.half_width)
        costs = _costs(points, stature_m, behind - shape.ahead, section, FREE_CENTRE_SIGMA_M)
        if costs.any():
            self.yaw_rad = float(wrapped(2.0 * YAWS_RAD[costs.argmin()]) / 2.0)
        return self.yaw_rad

    def fuse(self, log_likelihood: Array) -> None:
        """Nothing but the ellipse counts."""


def _costs(
    points: Array,
    stature_m: float,
    behind: float,
    section: Section,
    centre_sigma_m: float = CENTRE_SIGMA_M,
) -> Array:
    """[N_YAWS] squared deviations of a section's points, in standard deviations; zeros where there
    are too few."""
    chosen = points_of(points, stature_m, section)
    if len(chosen) < LEAST_SECTION_POINTS:
        return np.zeros(N_YAWS)
    semi_axes_m = stature_m * np.array(section.semi_axes)
    centres = -behind * stature_m * np.stack([np.sin(YAWS_RAD), np.cos(YAWS_RAD)], axis=1)
    return fit_ellipses(chosen, semi_axes_m, YAWS_RAD, centres, centre_sigma_m=centre_sigma_m)[0]


def points_of(points: Array, stature_m: float, section: Section) -> Array:
    """[M, 2] across and from back to front, of the points [N, 3] of a section; a share of them if
    there are many."""
    x, y, z = points.T / stature_m
    inside = (y > section.top) & (y < section.bottom) & (np.hypot(x, z) < section.reach)
    chosen = points[inside][:, [0, 2]]
    return chosen[:: max(1, len(chosen) // MOST_SECTION_POINTS)]
