"""The counts behind the uTVR score, for many hypotheses of one part at once.

One hypothesis is one closed elliptic cylinder. Pixels come as structure of arrays; the inner loops
are branch-free and allocate nothing. Each hypothesis is counted on its own, so the result does not
depend on the number of threads. Definition: `topview.score.definition`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.cylinders import NO_HIT, hit_depth, image_box, is_inside, may_touch, outline
from topview.kernels.threads import over_threads

GRID = 64  # cells of the top view along each side; one bit each in a row of 64
N_COUNTS = 7
N_3D, N_PR, N_CYL, P_IN, P_OCCL, P_OUT, N_COLL = range(N_COUNTS)
N_FACTORS = 5


@over_threads("chunks")
@njit(cache=True, error_model="numpy", nogil=True)
def count_hypotheses(
    first_row,
    row_step,
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
    chunks,
    out,
):
    """Fill `out` [M, 7] with N_3D, N_Pr, N_Dcyl, P_in, P_occl, P_out and N_coll.

    A point is a pixel with a reading. Those inside a cylinder are among the pixels that it can
    cover, so that no other is looked at.

    Args:
        depth: [H, W] float32 metres, D_3D and D_all together, 0 without a reading.
        own: [H, W] uint8, whose pixels are the user's remaining points, one bit for each layer.
        fx, fy, cx, cy: intrinsics of both images in pixels.
        Rs, origins: [M, 3, 3] and [M, 3] float32, `R_camera_part` and origin of each hypothesis.
        layers: [M] uint8, the bit of `own` that counts for each.
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
    H, W = depth.shape
    K = placed.shape[0]
    cells = np.empty((chunks, H * W), np.int32)
    mine = np.empty((chunks, H * W), np.uint8)
    pixels = np.empty((chunks, 4, H * W), np.float32)
    spans = np.empty((chunks, 2, H), np.float32)
    corners = np.empty((chunks, 2, 8), np.float32)
    grids = np.empty((chunks, GRID), np.uint64)
    inv_rx2 = np.float32(1.0) / (rx * rx)
    inv_rz2 = np.float32(1.0) / (rz * rz)
    inv_cell = np.float32(1.0) / cell
    for chunk in range(first_row, chunks, row_step):
        cell_of, owned = cells[chunk], mine[chunk]
        ray_x, ray_y, seen, hit = (
            pixels[chunk, 0],
            pixels[chunk, 1],
            pixels[chunk, 2],
            pixels[chunk, 3],
        )
        for m in range(chunk, M, chunks):
            r00, r01, r02 = Rs[m, 0, 0], Rs[m, 0, 1], Rs[m, 0, 2]
            r10, r11, r12 = Rs[m, 1, 0], Rs[m, 1, 1], Rs[m, 1, 2]
            r20, r21, r22 = Rs[m, 2, 0], Rs[m, 2, 1], Rs[m, 2, 2]
            ox, oy, oz = origins[m, 0], origins[m, 1], origins[m, 2]
            n_pixels = _pixels_near(
                Rs[m],
                origins[m],
                length,
                rx,
                rz,
                depth,
                own,
                fx,
                fy,
                cx,
                cy,
                corners[chunk],
                spans[chunk],
                ray_x,
                ray_y,
                seen,
                owned,
            )
            # camera centre in the part's frame
            qx = -(r00 * ox + r10 * oy + r20 * oz)
            qy = -(r01 * ox + r11 * oy + r21 * oz)
            qz = -(r02 * ox + r12 * oy + r22 * oz)
            layer = layers[m]
            # kept to 32 bits, or half as many pixels are counted at once
            n_inside = n_cyl = n_in = n_occl = np.int32(0)
            for i in range(n_pixels):
                # the ray's direction, and its point, in the part's frame
                dx = along_ray(r00, r10, r20, ray_x[i], ray_y[i])
                dy = along_ray(r01, r11, r21, ray_x[i], ray_y[i])
                dz = along_ray(r02, r12, r22, ray_x[i], ray_y[i])
                x, y, z = qx + seen[i] * dx, qy + seen[i] * dy, qz + seen[i] * dz
                inside = is_inside(x, y, z, length, inv_rx2, inv_rz2) & ((owned[i] & layer) != 0)
                cell_of[i] = top_view_cell(x, z, inv_cell) if inside else -1
                n_inside = np.int32(n_inside + inside)
                t = hit_depth(qx, qy, qz, dx, dy, dz, length, inv_rx2, inv_rz2)
                covered = t < NO_HIT
                valid = covered & (seen[i] > 0)
                n_cyl = np.int32(n_cyl + covered)
                n_in = np.int32(n_in + (valid & (abs(seen[i] - t) <= tolerance)))
                n_occl = np.int32(n_occl + (valid & (seen[i] < t - tolerance)))
                hit[i] = t
            n_coll = 0
            for k in range(K):
                if may_touch(Rs[m], origins[m], length, max(rx, rz), placed[k]):
                    n_coll += _collisions(hit, ray_x, ray_y, n_pixels, placed[k])
            out[m, N_3D] = n_inside
            out[m, N_PR] = _cells_filled(cell_of, n_pixels, grids[chunk])
            out[m, N_CYL] = n_cyl
            out[m, P_IN] = n_in
            out[m, P_OCCL] = n_occl
            out[m, P_OUT] = n_cyl - n_in - n_occl
            out[m, N_COLL] = n_coll


@njit(error_model="numpy", forceinline=True)
def along_ray(r0, r1, r2, ray_x, ray_y):
    """How far the ray of a pixel goes, a metre of depth, along an axis of a part: a column of
    `R_camera_part`."""
    return r1 * ray_y + r2 + r0 * ray_x


@njit(error_model="numpy", forceinline=True)
def top_view_cell(x, z, inv_cell):
    """The cell of the top view that a point falls on, row by row."""
    half, last = np.float32(GRID // 2), np.float32(GRID - 1)
    column = np.int32(min(max(x * inv_cell + half, np.float32(0)), last))
    row = np.int32(min(max(z * inv_cell + half, np.float32(0)), last))
    return row * GRID + column


@njit(error_model="numpy")
def _cells_filled(cell_of, n, grid):
    """How many cells of the top view the points fall on; -1 for what is no point inside. `grid` is
    scratch."""
    for i in range(GRID):
        grid[i] = 0
    n_inside = 0
    for i in range(n):
        cell = cell_of[i]
        cell_of[n_inside] = cell
        n_inside += np.int64(cell >= 0)
    n_cells = 0
    for i in range(n_inside):
        row, col = cell_of[i] >> 6, cell_of[i] & 63
        bit = np.uint64(1) << np.uint64(col)
        n_cells += np.int32((grid[row] & bit) == 0)
        grid[row] |= bit
    return n_cells


@njit(error_model="numpy")
def _pixels_near(
    R, o, length, rx, rz, depth, own, fx, fy, cx, cy, corners, span, ray_x, ray_y, seen, owned
):
    """Fill in the rays, readings and owners of all pixels that a cylinder can cover, row by row;
    gives how many there are. `corners` and `span` are scratch."""
    H, W = depth.shape
    u0, u1, v0, v1 = image_box(R, o, length, rx, rz, fx, fy, cx, cy, W, H)
    outline(R, o, length, rx, rz, fx, fy, cx, cy, u0, u1, v0, v1, corners, span)
    inv_fx = np.float32(1.0) / fx
    n = 0
    for v in range(v0, v1):
        row_y = (np.float32(v) - cy) / fy
        first = max(u0, np.int32(np.floor(span[0, v])))
        last = min(u1, np.int32(np.ceil(span[1, v])) + 1)
        count = max(last - first, 0)
        for k in range(count):
            ray_x[n + k] = (np.float32(first + k) - cx) * inv_fx
            ray_y[n + k] = row_y
            seen[n + k] = depth[v, first + k]
            owned[n + k] = own[v, first + k]
        n += count
    return n


@njit(cache=True, error_model="numpy", nogil=True)
def fill_factors(counts, out):
    """Fill `out` [5, M] with f_reproj, f_align, f_occl, f_ovl and f_coll of [M, 7] counts; infinite
    without evidence."""
    for m in range(counts.shape[0]):
        n_points, n_in = counts[m, N_3D], counts[m, P_IN]
        pixels = max(counts[m, N_CYL], 1)
        out[0, m] = counts[m, N_PR] / n_points if n_points > 0 else np.inf  # Eq. 3.1
        out[1, m] = counts[m, N_CYL] / n_points if n_points > 0 else np.inf  # Eq. 5.2
        out[2, m] = 2.0 - counts[m, P_OCCL] / pixels  # Eq. 5.9
        out[3, m] = 1.0 + counts[m, P_OUT] / n_in if n_in > 0 else np.inf  # Eq. 5.9
        out[4, m] = 1.0 + counts[m, N_COLL] / pixels  # Eq. 5.9


@njit(cache=True, error_model="numpy", nogil=True)
def take_inside(depth, fx, fy, cx, cy, Rs, origins, length, rx, rz, own):
    """Take the points inside K cylinders out of as many layers of `own`, each out of its own.

    Args:
        depth, fx, fy, cx, cy: as of `count_hypotheses`.
        Rs, origins: [K, 3, 3] and [K, 3] float32, `R_camera_part` and origin of each cylinder.
        length, rx, rz: float32 metres.
        own: [H, W] uint8.
    """
    H, W = depth.shape
    inv_rx2, inv_rz2 = np.float32(1.0) / (rx * rx), np.float32(1.0) / (rz * rz)
    for k in range(Rs.shape[0]):
        R, o = Rs[k], origins[k]
        layer = np.uint8(1) << np.uint8(k)
        u0, u1, v0, v1 = image_box(R, o, length, rx, rz, fx, fy, cx, cy, W, H)
        for v in range(v0, v1):
            ray_y = (np.float32(v) - cy) / fy
            for u in range(u0, u1):
                z = depth[v, u]
                dx = (np.float32(u) - cx) / fx * z - o[0]
                dy = ray_y * z - o[1]
                dz = z - o[2]
                inside = is_inside(
                    R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz,
                    R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz,
                    R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz,
                    length,
                    inv_rx2,
                    inv_rz2,
                )
                own[v, u] &= np.uint8(255) - layer if inside else np.uint8(255)


@njit(error_model="numpy", forceinline=True)
def _collisions(hit, ray_x, ray_y, n_pixels, part):
    """How many hits lie inside one placed part; they are taken out of `hit`, so that a pixel inside
    several parts counts once."""
    n = 0
    for i in range(n_pixels):
        collides = is_in_placed(hit[i], ray_x[i], ray_y[i], part)
        hit[i] = NO_HIT if collides else hit[i]
        n += np.int32(collides)
    return n


@njit(error_model="numpy", forceinline=True)
def is_in_placed(hit, ray_x, ray_y, part):
    """Whether a hit, as a depth along a pixel's ray, lies inside a placed part; none does not."""
    covered = hit < NO_HIT
    depth = hit if covered else np.float32(0.0)
    dx = ray_x * depth - part[9]
    dy = ray_y * depth - part[10]
    dz = depth - part[11]
    x = part[0] * dx + part[3] * dy + part[6] * dz
    y = part[1] * dx + part[4] * dy + part[7] * dz
    z = part[2] * dx + part[5] * dy + part[8] * dz
    return covered & is_inside(x, y, z, part[12], part[13], part[14])
