"""Ellipses of known size, fitted to points of which only a side may be seen (Fig. 5.3 a).

Seen along its axis a torso is an ellipse. For every yaw one is moved onto the points (ours), so
that a yaw which the points do not tell, as that of a torso seen from the side, stays uncertain.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.kernels.ellipses import move_ellipses

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
    costs, found = np.empty(len(yaws_rad)), np.empty((len(yaws_rad), 2))
    move_ellipses(
        np.ascontiguousarray(points),
        semi_axes_m,
        yaws_rad,
        centres,
        INDEPENDENT_READINGS / (max(len(points), 1) * READING_SIGMA_M**2),
        RESIDUAL_SCALE_M,
        centre_sigma_m**-2.0,
        iterations,
        costs,
        found,
    )
    return costs, found
