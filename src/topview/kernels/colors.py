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


@njit(cache=True, nogil=True)
def count_head_and_body(
    color: NDArray[np.uint8],
    stride: int,
    points_camera: NDArray[np.float32],
    body_m: NDArray[np.float32],
    head_camera: tuple[float, float, float],
    head_radius_m: float,
    band_m: tuple[float, float],
    shifts: tuple[int, int, int],
    out_head: NDArray[np.float32],
    out_body: NDArray[np.float32],
) -> tuple[int, int]:
    """Count the colours of a head and of the body below it; gives how many pixels of both.

    Args:
        color: [H, W, 3] RGB.
        stride: pixel (i, j) of the small images has the colour of (i, j) * stride.
        points_camera: [h, w, 3].
        body_m: [h, w] distances from the head, infinity elsewhere.
        head_camera: [3].
        head_radius_m: of a ball about it.
        band_m: what is nearer along the body than the first may be the head, between both the body.
        shifts: of Y, U and V.
        out_head: [a, b, c] is added to, by Y, U and V, `>> shifts`.
        out_body: the same.
    """
    head_x, head_y = np.float32(head_camera[0]), np.float32(head_camera[1])
    head_z, most_m2 = np.float32(head_camera[2]), np.float32(head_radius_m**2)
    from_m, to_m = np.float32(band_m[0]), np.float32(band_m[1])
    heads, bodys = 0, 0
    for row in range(body_m.shape[0]):
        for column in range(body_m.shape[1]):
            along_m = body_m[row, column]
            if not along_m < to_m or along_m == from_m:
                continue
            x = points_camera[row, column, 0] - head_x
            y = points_camera[row, column, 1] - head_y
            z = points_camera[row, column, 2] - head_z
            is_below = along_m > from_m
            if not is_below and not x * x + y * y + z * z < most_m2:
                continue
            rgb = color[row * stride, column * stride]
            luma, u, v = yuv_of(int(rgb[0]), int(rgb[1]), int(rgb[2]))
            counts = out_body if is_below else out_head
            counts[luma >> shifts[0], u >> shifts[1], v >> shifts[2]] += np.float32(1.0)
            heads, bodys = heads + (not is_below), bodys + is_below
    return heads, bodys


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
