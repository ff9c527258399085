"""One person's pixels: where they are, their points, and what a window round them shows."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.medians import median


@njit(cache=True, nogil=True)
def own_points(
    pixels: NDArray[np.int32],
    labels: NDArray[np.int32],
    person: int,
    depth_m: NDArray[np.float32],
    stride: int,
    intrinsics: tuple[float, float, float, float],
    out_is_own: NDArray[np.bool_],
    out_points_camera: NDArray[np.float64],
    out_pixels: NDArray[np.int32],
) -> tuple[int, float, int, int, int, int]:
    """The points of those of somebody's pixels that are in the thinned image.

    Args:
        pixels: [N] flat indices into the full image.
        labels: [H, W] id of the person that each full pixel belongs to.
        person: id; the others' pixels do not count.
        depth_m: [h, w] metres, every `stride`-th pixel of every `stride`-th row; those without a
            reading, 0, do not count.
        stride: see above.
        intrinsics: fx, fy, cx and cy of the thinned image.
        out_is_own: [h, w] all False, set at the pixels that count.
        out_points_camera: [N, 3] metres, in the order of the pixels; the first A are filled.
        out_pixels: [N] flat indices into the thinned image, in the same way.

    Returns:
        A; the median of their depths, 1 of none; the first of their rows, the one after the last,
        the first of their columns, and the one after the last.
    """
    fx, fy, cx, cy = intrinsics
    height, width = depth_m.shape
    full_width = labels.shape[1]
    depths_m = np.empty(len(pixels))
    count = 0
    top, bottom, left, right = height, 0, width, 0
    for pixel in pixels:
        full_row, full_column = pixel // full_width, pixel % full_width
        if full_row % stride or full_column % stride or labels[full_row, full_column] != person:
            continue
        row, column = full_row // stride, full_column // stride
        z = np.float64(depth_m[row, column])
        if not z > 0.0 or out_is_own[row, column]:
            continue
        out_is_own[row, column] = True
        out_points_camera[count, 0] = (column - cx) * z / fx
        out_points_camera[count, 1] = (row - cy) * z / fy
        out_points_camera[count, 2] = depths_m[count] = z
        out_pixels[count] = row * width + column
        top, bottom = min(top, row), max(bottom, row + 1)
        left, right = min(left, column), max(right, column + 1)
        count += 1
    median_m = median(depths_m[:count]) if count > 0 else 1.0
    return count, median_m, top, bottom, left, right


@njit(cache=True, nogil=True)
def count_own(
    depth_m: NDArray[np.float32],
    labels: NDArray[np.int32],
    person: int,
    farthest_m: float,
    out_in_columns: NDArray[np.int32],
    out_in_rows: NDArray[np.int32],
) -> float:
    """Count somebody's pixels that have a reading, and give the median of these readings in whole
    millimetres, 0 of none.

    Args:
        depth_m: [H, W] metres, 0 without a reading.
        labels: [H, W] id of the person that each pixel belongs to.
        person: id.
        farthest_m: what is farther counts as so far.
        out_in_columns: [W] zeros, becomes how many there are in each column.
        out_in_rows: [H] the same for rows.
    """
    height, width = depth_m.shape
    readings_mm = np.empty(height * width)
    count = 0
    for row in range(height):
        for column in range(width):
            if labels[row, column] != person:
                continue
            z = depth_m[row, column]
            if z > 0.0:
                out_in_columns[column] += 1
                out_in_rows[row] += 1
                readings_mm[count] = np.rint(min(z, np.float32(farthest_m)) * np.float32(1000.0))
                count += 1
    return median(readings_mm[:count]) if count > 0 else 0.0


@njit(cache=True, nogil=True)
def middle_and_reach(counts: NDArray[np.int32], beyond_share: float) -> tuple[float, float]:
    """The median of a set of whole numbers, and how far from it the outermost ones lie.

    Args:
        counts: [N] how often each of 0 to N - 1 is there; not all 0.
        beyond_share: of the numbers, that do not count on each side.
    """
    total = 0
    for count in counts:
        total += count
    beyond = beyond_share * total
    first = last = lower = upper = -1
    up_to = 0
    for number in range(len(counts)):
        up_to += counts[number]
        if first < 0 and up_to > beyond:
            first = number
        if lower < 0 and up_to > (total - 1) // 2:
            lower = number
        if upper < 0 and up_to > total // 2:
            upper = number
        if last < 0 and up_to >= total - beyond:
            last = number
    middle = (lower + upper) / 2.0
    return middle, max(middle - first, last - middle)


@njit(cache=True, nogil=True)
def fill_window(
    depth_m: NDArray[np.float32],
    labels: NDArray[np.int32],
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    person: int,
    middle_m: float,
    half_m: float,
    no_reading: float,
    out: NDArray[np.float32],
) -> None:
    """Fill one window; the definition is `picked_pixels` and `encode` of
    `topview.detect.joints.windows`.

    Args:
        depth_m, labels: as above.
        rows: [n] of the image.
        columns: [n] of the image; they may lie outside of it, as rows may.
        person: id.
        middle_m: depth of the box's middle.
        half_m: from there to the box's front and back.
        no_reading: the depth where nothing was read.
        out: [3, n, n] depth, own pixels, those of others.
    """
    height, width = depth_m.shape
    for i in range(len(rows)):
        row = rows[i]
        for j in range(len(columns)):
            column = columns[j]
            is_inside = 0 <= row < height and 0 <= column < width
            z = depth_m[row, column] if is_inside else np.float32(0.0)
            owner = labels[row, column] if z > 0.0 else 0
            offset = min(max((z - middle_m) / half_m, -1.0), 1.0)
            out[0, i, j] = offset if z > 0.0 else no_reading
            out[1, i, j] = 1.0 if z > 0.0 and owner == person else 0.0
            out[2, i, j] = 1.0 if owner != 0 and owner != person else 0.0


@njit(cache=True, nogil=True)
def distances_to_cover(
    image: NDArray[np.float32],
    middle: NDArray[np.float64],
    half_m: float,
    intrinsics: tuple[float, float, float, float],
    points_camera: NDArray[np.float64],
    aside: float,
    out_m: NDArray[np.float64],
) -> None:
    """How far points are from what one window shows of other people nearer to the camera.

    Args:
        image: [3, n, n] as `fill_window` fills it.
        middle: [3] column, row and depth in metres of the box's middle.
        half_m: from there to the box's sides, front and back.
        intrinsics: fx, fy, cx and cy.
        points_camera: [K, 3] metres.
        aside: how many times ways to the side, up and down count.
        out_m: [K] becomes the distance to the nearest pixel's point that is less deep; infinite of
            none.
    """
    fx, fy, cx, cy = intrinsics
    n = image.shape[1]
    across = half_m / middle[2]
    out_m[:] = np.inf
    for i in range(n):
        ray_y = (middle[1] - cy) / fy + ((2 * i + 1) / n - 1.0) * across
        for j in range(n):
            offset = image[0, i, j]
            if image[2, i, j] == 0.0 or abs(offset) >= 1.0:
                continue
            z = middle[2] + offset * half_m
            x = ((middle[0] - cx) / fx + ((2 * j + 1) / n - 1.0) * across) * z
            y = ray_y * z
            for k in range(len(out_m)):
                dz = points_camera[k, 2] - z
                if dz > 0.0:
                    dx, dy = aside * (points_camera[k, 0] - x), aside * (points_camera[k, 1] - y)
                    out_m[k] = min(out_m[k], dx * dx + dy * dy + dz * dz)
    for k in range(len(out_m)):
        out_m[k] = np.sqrt(out_m[k])


@njit(cache=True, nogil=True)
def nearest_in_rows(is_own: NDArray[np.bool_], top: int, left: int, out: NDArray[np.int32]) -> None:
    """Fill a window with the columns of the nearest own pixels in the same rows.

    Args:
        is_own: [H, W] the whole image.
        top, left: row and column of the window's first pixel.
        out: [h, w] column in the image of the nearest own pixel of the window in each pixel's row,
            the left one of two; -1 where the row has none.
    """
    height, width = out.shape
    for i in range(height):
        own = is_own[top + i]
        last = -1
        for j in range(width):
            if own[left + j]:
                last = left + j
            out[i, j] = last
        following = -1
        for j in range(width - 1, -1, -1):
            column = left + j
            if own[column]:
                following = column
            if following >= 0 and (out[i, j] < 0 or following - column < column - out[i, j]):
                out[i, j] = following
