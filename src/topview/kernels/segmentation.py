"""Distances along the visible surface, for the segmentation of people."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def geodesic_distance(
    depth_m: NDArray[np.float32],
    is_allowed: NDArray[np.bool_],
    focal_px: float,
    jump_m: float,
    jump_per_square_m: float,
    limit_m: float,
    out_m: NDArray[np.float32],
) -> None:
    """Length of the shortest way over the surface to each pixel, in place.

    Raster sweeps over the 8-neighbourhood until nothing changes. A step from one pixel to the next
    is as long as the two points are apart, and is taken only where both are allowed and their
    depths differ by at most `jump_m + jump_per_square_m * z^2`.

    Args:
        depth_m: [h, w] metres.
        is_allowed: [h, w] pixels that may be walked on.
        focal_px: of the depth image.
        jump_m: largest step in depth at depth 0, metres.
        jump_per_square_m: what is added to it with the square of the depth, 1/m.
        limit_m: longer ways are not followed.
        out_m: [h, w] the cost at which each seed starts, infinity elsewhere; replaced by the
            distances, infinity where there is no way.
    """
    height, width = depth_m.shape
    changed = True
    while changed:
        changed = False
        for backward in range(2):
            step = -1 if backward else 1
            for i in range(height):
                row = height - 1 - i if backward else i
                for j in range(width):
                    column = width - 1 - j if backward else j
                    if not is_allowed[row, column]:
                        continue
                    z = depth_m[row, column]
                    jump = jump_m + jump_per_square_m * z * z
                    best = out_m[row, column]
                    for k in range(4):
                        # The four neighbours that this sweep has already passed.
                        other_row = row - (step if k < 3 else 0)
                        other_column = column + (k - 1 if k < 3 else -step)
                        if not (0 <= other_row < height and 0 <= other_column < width):
                            continue
                        start = out_m[other_row, other_column]
                        if not start < min(best, limit_m):
                            continue
                        if not is_allowed[other_row, other_column]:
                            continue
                        dz = depth_m[other_row, other_column] - z
                        if abs(dz) > jump:
                            continue
                        across = z / focal_px
                        if k == 0 or k == 2:
                            across *= np.sqrt(2.0)
                        way = np.float32(start + np.sqrt(across * across + dz * dz))
                        if way < best and way <= limit_m:
                            best = way
                    if best < out_m[row, column]:
                        out_m[row, column] = best
                        changed = True
