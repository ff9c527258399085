"""What is told of a point's surroundings."""

from __future__ import annotations

import numpy as np
from numba import njit

# Whole numbers add up to the same in any order, so that several may be added at once.
STEPS_OF_A_SHARE = 1024


@njit(cache=True, error_model="numpy", nogil=True)
def mean_around(points, shares, radius, out):
    """Fill `out` [N] with the mean of the shares of all points within a radius of each.

    Args:
        points: [N, 3] metres.
        shares: [N] of the points, 0 to 1.
        radius: metres.
    """
    N = points.shape[0]
    x, y, z = np.empty(N, np.float32), np.empty(N, np.float32), np.empty(N, np.float32)
    steps = np.empty(N, np.int32)
    for i in range(N):
        x[i], y[i], z[i] = points[i, 0], points[i, 1], points[i, 2]
        steps[i] = np.int32(np.round(shares[i] * STEPS_OF_A_SHARE))
    squared = np.float32(radius * radius)
    for i in range(N):
        count, total = np.int32(0), np.int32(0)
        for j in range(N):
            dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
            near = np.int32(dx * dx + dy * dy + dz * dz <= squared)
            count = np.int32(count + near)
            total = np.int32(total + near * steps[j])
        out[i] = total / (count * STEPS_OF_A_SHARE)
