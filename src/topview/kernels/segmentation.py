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
    queue: NDArray[np.int32],
    is_queued: NDArray[np.bool_],
    out_m: NDArray[np.float32],
) -> None:
    """Length of the shortest way over the surface to each pixel, in place.

    Steps go to the 8 neighbours. A step is as long as the two points are apart, and is taken only
    where both are allowed and their depths differ by at most `jump_m + jump_per_square_m * z^2`,
    z the nearer depth. Pixels whose distance has become shorter wait in a queue until they have
    told their neighbours; the result does not depend on the order.

    Args:
        depth_m: [h, w] metres.
        is_allowed: [h, w] pixels that may be walked on.
        focal_px: of the depth image.
        jump_m: largest step in depth at depth 0, metres.
        jump_per_square_m: what is added to it with the square of the depth, 1/m.
        limit_m: longer ways are not followed.
        queue: [h * w] scratch.
        is_queued: [h, w] scratch, all False.
        out_m: [h, w] the cost at which each seed starts, infinity elsewhere; replaced by the
            distances, infinity where there is no way.
    """
    height, width = depth_m.shape
    size = height * width
    head, count = 0, 0
    for row in range(height):
        for column in range(width):
            if out_m[row, column] <= limit_m and is_allowed[row, column]:
                queue[count] = row * width + column
                is_queued[row, column] = True
                count += 1
    while count > 0:
        pixel = queue[head]
        head = head + 1 if head + 1 < size else 0
        count -= 1
        row, column = pixel // width, pixel % width
        is_queued[row, column] = False
        z = depth_m[row, column]
        start = out_m[row, column]
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(column - 1, 0), min(column + 2, width)):
                if not is_allowed[i, j] or not start < out_m[i, j]:
                    continue
                dz = depth_m[i, j] - z
                nearer = min(z, depth_m[i, j])
                if abs(dz) > jump_m + jump_per_square_m * nearer * nearer:
                    continue
                across = nearer / focal_px
                square = across * across * ((i != row) + (j != column))
                way = np.float32(start + np.sqrt(square + dz * dz))
                if way < out_m[i, j] and way <= limit_m:
                    out_m[i, j] = way
                    if not is_queued[i, j]:
                        is_queued[i, j] = True
                        tail = head + count
                        queue[tail if tail < size else tail - size] = i * width + j
                        count += 1
