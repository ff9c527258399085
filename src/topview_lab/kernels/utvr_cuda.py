"""The counts behind the uTVR score on a GPU: loops of its own, the CPU's scalar functions.

A block of threads counts one hypothesis, whose pixels its threads share out. Counts are sums of
whole numbers, so that they do not depend on who comes first. `scripts/measure_cuda.py` compares it
with `topview.kernels.utvr.count_hypotheses`; nothing that ships calls it.
"""

from __future__ import annotations

from typing import Any

import numba.cuda
import numpy as np
from numba import int32

from topview.kernels.cylinders import NO_HIT, hit_depth, image_box, is_inside, may_touch
from topview.kernels.utvr import (
    GRID,
    N_3D,
    N_COLL,
    N_COUNTS,
    N_CYL,
    N_PR,
    P_IN,
    P_OCCL,
    P_OUT,
    along_ray,
    is_in_placed,
    top_view_cell,
)

WORD = 32  # cells of the top view that are kept in one number
WORDS = GRID * GRID // WORD
MOST_PLACED = 16  # parts already placed

cuda: Any = numba.cuda  # whose own types say nothing of what a kernel may do


@cuda.jit
def count_hypotheses(
    depth,
    own,
    fx,
    fy,
    cx,
    cy,
    Rs,
    origins,
    layers,
    length,
    rx,
    rz,
    cell,
    tolerance,
    placed,
    out,
):  # pragma: no cover - runs on a GPU, or in numba's simulator of one
    """Fill `out` [M, 7] as `topview.kernels.utvr.count_hypotheses` does, with the same arguments.

    Launched with M blocks of any number of threads. At most `MOST_PLACED` parts are placed.
    """
    filled = cuda.shared.array(WORDS, int32)
    counts = cuda.shared.array(N_COUNTS, int32)
    touches = cuda.shared.array(MOST_PLACED, int32)
    m, thread, threads = cuda.blockIdx.x, cuda.threadIdx.x, cuda.blockDim.x
    R, origin, K = Rs[m], origins[m], placed.shape[0]
    for word in range(thread, WORDS, threads):
        filled[word] = 0
    for k in range(thread, K, threads):
        touches[k] = may_touch(R, origin, length, max(rx, rz), placed[k])
    for k in range(thread, N_COUNTS, threads):
        counts[k] = 0
    cuda.syncthreads()

    inv_rx2 = np.float32(1.0) / (rx * rx)
    inv_rz2 = np.float32(1.0) / (rz * rz)
    inv_cell, inv_fx = np.float32(1.0) / cell, np.float32(1.0) / fx
    ox, oy, oz = origin[0], origin[1], origin[2]
    qx = -(R[0, 0] * ox + R[1, 0] * oy + R[2, 0] * oz)
    qy = -(R[0, 1] * ox + R[1, 1] * oy + R[2, 1] * oz)
    qz = -(R[0, 2] * ox + R[1, 2] * oy + R[2, 2] * oz)
    height, width = depth.shape
    u0, u1, v0, v1 = image_box(R, origin, length, rx, rz, fx, fy, cx, cy, width, height)
    columns = max(u1 - u0, 0)
    n_inside = n_covered = n_in = n_occluded = n_collisions = 0
    for pixel in range(thread, columns * max(v1 - v0, 0), threads):
        v, u = v0 + pixel // columns, u0 + pixel % columns
        ray_x, ray_y = (np.float32(u) - cx) * inv_fx, (np.float32(v) - cy) / fy
        seen = depth[v, u]
        dx = along_ray(R[0, 0], R[1, 0], R[2, 0], ray_x, ray_y)
        dy = along_ray(R[0, 1], R[1, 1], R[2, 1], ray_x, ray_y)
        dz = along_ray(R[0, 2], R[1, 2], R[2, 2], ray_x, ray_y)
        x, y, z = qx + seen * dx, qy + seen * dy, qz + seen * dz
        if (own[v, u] & layers[m]) != 0 and is_inside(x, y, z, length, inv_rx2, inv_rz2):
            n_inside += 1
            at = top_view_cell(x, z, inv_cell)
            cuda.atomic.or_(filled, at // WORD, int32(1 << (at % WORD)))
        hit = hit_depth(qx, qy, qz, dx, dy, dz, length, inv_rx2, inv_rz2)
        if hit < NO_HIT:
            n_covered += 1
            is_read = seen > 0
            n_in += is_read and abs(seen - hit) <= tolerance
            n_occluded += is_read and seen < hit - tolerance
            collides = False
            for k in range(K):
                collides |= touches[k] != 0 and is_in_placed(hit, ray_x, ray_y, placed[k])
            n_collisions += collides
    cuda.atomic.add(counts, N_3D, n_inside)
    cuda.atomic.add(counts, N_CYL, n_covered)
    cuda.atomic.add(counts, P_IN, n_in)
    cuda.atomic.add(counts, P_OCCL, n_occluded)
    cuda.atomic.add(counts, N_COLL, n_collisions)
    cuda.syncthreads()

    n_cells = 0
    for word in range(thread, WORDS, threads):
        bits = filled[word]
        for bit in range(WORD):
            n_cells += (bits >> bit) & 1
    cuda.atomic.add(counts, N_PR, n_cells)
    cuda.syncthreads()
    if thread == 0:
        counts[P_OUT] = counts[N_CYL] - counts[P_IN] - counts[P_OCCL]
        for k in range(N_COUNTS):
            out[m, k] = counts[k]
