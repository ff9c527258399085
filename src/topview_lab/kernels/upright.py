"""Bodies drawn on an upright grid, without perspective, for many poses at once."""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.threads import over_threads

PART_SLICES = 7  # ellipsoids along a part
OVERLAP = 0.9  # their semi-axis along the part, against a slice's length


@over_threads("covered")
@njit(cache=True, error_model="numpy", nogil=True)
def draw_upright(
    first_row, row_step, covered, depth, Rs, origins, lengths, shapes, left, top, cell, finer
):  # fmt: skip
    """Fill in which cells of a grid bodies cover, seen along z, and how far off they are there.

    Args:
        covered, depth: [N, rows, columns] float32: the share of each cell, and the mean z of its
            surface, 0 where there is none.
        Rs, origins: [N, B, 3, 3] and [N, B, 3] of the bodies' parts; x to the right, y down.
        lengths, shapes: [B] and [B, 6] as in `topview.body.model.BodyModel`.
        left, top, cell: x and y of the grid's corner, and how wide its cells are.
        finer: rows and columns of rays through each cell.
    """
    rows, columns = covered.shape[1], covered.shape[2]
    step = cell / finer
    for n in range(first_row, covered.shape[0], row_step):
        nearest = np.full((rows * finer, columns * finer), np.inf)
        for k in range(Rs.shape[1]):
            R = Rs[n, k]
            for part_slice in range(PART_SLICES):
                t = (part_slice + 0.5) / PART_SLICES
                rx = shapes[k, 0] + (shapes[k, 2] - shapes[k, 0]) * t
                rz = shapes[k, 1] + (shapes[k, 3] - shapes[k, 1]) * t
                ry = max(OVERLAP * lengths[k] / PART_SLICES, 0.5 * min(rx, rz))
                along = t * lengths[k]
                cx = (
                    origins[n, k, 0]
                    + R[0, 0] * shapes[k, 4]
                    + R[0, 1] * along
                    + R[0, 2] * shapes[k, 5]
                )
                cy = (
                    origins[n, k, 1]
                    + R[1, 0] * shapes[k, 4]
                    + R[1, 1] * along
                    + R[1, 2] * shapes[k, 5]
                )
                cz = (
                    origins[n, k, 2]
                    + R[2, 0] * shapes[k, 4]
                    + R[2, 1] * along
                    + R[2, 2] * shapes[k, 5]
                )
                a, b, c = 1.0 / (rx * rx), 1.0 / (ry * ry), 1.0 / (rz * rz)
                xx = a * R[0, 0] * R[0, 0] + b * R[0, 1] * R[0, 1] + c * R[0, 2] * R[0, 2]
                yy = a * R[1, 0] * R[1, 0] + b * R[1, 1] * R[1, 1] + c * R[1, 2] * R[1, 2]
                zz = a * R[2, 0] * R[2, 0] + b * R[2, 1] * R[2, 1] + c * R[2, 2] * R[2, 2]
                xy = a * R[0, 0] * R[1, 0] + b * R[0, 1] * R[1, 1] + c * R[0, 2] * R[1, 2]
                xz = a * R[0, 0] * R[2, 0] + b * R[0, 1] * R[2, 1] + c * R[0, 2] * R[2, 2]
                yz = a * R[1, 0] * R[2, 0] + b * R[1, 1] * R[2, 1] + c * R[1, 2] * R[2, 2]
                widest = max(rx, max(ry, rz))
                first = max(int((cx - widest - left) / step), 0)
                last = min(int((cx + widest - left) / step) + 1, columns * finer)
                highest = max(int((cy - widest - top) / step), 0)
                lowest = min(int((cy + widest - top) / step) + 1, rows * finer)
                for v in range(highest, lowest):
                    y = top + (v + 0.5) * step - cy
                    for u in range(first, last):
                        x = left + (u + 0.5) * step - cx
                        half = xz * x + yz * y
                        root = half * half - zz * (xx * x * x + yy * y * y + 2.0 * xy * x * y - 1.0)
                        if root >= 0.0:
                            nearest[v, u] = min(nearest[v, u], cz - (half + np.sqrt(root)) / zz)
        for v in range(rows):
            for u in range(columns):
                hits, total = 0, 0.0
                for i in range(finer):
                    for j in range(finer):
                        z = nearest[v * finer + i, u * finer + j]
                        if z < np.inf:
                            hits += 1
                            total += z
                covered[n, v, u] = hits / (finer * finer)
                depth[n, v, u] = total / max(hits, 1)
