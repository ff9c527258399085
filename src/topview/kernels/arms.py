"""Depth discrepancy of many rendered arms (Sec. 5.1.4): two circular cylinders in a row each.

Each hypothesis is compared on its own, so the result does not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.cylinders import NO_HIT, hit_depth
from topview.kernels.threads import over_threads

# Whose pixels are.
OTHERS, OPEN, BODYS = 0, 1, 2
N_SUMS = 3
DIFFERENCE, PIXELS, EXPLAINED = range(N_SUMS)


@njit(error_model="numpy")
def _frame(axis, R):
    """A rotation whose y is `axis`; the turn about it is any, as the cylinder is round."""
    k = 0
    for i in range(1, 3):
        if abs(axis[i]) < abs(axis[k]):
            k = i
    norm = np.float32(0.0)
    for i in range(3):
        R[i, 1] = axis[i]
        R[i, 0] = (np.float32(1.0) if i == k else np.float32(0.0)) - axis[k] * axis[i]
        norm += R[i, 0] * R[i, 0]
    for i in range(3):
        R[i, 0] /= np.sqrt(norm)
    R[0, 2] = R[1, 0] * R[2, 1] - R[2, 0] * R[1, 1]
    R[1, 2] = R[2, 0] * R[0, 1] - R[0, 0] * R[2, 1]
    R[2, 2] = R[0, 0] * R[1, 1] - R[1, 0] * R[0, 1]


@njit(error_model="numpy")
def _box(start, end, radius, fx, fy, cx, cy, W, H, out):
    """The pixels that a cylinder between two places can cover: u from, to, v from, to."""
    near = max(min(start[2], end[2]) - radius, np.float32(0.05))
    far = max(max(start[2], end[2]) + radius, np.float32(0.05))
    for i in range(2):
        f, c, side = (fx, cx, W) if i == 0 else (fy, cy, H)
        low = min(start[i], end[i]) - radius
        high = max(start[i], end[i]) + radius
        low = f * min(low / near, low / far) + c
        high = f * max(high / near, high / far) + c + np.float32(2.0)
        out[2 * i] = np.int32(min(max(low, np.float32(0.0)), np.float32(side)))
        out[2 * i + 1] = np.int32(min(max(high, np.float32(0.0)), np.float32(side)))


@njit(error_model="numpy", forceinline=True)
def _cost(seen, depth, whose, cap, hidden, buried):
    """What one rendered pixel costs, in metres."""
    if whose == BODYS and seen < depth:  # the own body lies before it, or holds it
        return min(depth - seen, buried)
    if whose == OTHERS:  # a pixel without a reading tells nothing, as one before which others are
        return hidden if seen < depth else cap
    return min(abs(seen - depth), cap)


@over_threads("shoulders")
@njit(cache=True, error_model="numpy", nogil=True)
def compare_arms(
    first_row, row_step,
    shoulders, axes, lengths, radii, depth, whose, worth, fx, fy, cx, cy, cap, hidden, buried, out,
):  # fmt: skip
    """Fill `out` [M, 3]: the summed difference in metres between what is rendered and what is seen,
    the rendered pixels, and the worth of the OPEN ones that they explain.

    Args:
        shoulders, axes: [M, 3] metres and [M, 2, 3] directions of upper arm and forearm, float32.
        lengths, radii: [2] float32 metres.
        depth: [H, W] float32 metres, 0 without a reading.
        whose: [H, W] uint8: OPEN, the user's and nothing else explains it; BODYS, the user's, but
            of another part; OTHERS, the rest.
        worth: [H, W] float32, how much each OPEN pixel needs an arm, 0 to 1.
        fx, fy, cx, cy: float32 intrinsics in pixels.
        cap: float32 metres, the largest difference of a pixel, and that of free space; less than
            it explains an OPEN pixel.
        hidden, buried: float32 metres, the difference of a pixel that is behind something else or
            without a reading, and the largest of one behind the user's own body, or inside of it.
        out: [M, 3] float64.
    """
    H, W = depth.shape
    inv2 = np.float32(1.0) / (radii * radii)
    for m in range(first_row, shoulders.shape[0], row_step):
        R = np.empty((2, 3, 3), np.float32)
        start = np.empty((3, 3), np.float32)  # shoulder, elbow, palm
        eye = np.empty((2, 3), np.float32)  # the camera's centre in the cylinders' frames
        box = np.empty((2, 4), np.int32)
        nearest = np.empty(W, np.float32)
        for i in range(3):
            start[0, i] = shoulders[m, i]
            start[1, i] = start[0, i] + lengths[0] * axes[m, 0, i]
            start[2, i] = start[1, i] + lengths[1] * axes[m, 1, i]
        for k in range(2):
            _frame(axes[m, k], R[k])
            for i in range(3):
                eye[k, i] = -(
                    R[k, 0, i] * start[k, 0] + R[k, 1, i] * start[k, 1] + R[k, 2, i] * start[k, 2]
                )
            _box(start[k], start[k + 1], radii[k], fx, fy, cx, cy, W, H, box[k])
        u_low, u_high = min(box[0, 0], box[1, 0]), max(box[0, 1], box[1, 1])
        v_low, v_high = min(box[0, 2], box[1, 2]), max(box[0, 3], box[1, 3])
        difference, pixels, explained = np.float32(0.0), 0, np.float32(0.0)
        for v in range(v_low, v_high):
            ry = (np.float32(v) - cy) / fy
            for u in range(u_low, u_high):
                nearest[u] = NO_HIT
            for k in range(2):
                if v < box[k, 2] or v >= box[k, 3]:
                    continue
                ex, ey, ez = eye[k, 0], eye[k, 1], eye[k, 2]
                dx, dy, dz = R[k, 0, 0], R[k, 0, 1], R[k, 0, 2]
                qx = R[k, 1, 0] * ry + R[k, 2, 0]
                qy = R[k, 1, 1] * ry + R[k, 2, 1]
                qz = R[k, 1, 2] * ry + R[k, 2, 2]
                length, inv = lengths[k], inv2[k]
                for u in range(box[k, 0], box[k, 1]):
                    rx = (np.float32(u) - cx) / fx
                    t = hit_depth(
                        ex, ey, ez, dx * rx + qx, dy * rx + qy, dz * rx + qz, length, inv, inv
                    )
                    nearest[u] = min(nearest[u], t)
            for u in range(u_low, u_high):
                if nearest[u] < NO_HIT:
                    pixels += 1
                    cost = _cost(depth[v, u], nearest[u], whose[v, u], cap, hidden, buried)
                    difference += cost
                    is_explained = (whose[v, u] == OPEN) & (cost < cap)
                    explained += worth[v, u] if is_explained else np.float32(0.0)
        out[m, DIFFERENCE] = difference
        out[m, PIXELS] = pixels
        out[m, EXPLAINED] = explained
