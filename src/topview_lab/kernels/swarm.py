"""Whole bodies rendered and compared with the depth image, for many poses at once.

One pose is eleven closed elliptic cylinders; its depth map is drawn into scratch memory that the
next pose draws over. Differences are summed as whole tenths of a millimetre, so that sums are
exact, and each pose is counted on its own: the result does not depend on the number of threads.
The objective that is made of it is `topview_lab.rivals.swarm.discrepancy_m`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.cylinders import NO_HIT, hit_depth, image_box
from topview.kernels.threads import over_threads

UNITS_PER_M = np.float32(10_000)
N_TERMS = 3
DEPTH_DIFFERENCE, BOTH, EITHER = range(N_TERMS)


@njit(error_model="numpy", forceinline=True)
def _draw(R, o, length, rx, rz, fx, fy, cx, cy, drawn):
    """Draw one cylinder into the depth map, where it is nearest."""
    H, W = drawn.shape
    u0, u1, v0, v1 = image_box(R, o, length, rx, rz, fx, fy, cx, cy, W, H)
    inv_rx2 = np.float32(1.0) / (rx * rx)
    inv_rz2 = np.float32(1.0) / (rz * rz)
    r00, r01, r02 = R[0, 0], R[0, 1], R[0, 2]
    # the camera's centre and the rays' directions in the part's frame
    qx = -(R[0, 0] * o[0] + R[1, 0] * o[1] + R[2, 0] * o[2])
    qy = -(R[0, 1] * o[0] + R[1, 1] * o[1] + R[2, 1] * o[2])
    qz = -(R[0, 2] * o[0] + R[1, 2] * o[1] + R[2, 2] * o[2])
    for v in range(v0, v1):
        ray_y = (np.float32(v) - cy) / fy
        ax = R[1, 0] * ray_y + R[2, 0]
        ay = R[1, 1] * ray_y + R[2, 1]
        az = R[1, 2] * ray_y + R[2, 2]
        row = drawn[v, u0:u1]
        for i in range(u1 - u0):
            ray_x = (np.float32(u0 + i) - cx) / fx
            t = hit_depth(
                qx, qy, qz, ax + r00 * ray_x, ay + r01 * ray_x, az + r02 * ray_x,
                length, inv_rx2, inv_rz2,
            )  # fmt: skip
            row[i] = min(row[i], t)


@over_threads("chunks")
@njit(cache=True, error_model="numpy", nogil=True)
def compare_bodies(
    first_row, row_step,
    Rs, origins, lengths, radii, depth, mine, fx, fy, cx, cy, clamp, match, chunks, out,
):  # fmt: skip
    """Fill `out` [M, 3]: sum of the clamped differences, pixels in both maps, pixels in either.

    What is seen nearer than the drawn body and is not the user's hides it: such pixels have no
    difference. Those without a reading differ in full, as the bare background.

    Args:
        Rs, origins: [B, M, 3, 3] and [B, M, 3] float32, `R_camera_part` and origin of each part.
        lengths, radii: [B] and [B, 2] float32 metres.
        depth: [H, W] float32 metres, 0 without a reading.
        mine: [H, W] bool, the user's pixels: o_s.
        fx, fy, cx, cy: intrinsics in pixels, float32.
        clamp, match: float32 metres, the largest difference that counts, and the one below which a
            drawn pixel is matched: r_m.
        chunks: how many pieces the poses are dealt to, one scratch memory each.
        out: [M, 3] int32, the sum in tenths of a millimetre.
    """
    B, M = Rs.shape[:2]
    H, W = depth.shape
    maps = np.empty((chunks, H, W), np.float32)
    full = np.int32(clamp * UNITS_PER_M)
    for chunk in range(first_row, chunks, row_step):
        drawn = maps[chunk]
        for m in range(chunk, M, chunks):
            drawn[:] = NO_HIT
            for k in range(B):
                _draw(
                    Rs[k, m], origins[k, m], lengths[k], radii[k, 0], radii[k, 1],
                    fx, fy, cx, cy, drawn,
                )  # fmt: skip
            difference, both, either = np.int32(0), np.int32(0), np.int32(0)
            for v in range(H):
                drawn_row, seen_row, mine_row = drawn[v], depth[v], mine[v]
                for u in range(W):
                    t, seen, is_mine = drawn_row[u], seen_row[u], mine_row[u]
                    is_drawn = t < NO_HIT
                    gap = abs(seen - t)
                    units = np.int32(min(gap, clamp) * UNITS_PER_M) if is_drawn else full
                    is_hidden = ~is_mine & (seen > 0) & (seen < t - match)
                    matched = is_drawn & (gap < match)
                    counts = is_mine | (is_drawn & ~is_hidden)
                    difference += units if counts else np.int32(0)
                    both += np.int32(is_mine & matched)
                    either += np.int32(is_mine | matched)
            out[m, DEPTH_DIFFERENCE] = difference
            out[m, BOTH] = both
            out[m, EITHER] = either
