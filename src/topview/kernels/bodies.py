"""What a body that was found measures."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at


@njit(cache=True, nogil=True)
def share_within(
    overview_m: NDArray[np.float32],
    is_body: NDArray[np.bool_],
    right_m: float,
    forward_m: float,
    radius_m: float,
) -> float:
    """Share of a body's pixels [h, w] that are nearer than `radius_m` to a place, seen from above
    (`overview_m`, [h, w, 2]); NaN if it has none."""
    height, width = is_body.shape
    pixels, within = 0, 0
    for row in range(height):
        for column in range(width):
            if is_body[row, column]:
                right = overview_m[row, column, 0] - right_m
                forward = overview_m[row, column, 1] - forward_m
                pixels += 1
                within += right * right + forward * forward < radius_m * radius_m
    return within / pixels if pixels else np.nan


@njit(cache=True, nogil=True)
def measure_body(
    distance_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    inset_m: NDArray[np.float32],
    focal_px: float,
    above_m: float,
    bust_m: float,
    torso_m: float,
    edge: Law,
) -> tuple[float, float, float, float, float, float]:
    """Areas of a body, of what of it is higher than `above_m` and of the bust, in square metres;
    its lowest height; how many of the bust's pixels lie on edges, over the root of all; and how
    far the innermost pixel of bust and torso is from what surrounds it.

    Args:
        distance_m: [h, w] of each of its pixels from the head, infinity elsewhere.
        depth_m: [h, w].
        heights_m: [h, w] along up.
        inset_m: [h, w] how far each pixel is from what surrounds its surface.
        focal_px: of the depth image.
        above_m: see above.
        bust_m: nearer to the head is the bust.
        torso_m: nearer to the head are bust and torso.
        edge: on an edge is what has no reading, or differs from the left or the upper pixel's depth
            by more than this law says.
    """
    height, width = depth_m.shape
    area_m2, over_m2, bust_m2, lowest_m, radius_m = 0.0, 0.0, 0.0, np.inf, 0.0
    edges, pixels = 0, 0
    for row in range(height):
        for column in range(width):
            if distance_m[row, column] == np.inf:
                continue
            z = depth_m[row, column]
            pixel_m2 = (z / focal_px) ** 2
            area_m2 += pixel_m2
            lowest_m = min(lowest_m, heights_m[row, column])
            if heights_m[row, column] > above_m:
                over_m2 += pixel_m2
            if distance_m[row, column] < torso_m:
                radius_m = max(radius_m, inset_m[row, column])
            if distance_m[row, column] < bust_m:
                bust_m2 += pixel_m2
                pixels += 1
                jump_m = law_at(z, edge)
                left_m, upper_m = depth_m[row, max(column - 1, 0)], depth_m[max(row - 1, 0), column]
                edges += (z == 0.0) | (abs(z - left_m) > jump_m) | (abs(z - upper_m) > jump_m)
    return area_m2, over_m2, bust_m2, lowest_m, edges / np.sqrt(max(pixels, 1)), radius_m


@njit(cache=True, nogil=True)
def measure_shape(
    distance_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    focal_px: float,
    top_m: float,
    chest_m: tuple[float, float],
    head_m: tuple[float, float],
    reach_m: float,
    least_pixels: int,
) -> tuple[float, float, float]:
    """How broad somebody's chest and head are, and how far they are from a plane.

    Args:
        distance_m: [h, w] over the body from the head's centre, infinite where it is not the body.
        depth_m: [h, w] metres.
        heights_m: [h, w] along up.
        focal_px: of the image.
        top_m: height of the head's top.
        chest_m: from where to where below the top the chest is, ends left out.
        head_m: the same of the head.
        reach_m: what is nearer than this to the head's centre is looked at for its relief.
        least_pixels: fewer have none.

    Returns:
        Mean breadths of chest and head, metres; and the standard deviation from the plane that fits
        best, metres, of means of 3 x 3 pixels. The inverse of the depth is linear over a plane's
        image. The outline is left out.
    """
    height, width = depth_m.shape
    chest_m2, head_m2 = 0.0, 0.0
    top, bottom, left, right = height, -1, width, -1
    for row in range(height):
        for column in range(width):
            if distance_m[row, column] == np.inf:
                continue
            below_m = top_m - heights_m[row, column]
            pixel_m2 = (depth_m[row, column] / focal_px) ** 2
            if chest_m[0] < below_m < chest_m[1]:
                chest_m2 += pixel_m2
            if head_m[0] < below_m < head_m[1]:
                head_m2 += pixel_m2
            if distance_m[row, column] < reach_m:
                top, bottom = min(top, row), row
                left, right = min(left, column), max(right, column)
    relief_m = 0.0
    if bottom > top + 1 and right > left + 1:
        relief_m = _relief(
            distance_m[top : bottom + 1, left : right + 1],
            depth_m[top : bottom + 1, left : right + 1],
            reach_m,
            least_pixels,
        )
    return chest_m2 / (chest_m[1] - chest_m[0]), head_m2 / (head_m[1] - head_m[0]), relief_m


@njit(nogil=True)
def _relief(
    distance_m: NDArray[np.float32], depth_m: NDArray[np.float32], reach_m: float, least_pixels: int
) -> float:
    """The third number of `measure_shape`, of a window that holds all that is nearer."""
    height, width = depth_m.shape
    is_inner = np.zeros((height, width), np.bool_)
    count, sum_u, sum_v, sum_y = 0, 0.0, 0.0, 0.0
    for v in range(1, height - 1):
        for u in range(1, width - 1):
            is_all = True
            for i in range(v - 1, v + 2):
                for j in range(u - 1, u + 2):
                    is_all &= distance_m[i, j] < reach_m
            if is_all:
                is_inner[v, u] = True
                count += 1
                sum_u += u
                sum_v += v
                sum_y += 1.0 / np.float64(depth_m[v, u])
    if count < least_pixels:
        return 0.0
    mean_u, mean_v, mean_y = sum_u / count, sum_v / count, sum_y / count
    uu, uv, vv, uy, vy = 0.0, 0.0, 0.0, 0.0, 0.0
    for v in range(1, height - 1):
        for u in range(1, width - 1):
            if is_inner[v, u]:
                du, dv = u - mean_u, v - mean_v
                dy = 1.0 / np.float64(depth_m[v, u]) - mean_y
                uu, uv, vv = uu + du * du, uv + du * dv, vv + dv * dv
                uy, vy = uy + du * dy, vy + dv * dy
    # Pixels in a single row or column, or along a diagonal, have no slope across.
    across = vv - uv * uv / uu if uu > 0.0 else vv
    slope_v = (vy - uv * uy / uu if uu > 0.0 else vy) / across if across > 1e-9 * vv else 0.0
    slope_u = (uy - slope_v * uv) / uu if uu > 0.0 else 0.0
    off_m = np.zeros((height, width))
    for v in range(1, height - 1):
        for u in range(1, width - 1):
            if is_inner[v, u]:
                z = np.float64(depth_m[v, u])
                plane = mean_y + slope_u * (u - mean_u) + slope_v * (v - mean_v)
                off_m[v, u] = (1.0 / z - plane) * z * z
    total, squares = 0.0, 0.0
    for v in range(1, height - 1):
        for u in range(1, width - 1):
            if is_inner[v, u]:
                near, off = 0, 0.0
                for i in range(v - 1, v + 2):
                    for j in range(u - 1, u + 2):
                        near += is_inner[i, j]
                        off += off_m[i, j]
                total += off / near
                squares += (off / near) ** 2
    mean = total / count
    return np.sqrt(max(squares / count - mean * mean, 0.0))
