"""What pulls at a body: places on its parts, and joints, each towards where it should be.

How a place moves with the turn of a joint is linear in the six numbers (n, p x n) of the place p
and the direction n in which it is pulled. So what pulls at a part is summed up as products of
these, and what hangs from a part pulls at it as well; all degrees of freedom are looked at once,
at the end.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SIDEWAYS = 0.5  # sine between normal and axis up to which a surface is a part's end; ours


@njit(error_model="numpy")
def pull(sums, part, x, y, z, nx, ny, nz, gap, weight):
    """Add the wish that the place (x, y, z) on `part` moves by `gap` along (nx, ny, nz) to `sums`
    [B, 6, 7]: of each part the weighted products of (n, p x n) with (n, p x n, gap), of which those
    on and right of the diagonal are filled."""
    wish = (nx, ny, nz, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx, gap)
    _add(sums[part], wish, weight, 0)


@njit(error_model="numpy")
def _add(own, wish, weight, first):
    """Add the weighted products of a wish [7], of which those before the first are zero, to those
    on and right of the diagonal of [6, 7]."""
    for a in range(first, 6):
        weighted = weight * wish[a]
        for b in range(a, 7):
            own[a, b] += weighted * wish[b]


@njit(error_model="numpy")
def turn_as_seen(
    sums, part, x, y, z, nx, ny, nz, seen, R, origin, length, shapes, k, weight
):  # fmt: skip
    """Add the wish that the surface at the place (x, y, z) faces as what is seen there to `sums` of
    `pull`: the weighted square of the difference of both normals, as far as the part's sides change
    theirs. A part's normal n changes by its turn, and by how far it moves past the place, as it is
    round.

    Args:
        sums, part: as in `pull`.
        x, y, z, nx, ny, nz: the place, and n; camera frame.
        seen: [3] normal of what is seen.
        R, origin, length, shapes, k: the piece of surface, [3, 3], [3], metres and its row of
            `topview.body.surface.Surface.shapes_m`.
        weight: of the square.
    """
    ax, ay, az = R[0, 1], R[1, 1], R[2, 1]
    tx, ty, tz = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
    sine = np.sqrt(tx * tx + ty * ty + tz * tz)
    if sine < SIDEWAYS:
        return
    tx, ty, tz = tx / sine, ty / sine, tz / sine  # round the part
    bx, by, bz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx  # along it

    dx, dy, dz = x - origin[0], y - origin[1], z - origin[2]
    share = min(max((dx * ax + dy * ay + dz * az) / length, 0.0), 1.0)
    rx = shapes[k, 0] + (shapes[k, 2] - shapes[k, 0]) * share
    rz = shapes[k, 1] + (shapes[k, 3] - shapes[k, 1]) * share
    gx = (dx * R[0, 0] + dy * R[1, 0] + dz * R[2, 0] - shapes[k, 4]) / (rx * rx)
    gz = (dx * R[0, 2] + dy * R[1, 2] + dz * R[2, 2] - shapes[k, 5]) / (rz * rz)
    steepness = max(np.sqrt(gx * gx + gz * gz), 0.5 / max(rx, rz))  # at the axis there is none
    across_x = (tx * R[0, 0] + ty * R[1, 0] + tz * R[2, 0]) / (rx * rx)
    across_z = (tx * R[0, 2] + ty * R[1, 2] + tz * R[2, 2]) / (rz * rz)
    # How fast n turns round the part as that moves past the place, along each axis.
    cx = -(across_x * R[0, 0] + across_z * R[0, 2]) / steepness
    cy = -(across_x * R[1, 0] + across_z * R[1, 2]) / steepness
    cz = -(across_x * R[2, 0] + across_z * R[2, 2]) / steepness
    round_it = seen[0] * tx + seen[1] * ty + seen[2] * tz
    turn = (y * cz - z * cy + bx, z * cx - x * cz + by, x * cy - y * cx + bz)
    _add(sums[part], (cx, cy, cz, turn[0], turn[1], turn[2], round_it), weight, 0)
    along_it = seen[0] * bx + seen[1] * by + seen[2] * bz
    _add(sums[part], (0.0, 0.0, 0.0, -tx, -ty, -tz, along_it), weight, 3)


@njit(error_model="numpy")
def fill_moves(axes, centers, moves):
    """Fill `moves` [D, 6] of the degrees of freedom of `topview.kernels.body.place_axes`: a place p
    on what one moves goes along n by (n, p x n) . moves."""
    for d in range(moves.shape[0]):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            around = centers[d, j] * axes[d, k] - centers[d, k] * axes[d, j]
            moves[d, i] = axes[d, i] if d < 3 else around
            moves[d, 3 + i] = 0.0 if d < 3 else axes[d, i]


@njit(error_model="numpy")
def move_together(A, g, sums, tree, dof_part, chain, n_chain, axes, centers):
    """Add what pulls at the parts to the lower triangle of A [D, D] and to g [D].

    Args:
        A, g: half the cost's Hessian (Gauss-Newton's) and its downward gradient.
        sums: [B, 6, 7] of `pull`; are changed.
        tree, dof_part, chain, n_chain: as in `topview.kernels.body.refine_bodies`.
        axes, centers: as of `topview.kernels.body.place_axes`.
    """
    moves = np.empty((dof_part.shape[0], 6))
    fill_moves(axes, centers, moves)
    for k in range(sums.shape[0] - 1, -1, -1):
        if tree[k] >= 0:
            for a in range(6):
                for b in range(a, 7):
                    sums[tree[k], a, b] += sums[k, a, b]
    along = np.empty(6)
    for k in range(sums.shape[0]):
        for a in range(6):
            for b in range(a):
                sums[k, a, b] = sums[k, b, a]
        for first in range(n_chain[k]):
            d = chain[k, first]
            if dof_part[d] != k:
                continue
            for a in range(6):
                along[a] = 0.0
                for b in range(6):
                    along[a] += sums[k, a, b] * moves[d, b]
                g[d] += sums[k, a, 6] * moves[d, a]
            for second in range(first + 1):
                e = chain[k, second]
                for a in range(6):
                    A[d, e] += along[a] * moves[e, a]


@njit(error_model="numpy")
def pull_to_joints(
    A, sums, Rs, origins, places, scales, joint_part, joints_part, chain, n_chain, axes, centers,
    joint_weight,
):  # fmt: skip
    """Add the wish that every joint lies where it was proposed to `sums` of `pull`, and how it
    bends to the diagonal of A [D, D]; give the mean robust residual.

    Args:
        A: as in `move_together`.
        Rs, origins: the pose, [B, 3, 3] and [B, 3].
        places, scales: [K, 3], metres; a scale is infinite for what is not proposed.
        joint_part, joints_part: [K] the part that carries each joint, and [K, 3] where, metres.
        chain, n_chain, axes, centers: degrees of freedom, as in `topview.kernels.body`.
        joint_weight: of a residual of one scale.
    """
    bent = np.zeros(A.shape[0])
    force = np.empty(3)
    total = 0.0
    count = 0
    for j in range(places.shape[0]):
        k = joint_part[j]
        x, y, z = origins[k, 0], origins[k, 1], origins[k, 2]
        for i in range(3):
            x += Rs[k, 0, i] * joints_part[j, i]
            y += Rs[k, 1, i] * joints_part[j, i]
            z += Rs[k, 2, i] * joints_part[j, i]
        ez = places[j, 2] - z
        force[0] = force[1] = force[2] = 0.0
        for i in range(3):
            scale = scales[j, i]
            if not scale < np.inf:
                continue
            nx, ny, nz = 0.0, 0.0, 1.0
            if i == 0:
                nx, nz = 1.0, -places[j, 0] / places[j, 2]
                gap = places[j, 0] - x + nz * ez
            elif i == 1:
                ny, nz = 1.0, -places[j, 1] / places[j, 2]
                gap = places[j, 1] - y + nz * ez
            else:
                gap = ez
            root = np.sqrt(1.0 + (gap / scale) ** 2)
            total += root - 1.0
            count += 1
            weight = joint_weight / (scale * scale * root)
            pull(sums, k, x, y, z, nx, ny, nz, gap, weight)
            force[0] += weight * gap * nx
            force[1] += weight * gap * ny
            force[2] += weight * gap * nz
        _bend(bent, force, k, chain, n_chain, axes, centers, x, y, z)
    for d in range(3, bent.shape[0]):
        A[d, d] += max(bent[d], 0.0)
    return total / max(count, 1)


@njit(error_model="numpy")
def _bend(bent, force, part, chain, n_chain, axes, centers, x, y, z):
    """Add the curvature that a force at a place on a part has because turns move it on circles:
    Gauss-Newton leaves it out, and steps too far where joints are pulled away from each other."""
    for a in range(n_chain[part]):
        d = chain[part, a]
        if d < 3:
            continue
        rx, ry, rz = x - centers[d, 0], y - centers[d, 1], z - centers[d, 2]
        along = axes[d, 0] * rx + axes[d, 1] * ry + axes[d, 2] * rz
        bent[d] += force[0] * (rx - along * axes[d, 0])
        bent[d] += force[1] * (ry - along * axes[d, 1])
        bent[d] += force[2] * (rz - along * axes[d, 2])
