"""What tells things from a person that they are taken for a part of."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.noise import Law, law_at

# Whole numbers add up to the same in any order, so that several may be added at once.
STEPS_OF_A_SHARE = 1024


@njit(cache=True, error_model="numpy", nogil=True)
def mean_around(places, points, shares, radius, out):
    """Fill `out` [M] with the mean of the shares of all points within a radius of each place, 0
    where there are none.

    Args:
        places, points: [M, 3] and [N, 3] metres.
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
    for i in range(places.shape[0]):
        count, total = np.int32(0), np.int32(0)
        px, py, pz = np.float32(places[i, 0]), np.float32(places[i, 1]), np.float32(places[i, 2])
        for j in range(N):
            dx, dy, dz = x[j] - px, y[j] - py, z[j] - pz
            near = np.int32(dx * dx + dy * dy + dz * dz <= squared)
            count = np.int32(count + near)
            total = np.int32(total + near * steps[j])
        out[i] = total / (max(count, 1) * STEPS_OF_A_SHARE)


@njit(cache=True, error_model="numpy", nogil=True)
def forget_changed(depth_m: np.ndarray, stays: Law, last_m: np.ndarray, known: np.ndarray) -> None:
    """Forget what is known of pixels whose depth is no longer what it was.

    Args:
        depth_m: [H, W] metres, 0 where nothing is read, which changes nothing.
        stays: how far a reading may be off the last one, of the same place.
        last_m: [H, W] last readings; taken over.
        known: [H, W] becomes 0 where the reading has changed.
    """
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            depth = depth_m[row, column]
            if depth > 0.0:
                if abs(depth - last_m[row, column]) >= law_at(depth, stays):
                    known[row, column] = 0.0
                last_m[row, column] = depth
