"""What a body that was found measures."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at


@njit(cache=True, nogil=True)
def share_within(
    plan_m: NDArray[np.float32],
    is_body: NDArray[np.bool_],
    right_m: float,
    forward_m: float,
    radius_m: float,
) -> float:
    """Share of a body's pixels [h, w] that are nearer than `radius_m` to a place, seen from above
    (`plan_m`, [2, h, w]); NaN if it has none."""
    height, width = is_body.shape
    pixels, within = 0, 0
    for row in range(height):
        rights_m, forwards_m, is_own = plan_m[0, row], plan_m[1, row], is_body[row]
        # Without branches, so that several pixels are looked at together.
        for column in range(width):
            right, forward = rights_m[column] - right_m, forwards_m[column] - forward_m
            is_near = right * right + forward * forward < radius_m * radius_m
            pixels += is_own[column]
            within += is_own[column] & is_near
    return within / pixels if pixels else np.nan


@njit(cache=True, nogil=True)
def lowest_of(
    is_body: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    before_m: float,
) -> float:
    """Height of a body's lowest pixels [h, w]; NaN where they are cut off, by the picture's border
    or by what is nearer by more than `before_m` in the two rows below them."""
    height, width = is_body.shape
    last = height - 1
    while last >= 0 and not is_body[last].any():
        last -= 1
    if last < 0 or last + 2 >= height:
        return np.nan
    lowest_m = np.float32(np.inf)
    for column in range(width):
        if is_body[last, column]:
            lowest_m = min(lowest_m, heights_m[last, column])
            hides_m = depth_m[last, column] - np.float32(before_m)
            for row in (last + 1, last + 2):
                if 0.0 < depth_m[row, column] < hides_m:
                    return np.nan
    return float(lowest_m)


@njit(cache=True, nogil=True)
def measure_body(
    standing_px: NDArray[np.int64],
    body_m: NDArray[np.float32],
    nearest_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    plan_m: NDArray[np.float32],
    inset_m: NDArray[np.float32],
    focal_px: float,
    head: tuple[float, float, float],
    over_m: float,
    aside_m: float,
    reaches_m: tuple[float, float],
    chest_m: tuple[float, float],
    head_m: tuple[float, float],
    least_pixels: int,
    edge: Law,
) -> tuple[float, float, float, float, float, float, float, float, float, float, float]:
    """What of a body is nobody else's measures; metres and square metres.

    Args:
        standing_px: flat indices, ascending, of pixels among which the body's are.
        body_m: [h, w] distance of each of its pixels from the head, infinity elsewhere.
        nearest_m: [h, w] that from the nearest of others' heads; nearer ones are somebody else's.
        depth_m: [h, w].
        heights_m: [h, w] along up.
        plan_m: [2, h, w] seen from above: to the right and forward.
        inset_m: [h, w] how far each pixel is from what surrounds its surface.
        focal_px: of the depth image.
        head: its place to the right and forward, and the height of its top.
        over_m: what is higher than this over the top is above it.
        aside_m: what is nearer to the head, seen from above, is near.
        reaches_m: what is nearer to the head along the surface is the bust; bust and torso.
        chest_m: band of heights below the top, from and to.
        head_m: another one.
        least_pixels: fewer have no relief.
        edge: on an edge is what has no reading, or differs from the left or the upper pixel's depth
            by more than this law says.

    Returns:
        Areas of all, of what is above the head and of the bust; the lowest height; how many of the
        bust's pixels lie on edges, over the root of all; how far the innermost pixel of bust and
        torso is from what surrounds it; the share that is near; the mean breadths of chest and
        head; the share of the body's pixels that is its own; and the relief of bust and torso: the
        standard deviation from the plane that fits best, of means of 3 x 3 pixels. The inverse of
        the depth is linear over a plane's image. The outline is left out.
    """
    height, width = depth_m.shape
    area_m2, above_m2, bust_m2, chest_m2, head_m2 = 0.0, 0.0, 0.0, 0.0, 0.0
    lowest_m, radius_m = np.inf, 0.0
    edges, bust, near, own, pixels = 0, 0, 0, 0, 0
    top, bottom, left, right = height, -1, width, -1
    from_head_of, nearest_of = body_m.ravel(), nearest_m.ravel()
    for k in range(len(standing_px)):
        pixel = int(standing_px[k])
        from_head_m = from_head_of[pixel]
        if from_head_m == np.inf:
            continue
        pixels += 1
        if nearest_of[pixel] < from_head_m:
            continue
        own += 1
        row, column = int(pixel // width), int(pixel % width)
        z = depth_m[row, column]
        pixel_m2 = (z / focal_px) ** 2
        area_m2 += pixel_m2
        lowest_m = min(lowest_m, heights_m[row, column])
        below_m = head[2] - heights_m[row, column]
        above_m2 += pixel_m2 * (-below_m > over_m)
        chest_m2 += pixel_m2 * (chest_m[0] < below_m < chest_m[1])
        head_m2 += pixel_m2 * (head_m[0] < below_m < head_m[1])
        right_m = plan_m[0, row, column] - head[0]
        forward_m = plan_m[1, row, column] - head[1]
        near += right_m * right_m + forward_m * forward_m < aside_m * aside_m
        if from_head_m < reaches_m[1]:
            radius_m = max(radius_m, inset_m[row, column])
            top, bottom = min(top, row), row
            left, right = min(left, column), max(right, column)
        if from_head_m < reaches_m[0]:
            bust_m2 += pixel_m2
            bust += 1
            jump_m = law_at(z, edge)
            left_m, upper_m = depth_m[row, max(column - 1, 0)], depth_m[max(row - 1, 0), column]
            edges += (z == 0.0) | (abs(z - left_m) > jump_m) | (abs(z - upper_m) > jump_m)
    relief_m = 0.0
    if bottom > top + 1 and right > left + 1:
        window = slice(top, bottom + 1), slice(left, right + 1)
        relief_m = _relief(
            body_m[window], nearest_m[window], depth_m[window], reaches_m[1], least_pixels
        )
    return (
        area_m2,
        above_m2,
        bust_m2,
        lowest_m,
        edges / np.sqrt(max(bust, 1)),
        radius_m,
        near / max(own, 1),
        chest_m2 / (chest_m[1] - chest_m[0]),
        head_m2 / (head_m[1] - head_m[0]),
        own / max(pixels, 1),
        relief_m,
    )


@njit(nogil=True)
def _relief(
    body_m: NDArray[np.float32],
    nearest_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    reach_m: float,
    least_pixels: int,
) -> float:
    """The last number of `measure_body`, of a window that holds all that is nearer."""
    height, width = depth_m.shape
    is_inner = np.zeros((height, width), np.bool_)
    count, sum_u, sum_v, sum_y = 0, 0.0, 0.0, 0.0
    for v in range(1, height - 1):
        for u in range(1, width - 1):
            is_all = True
            for i in range(v - 1, v + 2):
                for j in range(u - 1, u + 2):
                    is_all &= (body_m[i, j] < reach_m) & (nearest_m[i, j] >= body_m[i, j])
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
