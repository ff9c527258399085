"""What the residuals of a body's surface tell of its pose and size, summed up part by part."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import place_axes
from topview.kernels.pulls import fill_moves

# Of each point: the six numbers of `topview.kernels.pulls`, thickness, stature, residual.
N_TOLD = 9


@njit(cache=True, error_model="numpy")
def sum_up_surface(points, labels, distances, normals, ways, neck, width, out):
    """Fill `out` [B, 9, 9] with the weighted products, over each part's points, of what brings its
    surface nearer: its place and turn (n, p x n), a unit more of its radius, a unit of the body's
    scale about the neck joint, and the distance that is to be closed.

    Args:
        points, labels, distances, normals: [N, 3], [N], [N] and [N, 3] of `assign_points`.
        ways: [B, 3] directions of the parts' axes.
        neck: [3] metres.
        width: of the robust weight, metres.
    """
    out[:] = 0.0
    told = np.empty(N_TOLD)
    for i in range(points.shape[0]):
        k = labels[i]
        if k < 0:
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        d = distances[i]
        told[0], told[1], told[2] = nx, ny, nz
        told[3], told[4], told[5] = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
        along = nx * ways[k, 0] + ny * ways[k, 1] + nz * ways[k, 2]
        told[6] = np.sqrt(max(1.0 - along * along, 0.0))
        told[7] = nx * (x - neck[0]) + ny * (y - neck[1]) + nz * (z - neck[2]) - d
        told[8] = d
        w = 1.0 / (1.0 + (d / width) ** 2)
        for a in range(N_TOLD):
            weighted = w * w * told[a]
            for b in range(N_TOLD):
                out[k, a, b] += weighted * told[b]


@njit(cache=True, error_model="numpy")
def moves_of_pose(neck, Rs, origins, dof_part, dof_axis, out):
    """Fill `out` [D, 6] with what each degree of freedom moves, as of `fill_moves`, in a pose with
    this neck joint [3], rotations [B, 3, 3] and origins [B, 3]."""
    axes, centers = np.empty((dof_part.shape[0], 3)), np.empty((dof_part.shape[0], 3))
    place_axes(neck, Rs, origins, dof_part, dof_axis, axes, centers)
    fill_moves(axes, centers, out)
