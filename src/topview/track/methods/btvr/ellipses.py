"""Ellipses of known size, fitted to points of which only a side may be seen (Fig. 5.3 a).

Seen along its axis a torso is an ellipse. One of each turn is moved onto the points (ours), so
that what is uncertain, as a torso seen from the side, stays so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class EllipseSettings:
    """Ours; metres.

    Attributes:
        scale_m: width of the robust weight: sleeves and folds of cloth are off the ellipse.
        iterations: Gauss-Newton steps.
        worth: how many independent readings all points are worth: neighbouring ones err alike.
        noise_m: of such a reading.
        centre_sigma_m: how far the centre may be from where it is expected.
    """

    scale_m: float = 0.05
    iterations: int = 4
    worth: float = 60.0
    noise_m: float = 0.02
    centre_sigma_m: float = 0.03


def fit_ellipses(
    points: Array, semi_axes_m: Array, turns_rad: Array, centres: Array, settings: EllipseSettings
) -> tuple[Array, Array]:
    """Move an ellipse of each turn onto points.

    Args:
        points: [N, 2] metres.
        semi_axes_m: [2], the first along (cos, -sin) of the turn.
        turns_rad: [K].
        centres: [K, 2] where the centres are expected.
        settings: of the fit.

    Returns:
        [K] costs, as squares of standard deviations, and [K, 2] centres.
    """
    s = settings
    cos, sin = np.cos(turns_rad), np.sin(turns_rad)
    Rs = np.stack([np.stack([cos, -sin], 1), np.stack([sin, cos], 1)], 1)  # to the ellipses' axes
    weight = s.worth / (max(len(points), 1) * s.noise_m**2)
    hold = s.centre_sigma_m**-2.0
    found = centres.copy()
    costs = np.zeros(len(turns_rad))
    for iteration in range(s.iterations + 1):
        own = (points - found[:, None]) @ np.swapaxes(Rs, 1, 2)
        gaps, normals = _gaps(own, semi_axes_m)
        robust = 1.0 / (1.0 + (gaps / s.scale_m) ** 2)
        off = found - centres
        costs = weight * (robust * gaps**2).sum(1) + hold * (off**2).sum(1)
        if iteration < s.iterations:
            slopes = -normals @ Rs
            pulled = slopes * (weight * robust**2)[..., None]
            A = np.swapaxes(pulled, 1, 2) @ slopes + hold * np.eye(2)
            b = (pulled * gaps[..., None]).sum(1) + hold * off
            found = found - np.linalg.solve(A, b[..., None])[..., 0]
    return costs, found


def _gaps(own: Array, semi_axes_m: Array) -> tuple[Array, Array]:
    """[K, N] signed distances of [K, N, 2] points from an ellipse, to first order, and the [K, N,
    2] directions in which they grow."""
    size = np.maximum(np.sqrt(((own / semi_axes_m) ** 2).sum(-1)), 1e-6)
    gradient = own / semi_axes_m**2 / size[..., None]
    steepness = np.maximum(np.sqrt((gradient**2).sum(-1)), 1e-6)
    return (size - 1.0) / steepness, gradient / steepness[..., None]
