"""What pulls at a body: places on its parts, and joints, each towards where it should be.

How a place moves with the turn of a joint is linear in the six numbers (n, p x n) of the place p
and the direction n in which it is pulled. So what pulls at a part is summed up as products of
these, and what hangs from a part pulls at it as well; all degrees of freedom are looked at once,
at the end.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(error_model="numpy")
def pull(sums, part, x, y, z, nx, ny, nz, gap, weight):
    """Add the wish that the place (x, y, z) on `part` moves by `gap` along (nx, ny, nz) to `sums`
    [B, 6, 7]: of each part the weighted products of (n, p x n) with (n, p x n, gap), of which those
    on and right of the diagonal are filled."""
    own = sums[part]
    wish = (nx, ny, nz, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx, gap)
    for a in range(6):
        weighted = weight * wish[a]
        for b in range(a, 7):
            own[a, b] += weighted * wish[b]


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
