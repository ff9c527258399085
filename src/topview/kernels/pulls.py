"""What pulls at a body: places on its parts, and joints, each towards where it should be."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(error_model="numpy")
def pull(A, g, J, part, chain, n_chain, axes, centers, x, y, z, nx, ny, nz, gap, weight):
    """Add the wish that the place (x, y, z) on `part` moves by `gap` along (nx, ny, nz)."""
    n = n_chain[part]
    for a in range(n):
        d = chain[part, a]
        ax, ay, az = axes[d, 0], axes[d, 1], axes[d, 2]
        if d < 3:
            J[a] = ax * nx + ay * ny + az * nz
        else:
            rx, ry, rz = x - centers[d, 0], y - centers[d, 1], z - centers[d, 2]
            J[a] = (ay * rz - az * ry) * nx + (az * rx - ax * rz) * ny + (ax * ry - ay * rx) * nz
    for a in range(n):
        wa = weight * J[a]
        row = chain[part, a]
        g[row] += wa * gap
        for b in range(a + 1):
            A[row, chain[part, b]] += wa * J[b]


@njit(error_model="numpy")
def pull_to_joints(
    A, g, J, neck, Rs, origins, places, scales, joint_part, joints_part, chain, n_chain, axes,
    centers, joint_weight,
):  # fmt: skip
    """Add the wish that every joint lies where it was proposed to the lower triangle of A [D, D]
    and to g [D], and give the mean robust residual.

    Args:
        A, g: half the cost's Hessian (Gauss-Newton's) and its downward gradient.
        J: [C] is overwritten.
        neck, Rs, origins: the pose, [3], [B, 3, 3] and [B, 3].
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
            pull(A, g, J, k, chain, n_chain, axes, centers, x, y, z, nx, ny, nz, gap, weight)
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
