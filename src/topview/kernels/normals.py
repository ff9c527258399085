"""Which way the surface faces that a depth image shows."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import solve_lower

# Ours. A plane is fitted to so many pixels on each side, no farther off in depth than this, if at
# least this share of them is the person's.
SIDE_PIXELS, LARGEST_STEP_M, LEAST_SEEN_SHARE = 3, 0.06, 0.55
RIDGE = 1e-9  # of squared slopes of rays: pixels in one line tell no slope across it


@njit(cache=True, error_model="numpy")
def surface_normals(points, depth, mine, fx, fy, cx, cy, out):
    """Fill `out` [N, 3] with unit normals towards the camera, camera frame, or zeros where too
    little is seen: of the plane, a p_x + b p_y + c p_z = 1, that fits one over the depth best.

    Args:
        points: [N, 3] metres, camera frame, of some of the pixels.
        depth: [H, W] float32 metres; mine: [H, W] bool, the person's pixels.
    """
    H, W = depth.shape
    A, g = np.empty((3, 3)), np.empty(3)
    least = LEAST_SEEN_SHARE * (2 * SIDE_PIXELS + 1) ** 2
    for i in range(points.shape[0]):
        z = points[i, 2]
        row = int(np.round(fy * points[i, 1] / z + cy))
        column = int(np.round(fx * points[i, 0] / z + cx))
        A[:] = 0.0
        g[:] = 0.0
        for v in range(max(row - SIDE_PIXELS, 0), min(row + SIDE_PIXELS + 1, H)):
            for u in range(max(column - SIDE_PIXELS, 0), min(column + SIDE_PIXELS + 1, W)):
                if not mine[v, u] or abs(depth[v, u] - z) > LARGEST_STEP_M:
                    continue
                x, y, inverse = (u - column) / fx, (v - row) / fy, 1.0 / depth[v, u]
                A[0, 0] += x * x
                A[1, 0] += x * y
                A[1, 1] += y * y
                A[2, 0] += x
                A[2, 1] += y
                A[2, 2] += 1.0
                g[0] += x * inverse
                g[1] += y * inverse
                g[2] += inverse
        if A[2, 2] < least:
            out[i, 0] = out[i, 1] = out[i, 2] = 0.0
            continue
        A[0, 0] += RIDGE
        A[1, 1] += RIDGE
        solve_lower(A, g)
        g[2] -= g[0] * (column - cx) / fx + g[1] * (row - cy) / fy
        norm = np.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
        for k in range(3):
            out[i, k] = -g[k] / norm
