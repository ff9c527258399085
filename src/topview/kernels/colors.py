"""Colours: how they are told, and those of clothes."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(nogil=True)
def yuv_of(red: int, green: int, blue: int) -> tuple[int, int, int]:
    """Y, U and V of 8-bit colours, as `cv2.cvtColor` has them (ITU-R BT.601, in 1/2^14)."""
    y = (4899 * red + 9617 * green + 1868 * blue + 8192) >> 14
    u = (8061 * (blue - y) + 8192 >> 14) + 128
    v = (14369 * (red - y) + 8192 >> 14) + 128
    return y, min(max(u, 0), 255), min(max(v, 0), 255)


@njit(cache=True, error_model="numpy", nogil=True)
def count_clothes(
    color: NDArray[np.uint8],
    stride: int,
    depth_m: NDArray[np.float32],
    plan_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    box: tuple[int, int, int, int],
    heads_plan_m: NDArray[np.float64],
    height_m: float,
    below_m: tuple[float, float],
    aside_m: float,
    out_counts: NDArray[np.float32],
) -> int:
    """Count the colours under a head; gives how many pixels.

    Args:
        color: [H, W, 3] RGB.
        stride: pixel (i, j) of the small images has the colour of (i, j) * stride.
        depth_m: [h, w], 0 where there is no reading.
        plan_m: [2, h, w] seen from above.
        heights_m: [h, w] along up.
        box: left, top, right, bottom; the last two outside.
        heads_plan_m: [K, 2] heads seen from above, its own first; what is nearer to another does
            not count.
        height_m: of the head.
        below_m: from and to.
        aside_m: at most, seen from above.
        out_counts: [a, b, c] is added to, by lightness and the shares of red and green.
    """
    steps = out_counts.shape
    count = 0
    for row in range(box[1], box[3]):
        for column in range(box[0], box[2]):
            under_m = np.float32(height_m) - heights_m[row, column]
            is_chest = np.float32(below_m[0]) < under_m < np.float32(below_m[1])
            if not is_chest or depth_m[row, column] == 0.0:
                continue
            right, forward = plan_m[0, row, column], plan_m[1, row, column]
            off_m = np.hypot(right - heads_plan_m[0, 0], forward - heads_plan_m[0, 1])
            is_own = off_m < aside_m
            for k in range(1, len(heads_plan_m)):
                other_m = np.hypot(right - heads_plan_m[k, 0], forward - heads_plan_m[k, 1])
                is_own &= off_m <= other_m
            if not is_own:
                continue
            rgb = color[row * stride, column * stride]
            total = np.float32(rgb[0]) + np.float32(rgb[1]) + np.float32(rgb[2]) + np.float32(1.0)
            lightness = int(total / np.float32(3.0) * (steps[0] / 256.0))
            red = int(np.float32(rgb[0]) / total * float(steps[1]))
            green = int(np.float32(rgb[1]) / total * float(steps[2]))
            out_counts[lightness, red, green] += np.float32(1.0)
            count += 1
    return count
