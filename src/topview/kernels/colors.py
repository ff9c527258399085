"""What colours tell of a head that is known."""

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


@njit(cache=True, nogil=True)
def color_shares(
    color: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    stride: int,
    pixel: tuple[int, int],
    radius_px: int,
    about_px: int,
    counts: NDArray[np.float32],
    other_counts: NDArray[np.float32],
    shifts: tuple[int, int, int],
    rare: float,
    at_m: float,
    off_m: float,
) -> NDArray[np.float32]:
    """[n, n] for the pixels about one, `n = 2 * radius_px + 1`: whether the colours around each are
    one histogram's (1) or another's (0).

    The mean over `2 * about_px + 1` pixels in both directions; the image goes on beyond its border
    as it is there.

    Args:
        color: [H, W, 3] RGB.
        depth_m: [h, w]; pixel (i, j) has the colour of (i, j) * stride.
        stride: see above.
        pixel: row and column of the middle one.
        radius_px: see above.
        about_px: see above.
        counts: [a, b, c] share of each Y, U and V, `>> shifts`.
        other_counts: the other histogram.
        shifts: see above.
        rare: added to both.
        at_m: a depth that differs from this by more than
        off_m: is no evidence, which is 0.5.
    """
    height, width = depth_m.shape
    reach = radius_px + about_px
    shares = np.empty((2 * reach + 1, 2 * reach + 1), np.float32)
    for i in range(2 * reach + 1):
        row = min(max(pixel[0] + i - reach, 0), height - 1)
        for j in range(2 * reach + 1):
            column = min(max(pixel[1] + j - reach, 0), width - 1)
            shares[i, j] = np.float32(0.5)
            if abs(depth_m[row, column] - np.float32(at_m)) <= off_m:
                rgb = color[row * stride, column * stride]
                y, u, v = yuv_of(int(rgb[0]), int(rgb[1]), int(rgb[2]))
                bins = y >> shifts[0], u >> shifts[1], v >> shifts[2]
                own = counts[bins] + np.float32(rare)
                shares[i, j] = own / (own + (other_counts[bins] + np.float32(rare)))
    side, around = 2 * radius_px + 1, 2 * about_px + 1
    means = np.empty((side, side), np.float32)
    for i in range(side):
        for j in range(side):
            total = 0.0
            for k in range(i, i + around):
                for m in range(j, j + around):
                    total += shares[k, m]
            means[i, j] = total * (1.0 / around**2)
    return means
