"""Loose pieces of a depth image, and which of them touch a body."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def fill_at(pixels: NDArray[np.int32], value: int, out: NDArray[np.generic]) -> None:
    """Set [H, W] `out` to a value at flat pixels."""
    flat = out.ravel()
    for n in range(len(pixels)):
        flat[pixels[n]] = value


@njit(nogil=True)
def _label(
    pixels: NDArray[np.int64],
    is_diagonal: bool,
    queue: NDArray[np.int32],
    out_labels: NDArray[np.int32],
) -> int:
    """Number the pieces that hang together, by 8 neighbours or by 4, from 1 on in the order of
    their first pixels; gives how many numbers there are, 0 included.

    Args:
        pixels: [N] flat indices, ascending, of the pieces' pixels.
        is_diagonal: whether by 8 neighbours.
        queue: [N] scratch.
        out_labels: [h, w] becomes the number of each pixel's piece, 0 for none.
    """
    height, width = out_labels.shape
    waits = np.int32(-1)
    labels = out_labels.ravel()
    labels[:] = 0
    for k in range(len(pixels)):
        labels[pixels[k]] = waits
    count = 1
    for k in range(len(pixels)):
        if labels[pixels[k]] != waits:
            continue
        labels[pixels[k]] = count
        queue[0] = pixels[k]
        at, end = 0, 1
        while at < end:
            row, column = queue[at] // width, queue[at] % width
            at += 1
            for i in range(max(row - 1, 0), min(row + 2, height)):
                for j in range(max(column - 1, 0), min(column + 2, width)):
                    is_beside = is_diagonal or i == row or j == column
                    if is_beside and labels[i * width + j] == waits:
                        labels[i * width + j] = count
                        queue[end] = i * width + j
                        end += 1
        count += 1
    return count


@njit(cache=True, nogil=True)
def clusters_of(
    standing_px: NDArray[np.int64],
    is_somebodys: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    focal_px: float,
    step_m: float,
    out_labels: NDArray[np.int32],
) -> NDArray[np.float64]:
    """[K] areas of what hangs together by 4 neighbours, number 0, which is nothing, included.

    Args:
        standing_px: flat indices, ascending, of the pixels among which they are sought; none is one
            whose depth differs by `step_m` or more from that of the left or the upper pixel.
        is_somebodys: [h, w] no cluster's.
        depth_m: [h, w].
        focal_px: of the depth image.
        step_m: see above.
        out_labels: [h, w] becomes the number of each pixel's cluster, 0 for none.
    """
    width = depth_m.shape[1]
    z_of, is_owned = depth_m.ravel(), is_somebodys.ravel()
    pixels = np.empty(len(standing_px), np.int64)
    count = 0
    for k in range(len(standing_px)):
        pixel = standing_px[k]
        if is_owned[pixel]:
            continue
        left = pixel - 1 if pixel % width > 0 else pixel
        upper = pixel - width if pixel >= width else pixel
        is_even = abs(z_of[pixel] - z_of[left]) < step_m
        if is_even and abs(z_of[pixel] - z_of[upper]) < step_m:
            pixels[count] = pixel
            count += 1
    pixels = pixels[:count]
    areas_m2 = np.zeros(_label(pixels, False, np.empty(count, np.int32), out_labels))
    labels = out_labels.ravel()
    for k in range(count):
        side_m = z_of[pixels[k]] / np.float32(focal_px)
        areas_m2[labels[pixels[k]]] += side_m * side_m
    return areas_m2


@njit(cache=True, nogil=True)
def small_pieces(
    standing_px: NDArray[np.int64],
    is_somebodys: NDArray[np.bool_],
    is_bulky: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    focal_px: float,
    least_m2: float,
    most_m2: float,
    out_labels: NDArray[np.int32],
) -> tuple[NDArray[np.int32], int]:
    """Flat indices, ascending, of the pixels of all pieces, which hang together by 8 neighbours,
    whose area lies between the two; and how many numbers there are, 0 included.

    Args:
        standing_px: flat indices, ascending, of the pixels among which they are sought.
        is_somebodys: [h, w] no piece's.
        is_bulky: [h, w] no piece's.
        depth_m: [h, w].
        focal_px: of the depth image.
        least_m2: see above.
        most_m2: see above.
        out_labels: [h, w] number of each pixel's piece, whatever its size, 0 for none.
    """
    is_owned, is_bulk = is_somebodys.ravel(), is_bulky.ravel()
    pixels = np.empty(len(standing_px), np.int64)
    loose = 0
    for k in range(len(standing_px)):
        pixel = standing_px[k]
        pixels[loose] = pixel
        loose += not (is_owned[pixel] or is_bulk[pixel])
    loose_px, queue = pixels[:loose], np.empty(loose, np.int32)
    count = _label(loose_px, True, queue, out_labels)
    area_m2, z_of, labels = np.zeros(count), depth_m.ravel(), out_labels.ravel()
    for k in range(len(loose_px)):
        pixel = loose_px[k]
        side_m = z_of[pixel] / focal_px
        area_m2[labels[pixel]] += side_m * side_m
    kept = 0
    for k in range(len(loose_px)):
        pixel = loose_px[k]
        if least_m2 < area_m2[labels[pixel]] < most_m2:
            queue[kept] = pixel
            kept += 1
    return queue[:kept].copy(), count


@njit(cache=True, nogil=True)
def join_pieces(
    pixels: NDArray[np.int32],
    labels: NDArray[np.int32],
    count: int,
    depth_m: NDArray[np.float32],
    points_camera: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    head_camera: NDArray[np.float32],
    reach_m: float,
    gap_m: float,
    lowest_m: float,
    out_body_m: NDArray[np.float32],
) -> None:
    """Add to a body the pieces before and behind it that touch it and are near enough to its head.

    A piece touches where one of its pixels is nearer than the mean of the body's among its 8
    neighbours, by up to `gap_m`; or farther by up to that, if all of the piece is higher than
    `lowest_m`. Pixels of the piece are as far from the head as the straight line.

    Args:
        pixels: flat indices of the pieces' pixels.
        labels: [h, w] number of each pixel's piece, 0 for none.
        count: of numbers, 0 included.
        depth_m: [h, w].
        points_camera: [h, w, 3].
        heights_m: [h, w] along up.
        head_camera: [3] the head's centre.
        reach_m: a piece that has a pixel further from the head is none of its.
        gap_m, lowest_m: see above.
        out_body_m: [h, w] the body's distances from the head, infinity elsewhere.
    """
    height, width = depth_m.shape
    is_before, is_behind = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    is_too_far, is_low = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
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
        if heights_m[row, column] <= lowest_m:
            is_low[label] = True
        if is_before[label] or is_too_far[label]:
            continue
        around_m, bodys = 0.0, 0
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(column - 1, 0), min(column + 2, width)):
                if out_body_m[i, j] < np.inf:
                    around_m += depth_m[i, j]
                    bodys += 1
        if bodys and abs(z - around_m / bodys) < gap_m:
            is_before[label] |= z < around_m / bodys
            is_behind[label] |= z >= around_m / bodys
    for index in range(len(pixels)):
        row, column = pixels[index] // width, pixels[index] % width
        label = labels[row, column]
        touches = is_before[label] or (is_behind[label] and not is_low[label])
        if touches and not is_too_far[label]:
            out_body_m[row, column] = from_head_m[index]
