"""What a lens does to an image: from the ideal place of a ray to where it is seen, and back.

Places are normalised, [..., 2]: x / z and y / z of a point of the camera frame. With
r^2 = x^2 + y^2 and coefficients k1 k2 p1 p2 k3 k4 k5 k6 in OpenCV's order, 0 where not given,

    f = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
    x' = f x + 2 p1 x y + p2 (r^2 + 2 x^2)
    y' = f y + p1 (r^2 + 2 y^2) + 2 p2 x y

"brown_conrady" and "rational" take ideal places to those that are seen by it, as OpenCV's
`projectPoints` does; the Azure Kinect calls its rational model "Brown-Conrady", and has the same
formula. "inverse_brown_conrady" takes those that are seen to the ideal ones by it, as librealsense
defines it (`rs_types.h`). The other direction has no formula in any of them: Newton's method finds
it.

A polynomial says nothing beyond where it was fitted: further out it comes back towards the centre.
Places from there on are NaN.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Distortion

Places = NDArray[np.float64]
Slopes = tuple[Places, Places, Places, Places]

# Ours: no depth camera looks further aside than 80 degrees; and steps in which the radius at which
# the polynomial comes back is sought.
RADII: Final = np.linspace(0.0, np.tan(np.radians(80.0)), 4001)
NEWTON_STEPS: Final = 20  # ours; from a start that only lacks the tangential part, 4 are enough
CONVERGED: Final = 1e-10  # ours; of normalised places: a ten-millionth of a pixel


def distort(places: NDArray[np.floating], distortion: Distortion | None) -> Places:
    """[..., 2] where the lens shows ideal places, NaN where its model does not hold."""
    if distortion is None or distortion.is_none:
        return np.array(places, np.float64)
    is_inverse = distortion.model == "inverse_brown_conrady"
    with np.errstate(all="ignore"):
        return (_solved if is_inverse else _bent)(places, distortion.coefficients)


def undistort(places: NDArray[np.floating], distortion: Distortion | None) -> Places:
    """[..., 2] the ideal places of what the lens shows, NaN where its model does not hold."""
    if distortion is None or distortion.is_none:
        return np.array(places, np.float64)
    is_inverse = distortion.model == "inverse_brown_conrady"
    with np.errstate(all="ignore"):
        return (_bent if is_inverse else _solved)(places, distortion.coefficients)


def _bent(places: NDArray[np.floating], coefficients: tuple[float, ...]) -> Places:
    """[..., 2] by the formula, as far as it holds."""
    x, y = np.moveaxis(np.asarray(places, np.float64), -1, 0)
    bent, slopes = _formula(x, y, coefficients)
    return np.where(_is_held(x, y, slopes, coefficients)[..., None], np.stack(bent, -1), np.nan)


def _solved(places: NDArray[np.floating], coefficients: tuple[float, ...]) -> Places:
    """[..., 2] what the formula takes to the given places."""
    u, v = np.moveaxis(np.asarray(places, np.float64), -1, 0)
    radii, bent_radii = _radial(coefficients)
    seen = np.hypot(u, v)
    factor = np.interp(seen, bent_radii, radii) / np.maximum(seen, 1e-12)
    x, y = u * factor, v * factor
    for _ in range(NEWTON_STEPS):
        (bent_x, bent_y), (xx, xy, yx, yy) = _formula(x, y, coefficients)
        off_x, off_y = bent_x - u, bent_y - v
        if np.maximum(np.abs(off_x), np.abs(off_y)).max(initial=0.0) < CONVERGED:
            break
        determinant = np.maximum(xx * yy - xy * yx, 1e-6)
        x = x - (yy * off_x - xy * off_y) / determinant
        y = y - (xx * off_y - yx * off_x) / determinant
    (bent_x, bent_y), slopes = _formula(x, y, coefficients)
    is_held = np.hypot(bent_x - u, bent_y - v) < 1e3 * CONVERGED
    is_held &= _is_held(x, y, slopes, coefficients)
    return np.where(is_held[..., None], np.stack([x, y], -1), np.nan)


def _is_held(
    x: Places, y: Places, slopes: Slopes, coefficients: tuple[float, ...]
) -> NDArray[np.bool_]:
    """[...] where the formula has not come back yet."""
    xx, xy, yx, yy = slopes
    radii, _ = _radial(coefficients)
    return (np.hypot(x, y) <= radii[-1]) & (xx * yy > xy * yx)


def _formula(
    x: Places, y: Places, coefficients: tuple[float, ...]
) -> tuple[tuple[Places, Places], Slopes]:
    """x' and y', and their derivatives: of x' by x and y, of y' by x and y."""
    k1, k2, p1, p2, k3, k4, k5, k6 = (*coefficients, *(0.0,) * (8 - len(coefficients)))
    s = x * x + y * y
    above, below = _cubic(s, k1, k2, k3), _cubic(s, k4, k5, k6)
    f = above / below
    # Of f by s, which itself changes by 2 x and 2 y.
    slope = 2.0 * (k1 + s * (2.0 * k2 + 3.0 * k3 * s)) / below
    slope -= 2.0 * f * (k4 + s * (2.0 * k5 + 3.0 * k6 * s)) / below
    bent_x = f * x + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x)
    bent_y = f * y + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y
    across = slope * x * y + 2.0 * (p1 * x + p2 * y)
    return (bent_x, bent_y), (
        f + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
        across,
        across,
        f + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
    )


def _cubic(s: Places, a: float, b: float, c: float) -> Places:
    return 1.0 + s * (a + s * (b + s * c))


@lru_cache(maxsize=16)
def _radial(coefficients: tuple[float, ...]) -> tuple[Places, Places]:
    """[R] radii and [R] what the formula's radial part makes of them, while both rise."""
    k1, k2, _, _, k3, k4, k5, k6 = (*coefficients, *(0.0,) * (8 - len(coefficients)))
    s = RADII * RADII
    below = _cubic(s, k4, k5, k6)
    bent = RADII * _cubic(s, k1, k2, k3) / np.where(below > 0.0, below, 1.0)
    falls = (below[1:] <= 0.0) | (np.diff(bent) <= 0.0)
    end = 1 + (int(np.argmax(falls)) if falls.any() else len(falls))
    return RADII[:end], bent[:end]
