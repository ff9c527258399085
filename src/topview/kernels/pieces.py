"""Loose pieces of a depth image, and which of them touch a body."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def small_pieces(
    labels: NDArray[np.int32],
    depth_m: NDArray[np.float32],
    count: int,
    focal_px: float,
    least_m2: float,
    most_m2: float,
) -> NDArray[np.int32]:
    """Flat indices, ascending, of the pixels of all pieces whose area lies between the two.

    Args:
        labels: [h, w] number of each pixel's piece, 0 for none.
        depth_m: [h, w].
        count: of numbers, 0 included.
        focal_px: of the depth image.
        least_m2: see above.
        most_m2: see above.
    """
    height, width = labels.shape
    area_m2 = np.zeros(count)
    pixels = np.empty(height * width, np.int32)
    number = 0
    for row in range(height):
        for column in range(width):
            label = labels[row, column]
            if label > 0:
                side_m = depth_m[row, column] / focal_px
                area_m2[label] += side_m * side_m
                pixels[number] = row * width + column
                number += 1
    kept = 0
    for index in range(number):
        pixel = pixels[index]
        if least_m2 < area_m2[labels[pixel // width, pixel % width]] < most_m2:
            pixels[kept] = pixel
            kept += 1
    return pixels[:kept].copy()


@njit(cache=True, nogil=True)
def join_pieces(
    pixels: NDArray[np.int32],
    labels: NDArray[np.int32],
    count: int,
    depth_m: NDArray[np.float32],
    points_camera: NDArray[np.float32],
    head_camera: NDArray[np.float32],
    reach_m: float,
    gap_m: float,
    out_body_m: NDArray[np.float32],
) -> None:
    """Add to a body the pieces before it that touch it and are near enough to its head.

    A piece touches where one of its pixels is nearer than the mean of the body's among its 8
    neighbours, by up to `gap_m`. Pixels of the piece are as far from the head as the straight
    line.

    Args:
        pixels: flat indices of the pieces' pixels.
        labels: [h, w] number of each pixel's piece, 0 for none.
        count: of numbers, 0 included.
        depth_m: [h, w].
        points_camera: [h, w, 3].
        head_camera: [3] the head's centre.
        reach_m: a piece that has a pixel further from the head is none of its.
        gap_m: see above.
        out_body_m: [h, w] the body's distances from the head, infinity elsewhere.
    """
    height, width = depth_m.shape
    touches = np.zeros(count, np.bool_)
    is_too_far = np.zeros(count, np.bool_)
    from_head_m = np.empty(len(pixels), np.float32)
    for index in range(len(pixels)):
        row, column = pixels[index] // width, pixels[index] % width
        label, z = labels[row, column], depth_m[row, column]
        x_off = points_camera[row, column, 0] - head_camera[0]
        y_off = points_camera[row, column, 1] - head_camera[1]
        z_off = points_camera[row, column, 2] - head_camera[2]
        from_head_m[index] = np.sqrt(x_off * x_off + y_off * y_off + z_off * z_off)
        if from_head_m[index] > reach_m:
            is_too_far[label] = True
        if touches[label] or is_too_far[label]:
            continue
        around_m, bodys = 0.0, 0
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(column - 1, 0), min(column + 2, width)):
                if out_body_m[i, j] < np.inf:
                    around_m += depth_m[i, j]
                    bodys += 1
        if bodys and around_m / bodys - gap_m < z < around_m / bodys:
            touches[label] = True
    for index in range(len(pixels)):
        row, column = pixels[index] // width, pixels[index] % width
        label = labels[row, column]
        if touches[label] and not is_too_far[label]:
            out_body_m[row, column] = from_head_m[index]
