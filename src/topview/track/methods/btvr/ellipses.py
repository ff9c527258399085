"""Ellipses of known size, fitted to points of which only a side may be seen (Fig. 5.3 a).

Seen along its axis a torso is an ellipse. For every yaw one is moved onto the points (ours), so
that a yaw which the points do not tell, as that of a torso seen from the side, stays uncertain.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


# All ours.
RESIDUAL_SCALE_M: Final = 0.05  # width of the robust weight: clothes are off the ellipse
ITERATIONS: Final = 4  # Gauss-Newton steps
INDEPENDENT_READINGS: Final = 60.0  # what all points together count for: neighbours err alike
READING_SIGMA_M: Final = 0.02  # of one such reading
CENTRE_SIGMA_M: Final = 0.03  # of the centre from where it is expected


def fit_ellipses(
    points: Array,
    semi_axes_m: Array,
    yaws_rad: Array,
    centres: Array,
    *,
    centre_sigma_m: float = CENTRE_SIGMA_M,
    iterations: int = ITERATIONS,
) -> tuple[Array, Array]:
    """Move an ellipse of each yaw onto points.

    Args:
        points: [N, 2] metres.
        semi_axes_m: [2], the first along (cos, -sin) of the yaw.
        yaws_rad: [K].
        centres: [K, 2] where the centres are expected.
        centre_sigma_m: standard deviation of a centre from there.
        iterations: Gauss-Newton steps.

    Returns:
        [K] costs, as squares of standard deviations, and [K, 2] centres.
    """
    cos, sin = np.cos(yaws_rad), np.sin(yaws_rad)
    Rs = np.stack([np.stack([cos, -sin], 1), np.stack([sin, cos], 1)], 1)  # to the ellipses' axes
    weight = INDEPENDENT_READINGS / (max(len(points), 1) * READING_SIGMA_M**2)
    prior_weight = centre_sigma_m**-2.0
    found = centres.copy()
    costs = np.zeros(len(yaws_rad))
    for iteration in range(iterations + 1):
        own = (points - found[:, None]) @ np.swapaxes(Rs, 1, 2)
        gaps, normals = _gaps(own, semi_axes_m)
        robust = 1.0 / (1.0 + (gaps / RESIDUAL_SCALE_M) ** 2)
        off = found - centres
        costs = weight * (robust * gaps**2).sum(1) + prior_weight * (off**2).sum(1)
        if iteration < iterations:
            slopes = -normals @ Rs
            pulled = slopes * (weight * robust**2)[..., None]
            A = np.swapaxes(pulled, 1, 2) @ slopes + prior_weight * np.eye(2)
            b = (pulled * gaps[..., None]).sum(1) + prior_weight * off
            found = found - np.linalg.solve(A, b[..., None])[..., 0]
    return costs, found


def _gaps(own: Array, semi_axes_m: Array) -> tuple[Array, Array]:
    """[K, N] signed distances of [K, N, 2] points from an ellipse, to first order, and the [K, N,
    2] directions in which they grow."""
    size = np.maximum(np.sqrt(((own / semi_axes_m) ** 2).sum(-1)), 1e-6)
    gradient = own / semi_axes_m**2 / size[..., None]
    steepness = np.maximum(np.sqrt((gradient**2).sum(-1)), 1e-6)
    return (size - 1.0) / steepness, gradient / steepness[..., None]
