"""What the whole body costs with each of many poses of one limb, all else as it is."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import (
    FREE_M,
    facing_surface,
    in_free_space,
    multiply,
    reach_across,
    unlike_seen,
)
from topview.kernels.threads import over_threads


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
