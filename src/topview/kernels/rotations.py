"""Rotations of many hypotheses at once.

Definition: `topview.geometry.rotations.rotations_from_angles`.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def turn_parents(Rs, parents, angles_rad, out):
    """Fill `out` [M, 3, 3] with rotations turned in their own frames, about x, y and z.

    Args:
        Rs: [N, 3, 3].
        parents: [M] which of them each comes from.
        angles_rad: [M, 3].
    """
    for m in range(parents.shape[0]):
        cx, cy, cz = np.cos(angles_rad[m, 0]), np.cos(angles_rad[m, 1]), np.cos(angles_rad[m, 2])
        sx, sy, sz = np.sin(angles_rad[m, 0]), np.sin(angles_rad[m, 1]), np.sin(angles_rad[m, 2])
        R = Rs[parents[m]]
        for k in range(3):
            x, y, z = R[k, 0], R[k, 1], R[k, 2]
            along, across = x * cz + sz * (y * cx + z * sx), z * cx - y * sx
            out[m, k, 0] = along * cy - across * sy
            out[m, k, 1] = cz * (y * cx + z * sx) - x * sz
            out[m, k, 2] = along * sy + across * cy
