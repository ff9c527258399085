"""Gauss-Newton for many candidate poses of the whole body (articulated ICP, ours).

Every point pulls the surface that faces the camera and is most like what is seen there: to the
point (to its plane), and, where that is known, to face as what is seen does. Parts that the image
shows to be in free space are pushed out of it, back onto the user's silhouette; limbs are pushed
out of the torso, joints back within their limits. Each candidate is refined on its own and all sums
are taken in one fixed order, so the result does not depend on the number of threads.

The tree hangs from the upper torso, whose origin is the neck joint; the table of degrees of
freedom comes from `topview.track.degrees_of_freedom`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.pulls import move_together, pull, pull_to_joints, turn_as_seen
from topview.kernels.threads import over_threads

# Ours, all of them.
BACK_FACING = 0.2  # cosine between normal and ray from which a surface cannot be the seen one
LARGEST_TURN_RAD = 0.5  # of one step
LARGEST_GAP_M = 0.15  # that one free-space sample may ask for
LARGEST_OVERLAP_M = 0.1  # that one sample inside the torso may ask for
FREE_M = 0.05  # so far in free space, or below the floor, a sample counts in full
INNER_SHARE = 0.25  # of its radius that a part's axis may lie outside of the silhouette
NEAREST_M = 0.1  # what is nearer to the camera is not looked at
HEAD_SCALE_M = 0.1  # width of the robust weight of the head's measured centre
OVERTURNED_RAD = 0.35  # beyond its limit, from which a hip says that its knee bends the wrong way
FLOOR_WEIGHT = 5.0  # of a part's end below the floor, against a free-space sample
LEAST_DAMPING, RAISED, EASED = 0.05, 4.0, 0.25  # of steps, where one has led uphill
UPPER_TORSO = 1
HEAD = 0
SLACK_M = 1e-4  # more than distances are wrong by in 32 bits
TURNED_M = 0.05  # as far off counts a surface at right angles to the one that is seen
CLOSE_M = 0.02  # what is nearer to a surface pulls it to face otherwise, not to come nearer still
LANES = 16  # pieces that are compared with a point at once: all, and a power of two
SETTLED = 0.01  # share of the energy: a step that gains less is the last
STRAIGHT = 0.25  # sine of the flexion below which a limb does not tell its hinge's axis


@njit(error_model="numpy", inline="always")
def surface_distance(x, y, z, length, shapes, k):
    """Signed distance from a point to a tapered elliptic cylinder with rounded ends, and the
    outward normal.

    Returns (distance, nx, ny, nz), all in the part's frame; the radial distance is measured
    towards the axis, and how the sides lean is left out of the normal.

    Args:
        x, y, z: the point in the part's frame, metres.
        length: of the part.
        shapes, k: [S, 6] as in `topview.body.surface.Surface.shapes_m`, and which piece.
    """
    share = min(max(y / length, 0.0), 1.0)
    rx = shapes[k, 0] + (shapes[k, 2] - shapes[k, 0]) * share
    rz = shapes[k, 1] + (shapes[k, 3] - shapes[k, 1]) * share
    x -= shapes[k, 4]
    z -= shapes[k, 5]
    rho = np.sqrt((x / rx) ** 2 + (z / rz) ** 2)
    radial = np.sqrt(x * x + z * z)
    gap = (rho - 1.0) * radial / max(rho, 1e-6)
    gx, gz = x / (rx * rx), z / (rz * rz)
    g = 1.0 / max(np.sqrt(gx * gx + gz * gz), 1e-9)
    nx, nz = gx * g, gz * g
    beyond = y if y < 0.0 else (y - length if y > length else 0.0)
    outside = max(gap, 0.0)
    if beyond != 0.0:
        d = np.sqrt(outside * outside + beyond * beyond)
        inv_d = 1.0 / max(d, 1e-9)
        return d, nx * outside * inv_d, beyond * inv_d, nz * outside * inv_d
    return gap, nx, 0.0, nz


@njit(error_model="numpy")
def nearest_own(nearest, corner, row, column):
    """Row and column of the user's pixel nearest to a place in the image; -1 and -1 for none.

    Args:
        nearest: [h, w] int32, of each pixel of a window that holds all of the user's: the column in
            the image of the nearest of them in its row, -1 for none.
        corner: row and column of the window's first pixel.
        row, column: of the image.
    """
    h, w = nearest.shape
    start = min(max(row - corner[0], 0), h - 1)
    j = min(max(column - corner[1], 0), w - 1)
    best_row, best_column = -1, -1
    best = np.inf
    for step in (-1, 1):
        i = start if step < 0 else start + 1
        while 0 <= i < h and (corner[0] + i - row) ** 2 < best:
            across, down = nearest[i, j] - column, corner[0] + i - row
            squared = across * across + down * down
            if nearest[i, j] >= 0 and squared < best:
                best = squared
                best_row, best_column = corner[0] + i, nearest[i, j]
            i += step
    return best_row, best_column


@njit(error_model="numpy", inline="always")
def in_free_space(x, y, z, radius, depth, mine, nearest, corner, fx, fy, cx, cy, margin):
    """What the image shows at a place on a part's axis.

    Returns (hidden, share, gap, nx, ny, nz): 1 if something else than the user hides it, or it is
    outside of the image, else 0; how much it counts as one in free space, 0 to 1; how far it is to
    be moved, at most `LARGEST_GAP_M`, 0 where it may stay, and the unit vector that way.

    Args:
        x, y, z: the place in metres, camera frame.
        radius: of the part.
        depth, mine, nearest, corner, fx, fy, cx, cy, margin: as in `refine_bodies`.
    """
    if z < NEAREST_M:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    u, v = int(np.round(fx * x / z + cx)), int(np.round(fy * y / z + cy))
    if u < 0 or v < 0 or u >= depth.shape[1] or v >= depth.shape[0]:
        return 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    seen = depth[v, u]
    front = z - radius
    if not mine[v, u]:
        if seen > 0.0 and seen < front + margin:
            return 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
        row, column = nearest_own(nearest, corner, v, u)
        if row < 0:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        du, dv = (column - u) * z / fx, (row - v) * z / fy
        distance = np.sqrt(du * du + dv * dv)
        gap = distance - INNER_SHARE * radius
        if gap <= 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        share = min(gap / FREE_M, 1.0)
        return 0.0, share, min(gap, LARGEST_GAP_M), du / distance, dv / distance, 0.0
    if seen <= front + margin:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    gap = seen - front
    norm = np.sqrt(x * x + y * y + z * z)
    share = min((gap - margin) / FREE_M, 1.0)
    return 0.0, share, min(gap, LARGEST_GAP_M), x / norm, y / norm, z / norm


@njit(error_model="numpy")
def reach_across(shapes, k):
    """How far a part's surface may lie from its axis."""
    widest = max(max(shapes[k, 0], shapes[k, 1]), max(shapes[k, 2], shapes[k, 3]))
    return widest + np.sqrt(shapes[k, 4] * shapes[k, 4] + shapes[k, 5] * shapes[k, 5])


@njit(error_model="numpy")
def place_parts(neck, Rs, lengths, joints_parent, parents, origins):
    """Forward kinematics: fill `origins` [B, 3] from the neck joint and the parts' rotations."""
    for i in range(3):
        origins[UPPER_TORSO, i] = neck[i]
        origins[HEAD, i] = neck[i] - Rs[HEAD, i, 1] * lengths[HEAD]
    for k in range(2, Rs.shape[0]):
        p = parents[k]
        for i in range(3):
            origins[k, i] = (
                origins[p, i]
                + Rs[p, i, 0] * joints_parent[k, 0]
                + Rs[p, i, 1] * joints_parent[k, 1]
                + Rs[p, i, 2] * joints_parent[k, 2]
            )


@njit(error_model="numpy")
def place_pieces(Rs, origins, owners, Rs_part, origins_part, piece_Rs, piece_origins):
    """Fill `piece_Rs` [S, 3, 3] and `piece_origins` [S, 3] of the pieces of a surface, which move
    with parts: as `topview.body.surface.Surface.placed`."""
    for s in range(owners.shape[0]):
        k = owners[s]
        multiply(Rs[k], Rs_part[s], False, piece_Rs[s])
        for i in range(3):
            piece_origins[s, i] = (
                origins[k, i]
                + Rs[k, i, 0] * origins_part[s, 0]
                + Rs[k, i, 1] * origins_part[s, 1]
                + Rs[k, i, 2] * origins_part[s, 2]
            )


@njit(error_model="numpy")
def side_by_side(Rs, origins, lengths, shapes, out):
    """Fill `out` [14, LANES] with the parts' rotations, row by row, origins, lengths and
    `reach_across`; what is no part is near nothing."""
    for k in range(LANES):
        for i in range(14):
            out[i, k] = np.float32(0.0)
        out[12, k] = np.float32(-np.inf)
    for k in range(Rs.shape[0]):
        for i in range(3):
            for j in range(3):
                out[3 * i + j, k] = Rs[k, i, j]
            out[9 + i, k] = origins[k, i]
        out[12, k] = lengths[k]
        out[13, k] = reach_across(shapes, k)


@njit(error_model="numpy", forceinline=True)
def parts_near(px, py, pz, best, parts):
    """Which parts of `side_by_side` may come as near to a point as `best`, a bit for each; none
    that does is left out. All are looked at in one loop without a branch."""
    near = np.int32(0)
    px, py, pz, best = np.float32(px), np.float32(py), np.float32(pz), np.float32(best + SLACK_M)
    for k in range(LANES):
        dx, dy, dz = px - parts[9, k], py - parts[10, k], pz - parts[11, k]
        x = parts[0, k] * dx + parts[3, k] * dy + parts[6, k] * dz
        y = parts[1, k] * dx + parts[4, k] * dy + parts[7, k] * dz
        z = parts[2, k] * dx + parts[5, k] * dy + parts[8, k] * dz
        widest = parts[13, k] + best
        is_near = (y >= -best) & (y <= parts[12, k] + best) & (x * x + z * z <= widest * widest)
        near = np.int32(near | (np.int32(is_near) << k))
    return np.int64(near)


@njit(error_model="numpy", inline="always")
def facing_surface(px, py, pz, k, Rs, origins, lengths, shapes):
    """Signed distance of a point from a part's surface, infinite where that faces away from the
    camera, and the normal, camera frame."""
    dx, dy, dz = px - origins[k, 0], py - origins[k, 1], pz - origins[k, 2]
    x = Rs[k, 0, 0] * dx + Rs[k, 1, 0] * dy + Rs[k, 2, 0] * dz
    y = Rs[k, 0, 1] * dx + Rs[k, 1, 1] * dy + Rs[k, 2, 1] * dz
    z = Rs[k, 0, 2] * dx + Rs[k, 1, 2] * dy + Rs[k, 2, 2] * dz
    d, nx, ny, nz = surface_distance(x, y, z, lengths[k], shapes, k)
    cx = Rs[k, 0, 0] * nx + Rs[k, 0, 1] * ny + Rs[k, 0, 2] * nz
    cy = Rs[k, 1, 0] * nx + Rs[k, 1, 1] * ny + Rs[k, 1, 2] * nz
    cz = Rs[k, 2, 0] * nx + Rs[k, 2, 1] * ny + Rs[k, 2, 2] * nz
    faces_away = cx * px + cy * py + cz * pz > BACK_FACING * np.sqrt(px * px + py * py + pz * pz)
    return np.inf if faces_away else d, cx, cy, cz


@njit(error_model="numpy", inline="always")
def unlike_seen(d, nx, ny, nz, seen):
    """How far a surface with this distance and normal is from what is seen, and how far turned,
    metres; the [3] normal that is seen is zeros where none is known."""
    turned = seen[0] * (seen[0] - nx) + seen[1] * (seen[1] - ny) + seen[2] * (seen[2] - nz)
    return abs(d) + TURNED_M * turned


@njit(cache=True, error_model="numpy")
def assign_points(
    points, seen_normals, Rs, origins, lengths, shapes, reach, labels, distances, normals, unlike
):  # fmt: skip
    """Label every point with the piece whose camera-facing surface is most like what is seen there,
    -1 where none is nearer than `reach`.

    Args:
        points, seen_normals: [N, 3] metres, camera frame, and [N, 3] of the surface that is seen
            there, zeros where it is not known.
        Rs, origins, lengths, shapes: the pieces, [S, 3, 3], [S, 3], [S], [S, 6].
        reach: metres.
        labels: [N] int32; what they are before, which must be pieces or -1, is looked at first: it
            changes nothing but the time, which is least where they are right.
        distances, normals: [N] metres and [N, 3] of that surface, camera frame, filled; the normal
            of no surface says nothing.
        unlike: [N] metres, filled: the distance, and more for a surface that is turned away from
            the one that is seen.
    """
    N = points.shape[0]
    parts = np.empty((14, LANES), np.float32)
    side_by_side(Rs, origins, lengths, shapes, parts)
    near = np.empty(N, np.int64)
    # In three loops: what a branch depends on is known before it, or the processor guesses wrong.
    for i in range(N):
        k = labels[i]
        near[i] = 0
        distances[i] = unlike[i] = np.inf
        if k >= 0:
            near[i] = np.int64(1) << k
            distances[i], normals[i, 0], normals[i, 1], normals[i, 2] = facing_surface(
                points[i, 0], points[i, 1], points[i, 2], k, Rs, origins, lengths, shapes
            )
            unlike[i] = unlike_seen(
                distances[i], normals[i, 0], normals[i, 1], normals[i, 2], seen_normals[i]
            )
    for i in range(N):
        best = min(unlike[i], reach)
        near[i] = ~near[i] & parts_near(points[i, 0], points[i, 1], points[i, 2], best, parts)
    for i in range(N):
        if not unlike[i] < reach:
            labels[i], distances[i] = -1, 0.0
        left, k = near[i], -1
        while left != 0:
            k += 1
            is_near = left & 1
            left >>= 1
            if is_near == 0:
                continue
            d, nx, ny, nz = facing_surface(
                points[i, 0], points[i, 1], points[i, 2], k, Rs, origins, lengths, shapes
            )
            label = labels[i]
            best = reach if label < 0 else unlike[i]
            off = unlike_seen(d, nx, ny, nz, seen_normals[i])
            if off < best or (off == best and k < label):
                labels[i], distances[i], unlike[i] = k, d, off
                normals[i, 0], normals[i, 1], normals[i, 2] = nx, ny, nz


@njit(error_model="numpy")
def place_axes(neck, Rs, origins, dof_part, dof_axis, axes, centers):
    """Fill [D, 3] axes and centres of the degrees of freedom; the first three have no centre."""
    for d in range(dof_part.shape[0]):
        k = dof_part[d]
        for i in range(3):
            axes[d, i] = Rs[k, i, dof_axis[d]] if d >= 3 else (1.0 if i == d else 0.0)
            centers[d, i] = neck[i] if k == HEAD else origins[k, i]


@njit(error_model="numpy")
def solve_lower(A, g):
    """Solve A x = g for symmetric positive definite A [n, n] given by its lower triangle, which
    Cholesky's factor replaces; g becomes x, and is returned."""
    n = A.shape[0]
    for i in range(n):
        for j in range(i + 1):
            s = A[i, j]
            for k in range(j):
                s -= A[i, k] * A[j, k]
            A[i, j] = np.sqrt(max(s, 1e-12)) if i == j else s / A[j, j]
    for i in range(n):
        for k in range(i):
            g[i] -= A[i, k] * g[k]
        g[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            g[i] -= A[k, i] * g[k]
        g[i] /= A[i, i]
    return g


@njit(error_model="numpy")
def marginal_information(L, out):
    """Fill `out` [K] with one over the first of the diagonal of the inverse of L L^T, given by
    Cholesky's factor L [n, n] in the lower triangle."""
    n = L.shape[0]
    column = np.empty(n)
    for d in range(out.shape[0]):
        variance = 0.0
        for i in range(d, n):
            s = 1.0 if i == d else 0.0
            for k in range(d, i):
                s -= L[i, k] * column[k]
            column[i] = s / L[i, i]
            variance += column[i] * column[i]
        out[d] = 1.0 / variance


@njit(error_model="numpy")
def multiply(A, B, transpose_a, out):
    for i in range(3):
        for j in range(3):
            s = 0.0
            for k in range(3):
                s += (A[k, i] if transpose_a else A[i, k]) * B[k, j]
            out[i, j] = s


@njit(error_model="numpy")
def copy(R, out):
    """By element: `out[:] = R` compiles seconds of text for an error that cannot come up."""
    for i in range(3):
        for j in range(3):
            out[i, j] = R[i, j]


@njit(error_model="numpy")
def copy_system(A, g, out_A, out_g):
    """Copy the lower triangle of A [n, n], and g [n]."""
    for i in range(A.shape[0]):
        out_g[i] = g[i]
        for j in range(i + 1):
            out_A[i, j] = A[i, j]


@njit(error_model="numpy")
def rotation(wx, wy, wz, out):
    """Rodrigues' formula."""
    angle = np.sqrt(wx * wx + wy * wy + wz * wz)
    if angle < 1e-8:
        a, b = 1.0, 0.5
    else:
        a, b = np.sin(angle) / angle, (1.0 - np.cos(angle)) / (angle * angle)
    out[0, 0] = 1.0 - b * (wy * wy + wz * wz)
    out[1, 1] = 1.0 - b * (wx * wx + wz * wz)
    out[2, 2] = 1.0 - b * (wx * wx + wy * wy)
    out[0, 1], out[1, 0] = b * wx * wy - a * wz, b * wx * wy + a * wz
    out[0, 2], out[2, 0] = b * wx * wz + a * wy, b * wx * wz - a * wy
    out[1, 2], out[2, 1] = b * wy * wz - a * wx, b * wy * wz + a * wx


@njit(error_model="numpy")
def vector(R, out):
    """Inverse of `rotation`, for angles below 180 degrees."""
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    sine = 0.5 * np.sqrt(x * x + y * y + z * z)
    angle = np.arctan2(sine, 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0))
    scale = 0.5 * angle / sine if sine > 1e-9 else 0.5
    out[0], out[1], out[2] = x * scale, y * scale, z * scale


@njit(error_model="numpy")
def orthonormalise(R):
    """Undo rounding, in place: y keeps its direction, x its plane with y (Gram and Schmidt)."""
    n = 1.0 / np.sqrt(R[0, 1] ** 2 + R[1, 1] ** 2 + R[2, 1] ** 2)
    for i in range(3):
        R[i, 1] *= n
    along = R[0, 0] * R[0, 1] + R[1, 0] * R[1, 1] + R[2, 0] * R[2, 1]
    for i in range(3):
        R[i, 0] -= along * R[i, 1]
    n = 1.0 / np.sqrt(R[0, 0] ** 2 + R[1, 0] ** 2 + R[2, 0] ** 2)
    for i in range(3):
        R[i, 0] *= n
    R[0, 2] = R[1, 0] * R[2, 1] - R[2, 0] * R[1, 1]
    R[1, 2] = R[2, 0] * R[0, 1] - R[0, 0] * R[2, 1]
    R[2, 2] = R[0, 0] * R[1, 1] - R[1, 0] * R[0, 1]


@njit(error_model="numpy")
def relative_rotations(Rs, tree, out):
    """[B, 3, 3] camera-frame rotations to those in the tree that hangs from the upper torso."""
    for k in range(Rs.shape[0]):
        if tree[k] < 0:
            copy(Rs[k], out[k])
        else:
            multiply(Rs[tree[k]], Rs[k], True, out[k])


@njit(error_model="numpy")
def turn_parts(relative, Rs, step, tree, dof_of, n_dof_of, dof_axis):
    """Turn every part by its degrees of freedom, and what hangs from it along.

    Args:
        relative: [B, 3, 3] of `relative_rotations`; is changed. Rs: [B, 3, 3] is filled.
        step: [D] radians, each at most `LARGEST_TURN_RAD`.
        tree, dof_of, n_dof_of, dof_axis: as in `refine_bodies`.
    """
    away = np.empty(3)
    R = np.empty((3, 3))
    R2 = np.empty((3, 3))
    for k in range(Rs.shape[0]):
        away[:] = 0.0
        for a in range(n_dof_of[k]):
            d = dof_of[k, a]
            away[dof_axis[d]] = min(max(step[d], -LARGEST_TURN_RAD), LARGEST_TURN_RAD)
        rotation(away[0], away[1], away[2], R)
        multiply(relative[k], R, False, R2)
        copy(R2, relative[k])
    copy(relative[UPPER_TORSO], Rs[UPPER_TORSO])
    multiply(Rs[UPPER_TORSO], relative[HEAD], False, Rs[HEAD])
    for k in range(2, Rs.shape[0]):
        multiply(Rs[tree[k]], relative[k], False, Rs[k])
    for k in range(Rs.shape[0]):
        orthonormalise(Rs[k])


@njit(error_model="numpy")
def align_hinges(Rs, hinges, bends):
    """Turn the upper part of each hinge pair about its own axis until the joint is a hinge; that
    of a nearly straight limb is kept.

    Args:
        hinges: [P, 2] upper and lower part; bends: [P] +1 for elbows, -1 for knees.
    """
    x = np.empty(3)
    for h in range(hinges.shape[0]):
        up, low = hinges[h, 0], hinges[h, 1]
        nx = bends[h] * (Rs[up, 1, 1] * Rs[low, 2, 1] - Rs[up, 2, 1] * Rs[low, 1, 1])
        ny = bends[h] * (Rs[up, 2, 1] * Rs[low, 0, 1] - Rs[up, 0, 1] * Rs[low, 2, 1])
        nz = bends[h] * (Rs[up, 0, 1] * Rs[low, 1, 1] - Rs[up, 1, 1] * Rs[low, 0, 1])
        norm = np.sqrt(nx * nx + ny * ny + nz * nz)
        w = min(norm / STRAIGHT, 1.0)
        inv = w / max(norm, 1e-9)
        x[0] = nx * inv + (1.0 - w) * Rs[up, 0, 0]
        x[1] = ny * inv + (1.0 - w) * Rs[up, 1, 0]
        x[2] = nz * inv + (1.0 - w) * Rs[up, 2, 0]
        for part in (up, low):
            along = x[0] * Rs[part, 0, 1] + x[1] * Rs[part, 1, 1] + x[2] * Rs[part, 2, 1]
            px = x[0] - along * Rs[part, 0, 1]
            py = x[1] - along * Rs[part, 1, 1]
            pz = x[2] - along * Rs[part, 2, 1]
            n = np.sqrt(px * px + py * py + pz * pz)
            if n < 1e-6:
                continue
            Rs[part, 0, 0], Rs[part, 1, 0], Rs[part, 2, 0] = px / n, py / n, pz / n
            Rs[part, 0, 2] = Rs[part, 1, 0] * Rs[part, 2, 1] - Rs[part, 2, 0] * Rs[part, 1, 1]
            Rs[part, 1, 2] = Rs[part, 2, 0] * Rs[part, 0, 1] - Rs[part, 0, 0] * Rs[part, 2, 1]
            Rs[part, 2, 2] = Rs[part, 0, 0] * Rs[part, 1, 1] - Rs[part, 1, 0] * Rs[part, 0, 1]


@njit(error_model="numpy")
def beyond_limits(low, high, angle):
    """Signed radians by which an angle in -180..180 degrees lies beyond its limits, the shorter
    way round (`topview.body.limits`)."""
    away = angle - 0.5 * (low + high)
    if away > np.pi:
        angle -= 2.0 * np.pi
    elif away < -np.pi:
        angle += 2.0 * np.pi
    return max(angle - high, 0.0) - max(low - angle, 0.0)


@njit(error_model="numpy")
def add_limits(A, g, Rs, parents, limits, weight, dof_of, n_dof_of, axes):
    """Push joints back within the limits: turns about the parent's x, then about z, then y.

    A limb's turn about its own axis is not free but follows from its hinge, so a hip that has to
    turn too far means a knee that bends the wrong way: it is the knee that is pushed, to straight.
    Returns the weighted sum of squares.
    """
    energy = 0.0
    R = np.empty((3, 3))
    about = np.empty((3, 3))
    overturned = np.zeros(Rs.shape[0])
    for k in range(1, Rs.shape[0]):
        p = parents[k]
        multiply(Rs[p], Rs[k], True, R)
        z = np.arcsin(min(max(-R[0, 1], -1.0), 1.0))
        x = np.arctan2(R[2, 1], R[1, 1])
        y = np.arctan2(R[0, 2], R[0, 0])
        # the other decomposition of the same rotation, where it fits the limits better
        x2 = x + np.pi if x < 0 else x - np.pi
        z2 = np.pi - z if z > 0 else -np.pi - z
        ex = abs(beyond_limits(limits[k, 0, 0], limits[k, 0, 1], x))
        ez = abs(beyond_limits(limits[k, 2, 0], limits[k, 2, 1], z))
        ex2 = abs(beyond_limits(limits[k, 0, 0], limits[k, 0, 1], x2))
        ez2 = abs(beyond_limits(limits[k, 2, 0], limits[k, 2, 1], z2))
        if ex2 + ez2 < ex + ez:
            x, z = x2, z2
            y = y + np.pi if y < 0 else y - np.pi
        angles = (x, y, z)
        overturned[k] = abs(beyond_limits(limits[k, 1, 0], limits[k, 1, 1], y))
        # axes of the three turns in the camera frame
        for i in range(3):
            about[0, i] = Rs[p, i, 0]
            about[1, i] = Rs[k, i, 1]
            about[2, i] = np.cos(x) * Rs[p, i, 2] - np.sin(x) * Rs[p, i, 1]
        for turn in range(3):
            low, high = limits[k, turn, 0], limits[k, turn, 1]
            if high - low > 6.28:
                continue
            beyond = beyond_limits(low, high, angles[turn])
            is_knee = low < -1.0 and high < 1.0 and turn == 0
            if is_knee and overturned[p] > OVERTURNED_RAD:
                beyond = angles[turn]
            if beyond == 0.0:
                continue
            energy += weight * beyond * beyond
            for a in range(n_dof_of[k]):
                i = dof_of[k, a]
                ja = (
                    axes[i, 0] * about[turn, 0]
                    + axes[i, 1] * about[turn, 1]
                    + axes[i, 2] * about[turn, 2]
                )
                g[i] -= weight * ja * beyond
                for b in range(a + 1):
                    j = dof_of[k, b]
                    jb = (
                        axes[j, 0] * about[turn, 0]
                        + axes[j, 1] * about[turn, 1]
                        + axes[j, 2] * about[turn, 2]
                    )
                    A[i, j] += weight * ja * jb
    return energy


@over_threads("necks")
@njit(cache=True, error_model="numpy", nogil=True)
def refine_bodies(
    first_row, row_step,
    necks, Rs_all, necks_prior, Rs_prior,
    lengths, shapes, owners, Rs_part, origins_part, joints_parent, parents, tree,
    limits, hinges, bends, dof_part, dof_axis, chain, n_chain, dof_of, n_dof_of, prior_weights,
    points, seen_normals, depth, mine, nearest, corner, fx, fy, cx, cy, head, head_weight, floor,
    reach, scale, point_weight, margin, free_weight, collision_weight, limit_weight, samples,
    iterations, places, scales, joint_part, joints_part, joint_weight, costs, information,
):  # fmt: skip
    """Refine M candidate poses in place and fill `costs` [M, 5].

    Args:
        necks, Rs_all: [M, 3] metres and [M, B, 3, 3] `Rs_camera_part`: the candidates.
        necks_prior, Rs_prior: [M, 3] and [M, B, 3, 3], the pose that each candidate is held to, its
            rotations relative to the tree.
        lengths, shapes, owners, Rs_part, origins_part: of a `topview.body.surface.Surface`, whose
            first B pieces are the parts' own.
        joints_parent: [B, 3] of the body in metres; parents: [B] of the table of parts.
        tree: [B] parents in the tree that hangs from the upper torso.
        limits: [B, 3, 2] radians; hinges, bends: as in `align_hinges`.
        dof_part, dof_axis: [D] which part each degree of freedom turns, about which of its axes;
            the first three move the neck joint along the camera's axes.
        chain, n_chain: [B, C] and [B], the degrees of freedom that move each part.
        dof_of, n_dof_of: [B, 3] and [B], those that turn the part itself.
        prior_weights: [D].
        points, seen_normals: as in `assign_points`, of the user.
        depth: [H, W] float32 metres, 0 without a reading; mine: [H, W] bool, the user's pixels;
            nearest, corner: as in `nearest_own`.
        head, head_weight: [3] measured centre of the head, and its weight, 0 for none.
        floor: [4] upward normal and height of the camera, zeros for none: h = n . p + d >= 0.
        reach, scale: metres; points farther off do not pull, and the width of the robust weight.
        point_weight: of each point, which the other weights are against.
        margin: metres that a part may lie in front of what is seen.
        free_weight, collision_weight, limit_weight: of a sample in free space, a limb's sample
            inside the torso, and a radian beyond the limits.
        samples: places on each part's axis that are tested against free space and the torso.
        iterations: Gauss-Newton steps, at most.
        places, scales, joint_part, joints_part, joint_weight: as in
            `topview.kernels.pulls.pull_to_joints`; no joints where nothing is proposed.
        costs: [M, 5] unexplained share of the points, share of axis samples in free space, mean
            squared departure from the prior pose, share of axis samples that something else than
            the user hides or that lie outside of the image, and mean robust residual of the joints.
        information: [M, K] is filled with what is known of the first K degrees of freedom, each
            with all others free: inverse variance in the unit of the prior weights, with the prior.
    """
    B = Rs_all.shape[1]
    D = dof_part.shape[0]
    N = points.shape[0]
    best_neck = np.empty(3)
    best_Rs = np.empty((B, 3, 3))
    origins = np.empty((B, 3))
    piece_Rs, piece_origins = np.empty((owners.shape[0], 3, 3)), np.empty((owners.shape[0], 3))
    relative = np.empty((B, 3, 3))
    R = np.empty((3, 3))
    away = np.empty(3)
    axes = np.empty((D, 3))
    centers = np.empty((D, 3))
    A, best_A = np.empty((D, D)), np.empty((D, D))
    g, best_g = np.empty(D), np.empty(D)
    sums = np.empty((B, 6, 7))
    labels = np.full(N, -1, np.int32)  # of a candidate are a good guess of the next one's
    distances, unlike = np.empty(N), np.empty(N)
    normals = np.empty((N, 3))
    for m in range(first_row, necks.shape[0], row_step):
        neck = necks[m]
        Rs = Rs_all[m]
        unexplained = 0.0
        free = 0.0
        departure = 0.0
        hidden = 0.0
        apart = 0.0
        least = np.inf
        damping = 0.0
        # the last round only measures
        for iteration in range(iterations + 1):
            place_parts(neck, Rs, lengths, joints_parent, parents, origins)
            place_pieces(Rs, origins, owners, Rs_part, origins_part, piece_Rs, piece_origins)
            assign_points(
                points, seen_normals, piece_Rs, piece_origins, lengths, shapes, reach, labels,
                distances, normals, unlike,
            )  # fmt: skip
            place_axes(neck, Rs, origins, dof_part, dof_axis, axes, centers)
            A[:] = 0.0
            g[:] = 0.0
            sums[:] = 0.0

            energy = 0.0
            unexplained = 0.0
            for i in range(N):
                k = labels[i]
                if k < 0:
                    unexplained += 1.0
                    continue
                w = 1.0 / (1.0 + (unlike[i] / scale) ** 2)
                unexplained += 1.0 - w
                if iteration == iterations:
                    continue
                weight = w * w * point_weight
                off = max(abs(distances[i]), min(unlike[i], CLOSE_M), 1e-9)
                pull(
                    sums, owners[k],
                    points[i, 0], points[i, 1], points[i, 2],
                    normals[i, 0], normals[i, 1], normals[i, 2],
                    distances[i], weight * unlike[i] / off,
                )  # fmt: skip
                sx, sy, sz = seen_normals[i, 0], seen_normals[i, 1], seen_normals[i, 2]
                if sx != 0.0 or sy != 0.0 or sz != 0.0:
                    turn_as_seen(
                        sums, owners[k],
                        points[i, 0], points[i, 1], points[i, 2],
                        normals[i, 0], normals[i, 1], normals[i, 2], seen_normals[i],
                        piece_Rs[k], piece_origins[k], lengths[k], shapes, k,
                        weight * unlike[i] * TURNED_M,
                    )  # fmt: skip

            energy += point_weight * scale * scale * unexplained

            free = 0.0
            hidden = 0.0
            for k in range(B):
                radius = min(min(shapes[k, 0], shapes[k, 1]), min(shapes[k, 2], shapes[k, 3]))
                x = origins[k, 0] + lengths[k] * Rs[k, 0, 1]
                y = origins[k, 1] + lengths[k] * Rs[k, 1, 1]
                z = origins[k, 2] + lengths[k] * Rs[k, 2, 1]
                below = -(floor[0] * x + floor[1] * y + floor[2] * z + floor[3])
                if below > 0.0:
                    free += min(below / FREE_M, 1.0)
                    energy += FLOOR_WEIGHT * free_weight * below * below
                    pull(
                        sums, k, x, y, z,
                        floor[0], floor[1], floor[2], below, FLOOR_WEIGHT * free_weight,
                    )  # fmt: skip
                for s in range(samples):
                    t = (s + 0.5) / samples * lengths[k]
                    x = origins[k, 0] + t * Rs[k, 0, 1]
                    y = origins[k, 1] + t * Rs[k, 1, 1]
                    z = origins[k, 2] + t * Rs[k, 2, 1]
                    if k > 2:
                        for torso in range(1, 3):
                            dx = x - origins[torso, 0]
                            dy = y - origins[torso, 1]
                            dz = z - origins[torso, 2]
                            q = Rs[torso]
                            ly = q[0, 1] * dx + q[1, 1] * dy + q[2, 1] * dz
                            if ly < 0.0 or ly > lengths[torso]:
                                continue
                            d, nx, _, nz = surface_distance(
                                q[0, 0] * dx + q[1, 0] * dy + q[2, 0] * dz,
                                ly,
                                q[0, 2] * dx + q[1, 2] * dy + q[2, 2] * dz,
                                lengths[torso], shapes, torso,
                            )  # fmt: skip
                            gap = min(0.5 * radius - d, LARGEST_OVERLAP_M)
                            if gap > 0.0:
                                energy += collision_weight * gap * gap
                                pull(
                                    sums, k, x, y, z,
                                    q[0, 0] * nx + q[0, 2] * nz,
                                    q[1, 0] * nx + q[1, 2] * nz,
                                    q[2, 0] * nx + q[2, 2] * nz,
                                    gap, collision_weight,
                                )  # fmt: skip
                    is_hidden, share, gap, nx, ny, nz = in_free_space(
                        x, y, z, radius, depth, mine, nearest, corner, fx, fy, cx, cy, margin
                    )
                    hidden += is_hidden
                    free += share
                    if gap > 0.0:
                        energy += free_weight * gap * gap
                        pull(sums, k, x, y, z, nx, ny, nz, gap, free_weight)

            if head_weight > 0.0:
                half = 0.5 * lengths[HEAD]
                x = neck[0] - half * Rs[HEAD, 0, 1]
                y = neck[1] - half * Rs[HEAD, 1, 1]
                z = neck[2] - half * Rs[HEAD, 2, 1]
                for i in range(3):
                    gap = head[i] - (x if i == 0 else (y if i == 1 else z))
                    squared = 1.0 + (gap / HEAD_SCALE_M) ** 2
                    w = head_weight / squared
                    energy += head_weight * HEAD_SCALE_M * HEAD_SCALE_M * np.log(squared)
                    pull(
                        sums, HEAD, x, y, z,
                        1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0,
                        gap, w,
                    )  # fmt: skip

            apart = pull_to_joints(
                A, sums, Rs, origins, places, scales, joint_part, joints_part, chain, n_chain,
                axes, centers, joint_weight,
            )  # fmt: skip
            if iteration < iterations:
                move_together(A, g, sums, tree, dof_part, chain, n_chain, axes, centers)
            energy += 2.0 * joint_weight * apart * 3.0 * places.shape[0]
            energy += add_limits(A, g, Rs, parents, limits, limit_weight, dof_of, n_dof_of, axes)
            relative_rotations(Rs, tree, relative)
            departure = 0.0
            for i in range(3):
                offset = neck[i] - necks_prior[m, i]
                A[i, i] += prior_weights[i]
                g[i] -= prior_weights[i] * offset
                energy += prior_weights[i] * offset * offset
            for k in range(B):
                multiply(Rs_prior[m, k], relative[k], True, R)
                vector(R, away)
                for a in range(n_dof_of[k]):
                    d = dof_of[k, a]
                    A[d, d] += prior_weights[d]
                    g[d] -= prior_weights[d] * away[dof_axis[d]]
                    departure += away[dof_axis[d]] ** 2
                    energy += prior_weights[d] * away[dof_axis[d]] ** 2
            if iteration == 0 or energy < least:
                is_settled = iteration > 0 and least - energy < SETTLED * least
                least = energy
                damping *= EASED
                costs[m, 0] = unexplained / max(N, 1)
                costs[m, 1] = free / (B * samples)
                costs[m, 2] = departure / D
                costs[m, 3] = hidden / (B * samples)
                costs[m, 4] = apart
                for i in range(3):
                    best_neck[i] = neck[i]
                for k in range(B):
                    copy(Rs[k], best_Rs[k])
                if iteration < iterations:
                    copy_system(A, g, best_A, best_g)
                if is_settled:
                    break
            else:
                damping = max(damping, LEAST_DAMPING) * RAISED
                for i in range(3):
                    neck[i] = best_neck[i]
                for k in range(B):
                    copy(best_Rs[k], Rs[k])
                relative_rotations(Rs, tree, relative)
                copy_system(best_A, best_g, A, g)
            if iteration == iterations:
                break
            for d in range(D):
                A[d, d] += damping * A[d, d]

            step = solve_lower(A, g)
            for i in range(3):
                neck[i] += step[i]
            turn_parts(relative, Rs, step, tree, dof_of, n_dof_of, dof_axis)
            align_hinges(Rs, hinges, bends)
        for i in range(3):
            neck[i] = best_neck[i]
        for k in range(B):
            copy(best_Rs[k], Rs[k])
        if iterations > 0:
            solve_lower(best_A, best_g)
            marginal_information(best_A, information[m])
