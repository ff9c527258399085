"""The counts behind the uTVR score, for many hypotheses of one part at once.

One hypothesis is one closed elliptic cylinder. Points and rays come as structure of arrays; the
inner loops are branch-free and allocate nothing. Each hypothesis is counted on its own, so the
result does not depend on the number of threads. Definition: `topview.score.definition`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.cylinders import NO_HIT, hit_depth, image_box, is_inside, may_touch, outline
from topview.kernels.threads import over_threads

GRID = 64  # cells of the top view along each side; one bit each in a row of 64
N_COUNTS = 7
N_3D, N_PR, N_CYL, P_IN, P_OCCL, P_OUT, N_COLL = range(N_COUNTS)


@over_threads("chunks")
@njit(cache=True, error_model="numpy", nogil=True)
def count_hypotheses(
    first_row,
    row_step,
    px,
    py,
    pz,
    depth,
    fx,
    fy,
    cx,
    cy,
    Rs,
    origins,
    length,
    rx,
    rz,
    cell,
    tolerance,
    placed,
    chunks,
    out,
):
    """Fill `out` [M, 7] with N_3D, N_Pr, N_Dcyl, P_in, P_occl, P_out and N_coll.

    Args:
        px, py, pz: [N] float32, the user's remaining points, metres, camera frame.
        depth: [H, W] float32 metres, D_3D and D_all together, 0 without a reading.
        fx, fy, cx, cy: its intrinsics in pixels.
        Rs, origins: [M, 3, 3] and [M, 3] float32, `R_camera_part` and origin of each hypothesis.
        length, rx, rz: float32 metres, the part's size.
        cell: float32 metres, side of a cell of the top view.
        tolerance: float32 metres, the T of Sec. 5.2.1.
        placed: [K, 15] float32, parts already placed: R_camera_part row by row, origin, length,
            1 / rx^2, 1 / rz^2.
        chunks: how many pieces the hypotheses are dealt to, one scratch memory each; at least the
            number of threads. The counts do not depend on it.
        out: [M, 7] int32.
    """
    M = Rs.shape[0]
    N = px.shape[0]
    H, W = depth.shape
    K = placed.shape[0]
    cells = np.empty((chunks, max(N, 1)), np.int32)
    pixels = np.empty((chunks, 4, H * W), np.float32)
    spans = np.empty((chunks, 2, H), np.float32)
    corners = np.empty((chunks, 2, 8), np.float32)
    grids = np.empty((chunks, GRID), np.uint64)
    inv_rx2 = np.float32(1.0) / (rx * rx)
    inv_rz2 = np.float32(1.0) / (rz * rz)
    inv_cell = np.float32(1.0) / cell
    half = np.float32(GRID // 2)
    for chunk in range(first_row, chunks, row_step):
        cell_of = cells[chunk]
        ray_x, ray_y, seen, hit = (
            pixels[chunk, 0],
            pixels[chunk, 1],
            pixels[chunk, 2],
            pixels[chunk, 3],
        )
        grid = grids[chunk]
        for m in range(chunk, M, chunks):
            r00, r01, r02 = Rs[m, 0, 0], Rs[m, 0, 1], Rs[m, 0, 2]
            r10, r11, r12 = Rs[m, 1, 0], Rs[m, 1, 1], Rs[m, 1, 2]
            r20, r21, r22 = Rs[m, 2, 0], Rs[m, 2, 1], Rs[m, 2, 2]
            ox, oy, oz = origins[m, 0], origins[m, 1], origins[m, 2]

            # the points inside, and the cell of the top view that each falls on
            n_inside = 0
            for i in range(N):
                dx, dy, dz = px[i] - ox, py[i] - oy, pz[i] - oz
                x = r00 * dx + r10 * dy + r20 * dz
                y = r01 * dx + r11 * dy + r21 * dz
                z = r02 * dx + r12 * dy + r22 * dz
                inside = is_inside(x, y, z, length, inv_rx2, inv_rz2)
                col = np.int32(min(max(x * inv_cell + half, np.float32(0)), np.float32(GRID - 1)))
                row = np.int32(min(max(z * inv_cell + half, np.float32(0)), np.float32(GRID - 1)))
                cell_of[i] = row * GRID + col if inside else -1
                n_inside += np.int32(inside)
            n_cells = 0
            for i in range(GRID):
                grid[i] = 0
            for i in range(N):
                if cell_of[i] >= 0:
                    row, col = cell_of[i] >> 6, cell_of[i] & 63
                    bit = np.uint64(1) << np.uint64(col)
                    n_cells += np.int32((grid[row] & bit) == 0)
                    grid[row] |= bit

            n_pixels = _pixels_near(
                Rs[m],
                origins[m],
                length,
                rx,
                rz,
                depth,
                fx,
                fy,
                cx,
                cy,
                corners[chunk],
                spans[chunk],
                ray_x,
                ray_y,
                seen,
            )
            # camera centre in the part's frame
            qx = -(r00 * ox + r10 * oy + r20 * oz)
            qy = -(r01 * ox + r11 * oy + r21 * oz)
            qz = -(r02 * ox + r12 * oy + r22 * oz)
            n_cyl = 0
            n_in = 0
            n_occl = 0
            for i in range(n_pixels):
                t = hit_depth(
                    qx,
                    qy,
                    qz,
                    r10 * ray_y[i] + r20 + r00 * ray_x[i],
                    r11 * ray_y[i] + r21 + r01 * ray_x[i],
                    r12 * ray_y[i] + r22 + r02 * ray_x[i],
                    length,
                    inv_rx2,
                    inv_rz2,
                )
                covered = t < NO_HIT
                valid = covered & (seen[i] > 0)
                n_cyl += np.int32(covered)
                n_in += np.int32(valid & (abs(seen[i] - t) <= tolerance))
                n_occl += np.int32(valid & (seen[i] < t - tolerance))
                hit[i] = t
            n_coll = 0
            for k in range(K):
                if may_touch(Rs[m], origins[m], length, max(rx, rz), placed[k]):
                    n_coll += _collisions(hit, ray_x, ray_y, n_pixels, placed[k])
            out[m, N_3D] = n_inside
            out[m, N_PR] = n_cells
            out[m, N_CYL] = n_cyl
            out[m, P_IN] = n_in
            out[m, P_OCCL] = n_occl
            out[m, P_OUT] = n_cyl - n_in - n_occl
            out[m, N_COLL] = n_coll


@njit(error_model="numpy")
def _pixels_near(R, o, length, rx, rz, depth, fx, fy, cx, cy, corners, span, ray_x, ray_y, seen):
    """Fill in the rays and readings of all pixels that a cylinder can cover, row by row; gives how
    many there are. `corners` and `span` are scratch."""
    H, W = depth.shape
    u0, u1, v0, v1 = image_box(R, o, length, rx, rz, fx, fy, cx, cy, W, H)
    outline(R, o, length, rx, rz, fx, fy, cx, cy, u0, u1, v0, v1, corners, span)
    n = 0
    for v in range(v0, v1):
        row_y = (np.float32(v) - cy) / fy
        first = max(u0, np.int32(np.floor(span[0, v])))
        last = min(u1, np.int32(np.ceil(span[1, v])) + 1)
        for u in range(first, last):
            ray_x[n] = (np.float32(u) - cx) / fx
            ray_y[n] = row_y
            seen[n] = depth[v, u]
            n += 1
    return n


@njit(error_model="numpy", forceinline=True)
def _collisions(hit, ray_x, ray_y, n_pixels, part):
    """How many hits lie inside one placed part; they are taken out of `hit`, so that a pixel inside
    several parts counts once."""
    n = 0
    for i in range(n_pixels):
        t = hit[i]
        covered = t < NO_HIT
        depth = t if covered else np.float32(0.0)
        dx = ray_x[i] * depth - part[9]
        dy = ray_y[i] * depth - part[10]
        dz = depth - part[11]
        x = part[0] * dx + part[3] * dy + part[6] * dz
        y = part[1] * dx + part[4] * dy + part[7] * dz
        z = part[2] * dx + part[5] * dy + part[8] * dz
        collides = covered & is_inside(x, y, z, part[12], part[13], part[14])
        hit[i] = NO_HIT if collides else t
        n += np.int32(collides)
    return n
