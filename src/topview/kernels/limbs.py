"""Gauss-Newton for many candidate poses of one limb: two circular cylinders in a row.

Each candidate is refined on its own, so the result does not depend on the number of threads. A
limb's parts are round, so that two directions say all: four degrees of freedom.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import (
    BACK_FACING,
    FLOOR_WEIGHT,
    INNER_SHARE,
    LARGEST_GAP_M,
    LARGEST_TURN_RAD,
    NEAREST_M,
    STRAIGHT,
    nearest_own,
    solve_lower,
)
from topview.kernels.limits import excess
from topview.kernels.threads import over_threads


@njit(error_model="numpy")
def _tangents(axis, out):
    """Two unit vectors across `axis` and each other, as rows of `out`."""
    k = 0
    if abs(axis[1]) < abs(axis[k]):
        k = 1
    if abs(axis[2]) < abs(axis[k]):
        k = 2
    h = np.zeros(3)
    h[k] = 1.0
    out[0, 0] = axis[1] * h[2] - axis[2] * h[1]
    out[0, 1] = axis[2] * h[0] - axis[0] * h[2]
    out[0, 2] = axis[0] * h[1] - axis[1] * h[0]
    norm = np.sqrt(out[0, 0] ** 2 + out[0, 1] ** 2 + out[0, 2] ** 2)
    for i in range(3):
        out[0, i] /= norm
    out[1, 0] = axis[1] * out[0, 2] - axis[2] * out[0, 1]
    out[1, 1] = axis[2] * out[0, 0] - axis[0] * out[0, 2]
    out[1, 2] = axis[0] * out[0, 1] - axis[1] * out[0, 0]


@njit(error_model="numpy", inline="always")
def _wish(wishes, n, along_upper, along_lower, nx, ny, nz, gap, weight):
    """Note as n-th of `wishes` [W, 7] that a place on the limb, so far along both parts, moves by
    `gap` along (nx, ny, nz)."""
    wishes[n, 0], wishes[n, 1] = along_upper, along_lower
    wishes[n, 2], wishes[n, 3], wishes[n, 4] = nx, ny, nz
    wishes[n, 5], wishes[n, 6] = gap, weight


@njit(error_model="numpy")
def _pull(wishes, n, upper, lower, prior_weight, A, g):
    """Fill the lower triangle of A [4, 4] and g [4] with what the first n wishes ask for; the sums
    are kept out of memory."""
    u, v, w, x = upper[0], upper[1], lower[0], lower[1]
    g0 = g1 = g2 = g3 = 0.0
    a00 = a11 = a22 = a33 = prior_weight
    a10 = a20 = a21 = a30 = a31 = a32 = 0.0
    for i in range(n):
        along_upper, along_lower = wishes[i, 0], wishes[i, 1]
        nx, ny, nz = wishes[i, 2], wishes[i, 3], wishes[i, 4]
        gap, weight = wishes[i, 5], wishes[i, 6]
        j0 = along_upper * (u[0] * nx + u[1] * ny + u[2] * nz)
        j1 = along_upper * (v[0] * nx + v[1] * ny + v[2] * nz)
        j2 = along_lower * (w[0] * nx + w[1] * ny + w[2] * nz)
        j3 = along_lower * (x[0] * nx + x[1] * ny + x[2] * nz)
        w0, w1, w2, w3 = weight * j0, weight * j1, weight * j2, weight * j3
        g0, g1, g2, g3 = g0 + w0 * gap, g1 + w1 * gap, g2 + w2 * gap, g3 + w3 * gap
        a00, a10, a11 = a00 + w0 * j0, a10 + w1 * j0, a11 + w1 * j1
        a20, a21, a22 = a20 + w2 * j0, a21 + w2 * j1, a22 + w2 * j2
        a30, a31, a32, a33 = a30 + w3 * j0, a31 + w3 * j1, a32 + w3 * j2, a33 + w3 * j3
    g[0], g[1], g[2], g[3] = g0, g1, g2, g3
    A[0, 0], A[1, 0], A[1, 1] = a00, a10, a11
    A[2, 0], A[2, 1], A[2, 2] = a20, a21, a22
    A[3, 0], A[3, 1], A[3, 2], A[3, 3] = a30, a31, a32, a33


@njit(error_model="numpy", inline="always")
def _from_axis(dx, dy, dz, ax, ay, az, length):
    """How far along a part, [0, length], a place off its origin is nearest to the axis, the way
    from there to the place, and how long that is; metres."""
    t = min(max(dx * ax + dy * ay + dz * az, 0.0), length)
    ex, ey, ez = dx - t * ax, dy - t * ay, dz - t * az
    return t, ex, ey, ez, max(np.sqrt(ex * ex + ey * ey + ez * ez), 1e-6)


@njit(error_model="numpy")
def _choose_parts(px, py, pz, ranges, joint, elbow, axes, lengths, radii, reach, chosen):
    """Fill `chosen` [N] with the part, 0 or 1, whose surface that faces the camera is nearest to
    each point, -1 beyond `reach`; without a branch, so that the loop is vectorised.

    Args:
        px, py, pz, ranges: [N] metres, and how far from the camera that is.
        joint, elbow, axes: [3], [3] and [2, 3] the limb.
        lengths, radii, reach: as in `refine_limbs`.
    """
    jx, jy, jz, ax, ay, az = joint[0], joint[1], joint[2], axes[0, 0], axes[0, 1], axes[0, 2]
    kx, ky, kz, bx, by, bz = elbow[0], elbow[1], elbow[2], axes[1, 0], axes[1, 1], axes[1, 2]
    length_a, length_b = lengths[0], lengths[1]
    radius_a, radius_b = radii[0], radii[1]
    for i in range(px.shape[0]):
        x, y, z, away = px[i], py[i], pz[i], ranges[i]
        _, ex, ey, ez, r = _from_axis(x - jx, y - jy, z - jz, ax, ay, az, length_a)
        off = abs(r - radius_a)
        is_first = (off < reach) & ((ex * x + ey * y + ez * z) / (r * away) <= BACK_FACING)
        best = off if is_first else reach
        _, ex, ey, ez, r = _from_axis(x - kx, y - ky, z - kz, bx, by, bz, length_b)
        off = abs(r - radius_b)
        is_second = (off < best) & ((ex * x + ey * y + ez * z) / (r * away) <= BACK_FACING)
        chosen[i] = 1 if is_second else (0 if is_first else -1)


@over_threads("axes")
@njit(cache=True, error_model="numpy", nogil=True)
def refine_limbs(
    first_row, row_step,
    axes, joint, lengths, radii, points, depth, mine, nearest, corner, fx, fy, cx, cy, floor,
    reach, scale, margin, free_weight, prior_weight, samples, iterations,
):  # fmt: skip
    """Move [M, 2, 3] directions `axes`, in place, onto the points and out of free space.

    Args:
        joint: [3] the limb's proximal joint, metres, camera frame.
        lengths, radii: [2] of upper and lower part, metres.
        points: [N, 3] that the limb may explain.
        depth, mine, nearest, corner, fx, fy, cx, cy, floor, margin, free_weight, iterations: as in
            `body.refine_bodies`.
        reach, scale: metres; farther points do not pull, and the width of the robust weight.
        prior_weight: against leaving the candidate, per square radian.
        samples: places on each part's axis that are tested against free space.
    """
    H, W = depth.shape
    A = np.empty((4, 4))
    g = np.empty(4)
    upper = np.empty((2, 3))
    lower = np.empty((2, 3))
    elbow = np.empty(3)
    px, py, pz = points[:, 0].copy(), points[:, 1].copy(), points[:, 2].copy()
    ranges = np.sqrt(px * px + py * py + pz * pz)
    chosen = np.empty(points.shape[0], np.int64)
    wishes = np.empty((points.shape[0] + 2 * (samples + 1), 7))
    for m in range(first_row, axes.shape[0], row_step):
        for _ in range(iterations):
            _tangents(axes[m, 0], upper)
            _tangents(axes[m, 1], lower)
            n = 0
            for i in range(3):
                elbow[i] = joint[i] + lengths[0] * axes[m, 0, i]
            _choose_parts(px, py, pz, ranges, joint, elbow, axes[m], lengths, radii, reach, chosen)
            for i in range(points.shape[0]):
                k = chosen[i]
                if k < 0:
                    continue
                dx = px[i] - (joint[0] if k == 0 else elbow[0])
                dy = py[i] - (joint[1] if k == 0 else elbow[1])
                dz = pz[i] - (joint[2] if k == 0 else elbow[2])
                t, ex, ey, ez, r = _from_axis(
                    dx, dy, dz, axes[m, k, 0], axes[m, k, 1], axes[m, k, 2], lengths[k]
                )
                d = r - radii[k]
                w = 1.0 / (1.0 + (d / scale) ** 2)
                _wish(
                    wishes, n, t if k == 0 else lengths[0], t if k == 1 else 0.0,
                    ex / r, ey / r, ez / r, d, w * w,
                )  # fmt: skip
                n += 1
            for k in range(2):
                x = (joint[0] if k == 0 else elbow[0]) + lengths[k] * axes[m, k, 0]
                y = (joint[1] if k == 0 else elbow[1]) + lengths[k] * axes[m, k, 1]
                z = (joint[2] if k == 0 else elbow[2]) + lengths[k] * axes[m, k, 2]
                below = -(floor[0] * x + floor[1] * y + floor[2] * z + floor[3])
                if below > 0.0:
                    _wish(
                        wishes, n, lengths[0], lengths[1] if k == 1 else 0.0,
                        floor[0], floor[1], floor[2], below, FLOOR_WEIGHT * free_weight,
                    )  # fmt: skip
                    n += 1
                for s in range(samples):
                    t = (s + 0.5) / samples * lengths[k]
                    x = (joint[0] if k == 0 else elbow[0]) + t * axes[m, k, 0]
                    y = (joint[1] if k == 0 else elbow[1]) + t * axes[m, k, 1]
                    z = (joint[2] if k == 0 else elbow[2]) + t * axes[m, k, 2]
                    if z < NEAREST_M:
                        continue
                    u, v = int(np.round(fx * x / z + cx)), int(np.round(fy * y / z + cy))
                    if u < 0 or v < 0 or u >= W or v >= H:
                        continue
                    seen = depth[v, u]
                    front = z - radii[k]
                    along_upper = t if k == 0 else lengths[0]
                    along_lower = t if k == 1 else 0.0
                    if not mine[v, u]:
                        if seen > 0.0 and seen < front + margin:
                            continue
                        row, column = nearest_own(nearest, corner, v, u)
                        if row < 0:
                            continue
                        du, dv = (column - u) * z / fx, (row - v) * z / fy
                        distance = np.sqrt(du * du + dv * dv)
                        gap = min(distance - INNER_SHARE * radii[k], LARGEST_GAP_M)
                        if gap > 0.0:
                            _wish(
                                wishes, n, along_upper, along_lower,
                                du / distance, dv / distance, 0.0, gap, free_weight,
                            )  # fmt: skip
                            n += 1
                    elif seen > front + margin:
                        norm = np.sqrt(x * x + y * y + z * z)
                        _wish(
                            wishes, n, along_upper, along_lower, x / norm, y / norm, z / norm,
                            min(seen - front, LARGEST_GAP_M), free_weight,
                        )  # fmt: skip
                        n += 1
            _pull(wishes, n, upper, lower, prior_weight, A, g)
            step = solve_lower(A, g)
            for k in range(2):
                basis = upper if k == 0 else lower
                a = min(max(step[2 * k], -LARGEST_TURN_RAD), LARGEST_TURN_RAD)
                b = min(max(step[2 * k + 1], -LARGEST_TURN_RAD), LARGEST_TURN_RAD)
                norm = 0.0
                for i in range(3):
                    axes[m, k, i] += a * basis[0, i] + b * basis[1, i]
                    norm += axes[m, k, i] ** 2
                for i in range(3):
                    axes[m, k, i] /= np.sqrt(norm)


@over_threads("axes")
@njit(cache=True, error_model="numpy", nogil=True)
def judge_limbs(
    first_row, row_step,
    axes, x_hint, bend, R_parent, limits, predicted, joint, lengths, radii, floor, points,
    tolerance, Rs, verdicts,
):  # fmt: skip
    """Fill in the rotations of limb poses, and what speaks for and against them besides a score.

    Args:
        axes: [M, 2, 3] directions of upper and lower part, camera frame.
        x_hint: [3] hinge axis of a limb that is straight.
        bend: +1 for elbows, which bend to the front, -1 for knees.
        R_parent, limits: [3, 3] rotation of the torso part, [2, 3, 2] radians of both parts.
        predicted: [2, 3] directions that motion makes likely.
        joint, lengths, radii: [3], [2] and [2] metres.
        floor: [4] upward normal and height of the camera over it, zeros for none.
        points, tolerance: [N, 3] and metres, points that only this limb can explain.
        Rs: [M, 2, 3, 3] `R_camera_part`, filled: the hinge's axis x stands across both parts.
        verdicts: [M, 5], filled: points explained, turns of both parts away from the prediction,
            radians beyond the limits, metres that the end lies below the floor.
    """
    limit_upper = (radii[0] + tolerance) ** 2
    limit_lower = (radii[1] + tolerance) ** 2
    px, py, pz = points[:, 0].copy(), points[:, 1].copy(), points[:, 2].copy()
    for m in range(first_row, axes.shape[0], row_step):
        u, w = axes[m, 0], axes[m, 1]
        nx = bend * (u[1] * w[2] - u[2] * w[1])
        ny = bend * (u[2] * w[0] - u[0] * w[2])
        nz = bend * (u[0] * w[1] - u[1] * w[0])
        norm = np.sqrt(nx * nx + ny * ny + nz * nz)
        share = min(norm / STRAIGHT, 1.0)
        scale = share / max(norm, 1e-9)
        for k in range(2):
            a, R = axes[m, k], Rs[m, k]
            x = nx * scale + (1.0 - share) * x_hint[0]
            y = ny * scale + (1.0 - share) * x_hint[1]
            z = nz * scale + (1.0 - share) * x_hint[2]
            along = x * a[0] + y * a[1] + z * a[2]
            x, y, z = x - along * a[0], y - along * a[1], z - along * a[2]
            inv = 1.0 / max(np.sqrt(x * x + y * y + z * z), 1e-9)
            R[0, 0], R[1, 0], R[2, 0] = x * inv, y * inv, z * inv
            for i in range(3):
                R[i, 1] = a[i]
            R[0, 2] = R[1, 0] * a[2] - R[2, 0] * a[1]
            R[1, 2] = R[2, 0] * a[0] - R[0, 0] * a[2]
            R[2, 2] = R[0, 0] * a[1] - R[1, 0] * a[0]
            cosine = a[0] * predicted[k, 0] + a[1] * predicted[k, 1] + a[2] * predicted[k, 2]
            verdicts[m, 1 + k] = np.arccos(min(max(cosine, -1.0), 1.0))

        n = 0
        for i in range(points.shape[0]):
            dx, dy, dz = px[i] - joint[0], py[i] - joint[1], pz[i] - joint[2]
            t = min(max(dx * u[0] + dy * u[1] + dz * u[2], 0.0), lengths[0])
            near = (dx - t * u[0]) ** 2 + (dy - t * u[1]) ** 2 + (dz - t * u[2]) ** 2 <= limit_upper
            dx -= lengths[0] * u[0]
            dy -= lengths[0] * u[1]
            dz -= lengths[0] * u[2]
            t = min(max(dx * w[0] + dy * w[1] + dz * w[2], 0.0), lengths[1])
            near |= (dx - t * w[0]) ** 2 + (dy - t * w[1]) ** 2 + (
                dz - t * w[2]
            ) ** 2 <= limit_lower
            n += np.int64(near)
        verdicts[m, 0] = n
        verdicts[m, 3] = excess(R_parent, Rs[m, 0], limits[0], True) + excess(
            Rs[m, 0], Rs[m, 1], limits[1], True
        )
        height = floor[3]
        for i in range(3):
            height += floor[i] * (joint[i] + lengths[0] * u[i] + lengths[1] * w[i])
        verdicts[m, 4] = max(-height, 0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def share_out_points(
    points, labels, distances, joint, reach, upper, taken, exclusive, out_open, out_exclusive
):
    """Which of somebody's points a limb may explain.

    Args:
        points, labels, distances: [N, 3], and [N] twice, of `topview.kernels.body.assign_points`.
        joint, reach: [3] the limb's proximal joint, and how far from it the limb comes, metres.
        upper: the limb's upper part; the lower one comes next.
        taken, exclusive: metres; nearer points to another part's surface are that part's, and
            points that are nearer might be.
        out_open, out_exclusive: [N, 3], filled from the start with the points that are not taken,
            and with those that no other part explains.

    Returns:
        How many are open, how many exclusive, and how many lie on the limb's own surface.
    """
    n_open, n_exclusive, n_own = 0, 0, 0
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - joint[0], points[i, 1] - joint[1], points[i, 2] - joint[2]
        if not x * x + y * y + z * z < reach * reach:
            continue
        off = abs(distances[i])
        is_own = labels[i] == upper or labels[i] == upper + 1
        is_others = not is_own and labels[i] >= 0
        n_own += is_own and off < taken
        if not (is_others and off < taken):
            for k in range(3):
                out_open[n_open, k] = points[i, k]
            n_open += 1
        if not (is_others and off < exclusive):
            for k in range(3):
                out_exclusive[n_exclusive, k] = points[i, k]
            n_exclusive += 1
    return n_open, n_exclusive, n_own


@njit(cache=True, error_model="numpy", nogil=True)
def pick_scored(
    points, pixels, labels, distances, joint, reach, upper, taken, out_fine, out_coarse
):
    """The pixels that a limb's hypotheses are scored on: of those points within reach that no other
    part has taken.

    Args:
        points, labels, distances, joint, reach, upper, taken: as in `share_out_points`.
        pixels: [N] the points' flat indices into `out_fine`.
        out_fine: [H, W] zeros, set to 1 at these pixels.
        out_coarse: the same for every second pixel of every second row.
    """
    width = out_fine.shape[1]
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - joint[0], points[i, 1] - joint[1], points[i, 2] - joint[2]
        if not x * x + y * y + z * z < reach * reach:
            continue
        is_others = labels[i] >= 0 and labels[i] != upper and labels[i] != upper + 1
        if is_others and abs(distances[i]) < taken:
            continue
        row, column = pixels[i] // width, pixels[i] % width
        out_fine[row, column] = 1
        if row % 2 == 0 and column % 2 == 0:
            out_coarse[row // 2, column // 2] = 1
