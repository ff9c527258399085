"""Ellipses in an image: made from the moments of pixels; distances of points (Eq. 4.3 - 4.7)."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from topview.kernels.skin import label_inside

Points = NDArray[np.floating]
Box = tuple[int, int, int, int]
"""Left, top, right, bottom; all inside."""

PIXEL_VARIANCE: Final = 1.0 / 12.0
"""Variance of the places within one square pixel, along x or y."""


class Moments(NamedTuple):
    """Moments of pixels: the means of x and y, the variances, and the covariance."""

    x: float
    y: float
    xx: float
    yy: float
    xy: float

    def moved(self, dx: float, dy: float) -> Moments:
        """The moments of the same pixels, moved."""
        return Moments(self.x + dx, self.y + dy, self.xx, self.yy, self.xy)


class Ellipse(msgspec.Struct, frozen=True):
    """A filled ellipse h(c_x, c_y, alpha, beta, theta), in pixels.

    Attributes:
        x, y: the centre.
        major, minor: the semi-axes.
        angle: radians from the x-axis to the major axis, towards +y; in (-pi/2, pi/2].
    """

    x: float
    y: float
    major: float
    minor: float
    angle: float

    @property
    def parameters(self) -> tuple[float, float, float, float, float]:
        """Its attributes, in order."""
        return self.x, self.y, self.major, self.minor, self.angle

    @classmethod
    def of_moments(cls, moments: Moments, spread_px: float = 0.0) -> Ellipse:
        """The filled ellipse that has these moments.

        The semi-axes are 2 sqrt(lambda), of which Eq. 4.6 leaves out the 2; in Eq. 4.7 the sign
        before 4 s_xy^2 is plus. `spread_px` is the standard deviation of each pixel's place.
        """
        more = PIXEL_VARIANCE + spread_px * spread_px
        s_xx, s_yy, s_xy = moments.xx + more, moments.yy + more, moments.xy
        root = sqrt((s_xx - s_yy) ** 2 + 4.0 * s_xy * s_xy)
        large, small = 0.5 * (s_xx + s_yy + root), 0.5 * (s_xx + s_yy - root)
        angle = 0.5 * atan2(2.0 * s_xy, s_xx - s_yy)
        axes = 2.0 * sqrt(large), 2.0 * sqrt(max(small, more))
        return cls(moments.x, moments.y, *axes, angle)

    @property
    def center(self) -> NDArray[np.float64]:
        """[2] (x, y)."""
        return np.array([self.x, self.y])

    @property
    def area(self) -> float:
        """Square pixels."""
        return pi * self.major * self.minor

    def distance(self, points: Points) -> NDArray[np.float64]:
        """[...] D(p, h) of [..., 2] points (Eq. 4.3, 4.4): 1 on the ellipse, less inside.

        Rotated into the axes first and scaled by them then; the thesis prints it the other way
        round.
        """
        c, s = cos(self.angle), sin(self.angle)
        dx, dy = points[..., 0] - self.x, points[..., 1] - self.y
        return np.hypot((c * dx + s * dy) / self.major, (c * dy - s * dx) / self.minor)

    def is_near(self, box: Box) -> bool:
        """Whether any point of a box may lie inside."""
        left, top, right, bottom = box
        x, y, reach = self.x, self.y, self.major
        return left <= x + reach and x - reach <= right and top <= y + reach and y - reach <= bottom

    def count(self, points: Points) -> int:
        """How many of [N, 2] points lie inside."""
        return int(np.count_nonzero(self.distance(points) <= 1.0))

    def label_inside(self, label_of: NDArray[np.int32], labels: int) -> int:
        """The label, up to `labels`, of which most pixels of [h, w] lie inside, 0 where none
        does."""
        middle, axes = (self.x, self.y), (self.major, self.minor)
        return label_inside(label_of, labels, middle, axes, (cos(self.angle), sin(self.angle)))

    def contains_center_of(self, other: Ellipse) -> bool:
        """Whether the other ellipse's centre lies inside."""
        dx, dy = other.x - self.x, other.y - self.y
        c, s = cos(self.angle), sin(self.angle)
        return hypot((c * dx + s * dy) / self.major, (c * dy - s * dx) / self.minor) <= 1.0

    def scaled(self, factor: float, shift: float = 0.0) -> Ellipse:
        """The same in an image of `factor` times the size, moved by `shift` in x and y."""
        return Ellipse(
            self.x * factor + shift,
            self.y * factor + shift,
            self.major * factor,
            self.minor * factor,
            self.angle,
        )
