"""Where rays enter round cones, for all pixels and solids of an image."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def draw_round_cones(x, y, windows, balls, cones, bounds, nearest, depth, solid):
    """Draw what rays (x, y, 1) enter before `depth`, the camera at 0.

    Args:
        x, y: [W] and [H] of the rays.
        windows: [N, 4] first and last row, first and last column, of which the last are not looked
            at.
        balls: [N, 2, 10] as of `_entry`; no cone lies between two of which one holds the other.
        cones: [N, 10] of the surfaces between them.
        bounds: [N, 5] y0, w and y1: the surfaces end where not 0 < y0 + t (w . ray) < y1.
        nearest: metres; what is nearer is not entered.
        depth: [H, W] metres.
        solid: [H, W] numbers of the solids.
    """
    for n in range(windows.shape[0]):
        y0, w0, w1, w2, y1 = bounds[n]
        for v in range(windows[n, 0], windows[n, 1]):
            for u in range(windows[n, 2], windows[n, 3]):
                t = _entry(balls[n, 0], x[u], y[v], nearest)
                if y1 > 0.0:
                    between = _entry(cones[n], x[u], y[v], nearest)
                    height = y0 + between * (w0 * x[u] + (w1 * y[v] + w2))
                    if (height > 0.0) & (height < y1):
                        t = min(t, between)
                t = min(t, _entry(balls[n, 1], x[u], y[v], nearest))
                if t < depth[v, u]:
                    depth[v, u] = t
                    solid[v, u] = n


@njit(error_model="numpy")
def _entry(quadric, x, y, nearest):
    """Parameter at which the ray (x, y, 1) enters a quadric, inf where it does not: [10] a, b, c,
    d, e, f above and on the diagonal of Q, row by row, q and k0."""
    a, b, c, d, e, f, p, q, r, k0 = quadric
    k2 = (a * x + 2.0 * c) * x + ((d * y + 2.0 * e) * y + f) + (2.0 * b * y) * x
    k1 = p * x + (q * y + r)
    t = (-k1 - np.sqrt(k1 * k1 - k0 * k2)) / k2
    return t if t > nearest else np.inf
