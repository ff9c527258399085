"""Which poses of one limb to try, and what the whole body costs with each, all else as it is."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import (
    FREE_M,
    LANES,
    facing_surface,
    in_free_space,
    multiply,
    parts_near,
    reach_across,
    side_by_side,
    unlike_seen,
)
from topview.kernels.threads import over_threads


@njit(cache=True, error_model="numpy", nogil=True)
def left_open_without(
    points, seen_normals, Rs, origins, lengths, shapes, owners, uppers, reach, scale, left_open
):  # fmt: skip
    """Fill `left_open` [L, N] with how much of each point, 0 to 1, the body without one of L limbs
    leaves unexplained; 0 where the limb does not reach.

    Args:
        points, seen_normals, Rs, origins, lengths, shapes, reach: as in
            `topview.kernels.body.assign_points`.
        owners: [S] the part that each piece of the surface moves with.
        uppers: [L] each limb's upper part; the lower one is the next.
        scale: width of the robust weight.
    """
    parts = np.empty((14, LANES), np.float32)
    side_by_side(Rs, origins, lengths, shapes, parts)
    unlike = np.empty(lengths.shape[0])
    for i in range(points.shape[0]):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        near = parts_near(px, py, pz, reach, parts)
        for k in range(lengths.shape[0]):
            unlike[k] = reach
            if (near >> k) & 1:
                d, nx, ny, nz = facing_surface(px, py, pz, k, Rs, origins, lengths, shapes)
                unlike[k] = min(unlike_seen(d, nx, ny, nz, seen_normals[i]), reach)
        for row in range(uppers.shape[0]):
            upper = uppers[row]
            dx, dy, dz = px - origins[upper, 0], py - origins[upper, 1], pz - origins[upper, 2]
            farthest = lengths[upper] + lengths[upper + 1] + 2.0 * reach
            left_open[row, i] = 0.0
            if dx * dx + dy * dy + dz * dz < farthest * farthest:
                best = reach
                for k in range(lengths.shape[0]):
                    if owners[k] != upper and owners[k] != upper + 1:
                        best = min(best, unlike[k])
                is_open = best >= reach
                left_open[row, i] = 1.0 if is_open else 1.0 - 1.0 / (1.0 + (best / scale) ** 2)


@njit(cache=True, error_model="numpy", nogil=True)
def ending_near(ends, lengths, upper, places, each, is_near):
    """Fill `is_near` [M] with whether a pose of a limb is one of `each` of them, at most M, that
    end nearest to some place.

    Args:
        ends: [M, 6] where both parts of each pose end, each as long as 1, in the parent's frame.
        lengths, upper: of all parts, and the limb's upper part.
        places: [P, 3] in the parent's frame, from where the limb begins.
    """
    M = ends.shape[0]
    by_elbow, by_hand = lengths[upper] - lengths[upper + 1], lengths[upper + 1]
    nearest, squares = np.empty(each, np.int64), np.empty(each)
    for m in range(M):
        is_near[m] = False
    for p in range(places.shape[0]):
        x, y, z = places[p, 0], places[p, 1], places[p, 2]
        for n in range(each):
            nearest[n], squares[n] = -1, np.inf
        for m in range(M):
            dx = by_elbow * ends[m, 0] + by_hand * ends[m, 3] - x
            dy = by_elbow * ends[m, 1] + by_hand * ends[m, 4] - y
            dz = by_elbow * ends[m, 2] + by_hand * ends[m, 5] - z
            square = dx * dx + dy * dy + dz * dz
            n = each - 1
            if square < squares[n]:
                while n > 0 and square < squares[n - 1]:
                    squares[n], nearest[n] = squares[n - 1], nearest[n - 1]
                    n -= 1
                squares[n], nearest[n] = square, m
        for n in range(each):
            is_near[nearest[n]] = True


@njit(error_model="numpy")
def _near_part(px, py, pz, best, R, origin, length, widest, is_near):
    """Fill `is_near` [N] with whether a part may come as near to a point as `best` [N]; no branch,
    so that the loop is vectorised."""
    ox, oy, oz = origin[0], origin[1], origin[2]
    ax, ay, az = R[0, 1], R[1, 1], R[2, 1]
    for i in range(px.shape[0]):
        dx, dy, dz = px[i] - ox, py[i] - oy, pz[i] - oz
        along = ax * dx + ay * dy + az * dz
        across2 = dx * dx + dy * dy + dz * dz - along * along
        far = widest + best[i]
        is_near[i] = (along >= -best[i]) & (along <= length + best[i]) & (across2 <= far * far)


@over_threads("Rs_relative")
@njit(cache=True, error_model="numpy", nogil=True)
def scan_limb(
    first_row, row_step,
    Rs_relative, R_parent, origin, upper, lengths, shapes, joints_parent, points, seen_normals,
    left_open, depth, mine, nearest, corner, fx, fy, cx, cy, floor, reach, scale, margin, samples,
    explained, free,
):  # fmt: skip
    """Fill [M] what each pose of a limb explains of the points that are left open, and how many of
    its samples are in free space.

    Args:
        Rs_relative: [M, 2, 3, 3] rotations of both parts, each in its parent's frame.
        R_parent, origin: [3, 3] and [3], of the limb's parent and of where the limb begins.
        upper: the limb's upper part; the lower one is the next.
        points, seen_normals, left_open: [N, 3] and [N, 3] as in
            `topview.kernels.body.assign_points`, and [N] how much of each is left unexplained.
        lengths, shapes, joints_parent, depth, mine, nearest, corner, fx, fy, cx, cy, floor, reach,
            scale, margin, samples: as in `topview.kernels.body.refine_bodies`.
    """
    N = points.shape[0]
    # A surface that is farther off leaves no less of a point open.
    within = np.empty(N)
    for i in range(N):
        within[i] = min(scale * np.sqrt(left_open[i] / max(1.0 - left_open[i], 1e-6)), reach)
    px, py, pz = points[:, 0].copy(), points[:, 1].copy(), points[:, 2].copy()
    best, is_near = np.empty(N), np.empty(N, np.bool_)
    Rs, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    own_lengths, own_shapes = lengths[upper : upper + 2], shapes[upper : upper + 2]
    widest = reach_across(own_shapes, 0), reach_across(own_shapes, 1)
    x_elbow, y_elbow, z_elbow = joints_parent[upper + 1]
    for i in range(3):
        origins[0, i] = origin[i]
    for m in range(first_row, Rs_relative.shape[0], row_step):
        multiply(R_parent, Rs_relative[m, 0], False, Rs[0])
        multiply(Rs[0], Rs_relative[m, 1], False, Rs[1])
        for i in range(3):
            origins[1, i] = (
                origin[i] + Rs[0, i, 0] * x_elbow + Rs[0, i, 1] * y_elbow + Rs[0, i, 2] * z_elbow
            )
        for i in range(N):
            best[i] = within[i]
        for k in range(2):
            _near_part(px, py, pz, best, Rs[k], origins[k], own_lengths[k], widest[k], is_near)
            for i in range(N):
                if is_near[i]:
                    d, nx, ny, nz = facing_surface(
                        points[i, 0], points[i, 1], points[i, 2], k, Rs, origins, own_lengths,
                        own_shapes,
                    )  # fmt: skip
                    best[i] = min(best[i], unlike_seen(d, nx, ny, nz, seen_normals[i]))
        gained = 0.0
        for i in range(N):
            if best[i] < within[i]:
                gained += left_open[i] - (1.0 - 1.0 / (1.0 + (best[i] / scale) ** 2))
        outside = 0.0
        for k in range(2):
            radius = min(
                min(own_shapes[k, 0], own_shapes[k, 1]), min(own_shapes[k, 2], own_shapes[k, 3])
            )
            x = origins[k, 0] + own_lengths[k] * Rs[k, 0, 1]
            y = origins[k, 1] + own_lengths[k] * Rs[k, 1, 1]
            z = origins[k, 2] + own_lengths[k] * Rs[k, 2, 1]
            below = -(floor[0] * x + floor[1] * y + floor[2] * z + floor[3])
            outside += min(max(below, 0.0) / FREE_M, 1.0)
            for s in range(samples):
                t = (s + 0.5) / samples * own_lengths[k]
                _, share, _, _, _, _ = in_free_space(
                    origins[k, 0] + t * Rs[k, 0, 1],
                    origins[k, 1] + t * Rs[k, 1, 1],
                    origins[k, 2] + t * Rs[k, 2, 1],
                    radius, depth, mine, nearest, corner, fx, fy, cx, cy, margin,
                )  # fmt: skip
                outside += share
        explained[m], free[m] = gained, outside
