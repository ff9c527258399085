"""Skin in an image: levels by a table, connected regions, and the forms of blobs of pixels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.colors import yuv_of
from topview.kernels.medians import median
from topview.kernels.noise import Law, law_at


@njit(inline="always", nogil=True)
def _mean(upper: NDArray[np.uint8], lower: NDArray[np.uint8], place: int, step: int) -> int:
    """Of a channel of two pixels beside each other and the two below them, as `cv2.resize` has it
    (`INTER_AREA`); of the first alone if the step is 1."""
    at, beside = np.uint32(place), np.uint32(place + 3)
    if step == 1:
        return int(upper[at])
    return (int(upper[at]) + int(upper[beside]) + int(lower[at]) + int(lower[beside]) + 2) >> 2


@njit(cache=True, nogil=True)
def look_up_levels(
    color: NDArray[np.uint8],
    step: int,
    is_sought: NDArray[np.bool_],
    table: NDArray[np.uint8],
    shift: int,
    dark_level: int,
    out_level: NDArray[np.uint8],
    out_bin: NDArray[np.int32],
    out_counts: NDArray[np.float64],
) -> None:
    """A level of each colour's U and V, 0 where none is sought or Y is below `dark_level`.

    Args:
        color: [h * step, w * step, 3] RGB.
        step: 1, or 2 if the mean of 2 x 2 pixels is a small pixel's colour.
        is_sought: [h, w].
        table: [B, B] by U and V, each `>> shift`.
        shift: see above.
        dark_level: see above.
        out_level: [h, w].
        out_bin: [h, w] flat index into the table where sought, else left alone.
        out_counts: [B * B] how many of those sought fall there are added.
    """
    bins = table.shape[1]
    level_of, rows = table.ravel(), color.reshape(len(color), -1)
    for row in range(is_sought.shape[0]):
        upper, lower = rows[row * step], rows[row * step + step - 1]
        is_wanted, levels, places = is_sought[row], out_level[row], out_bin[row]
        for column in range(len(levels)):
            levels[column] = 0
            if is_wanted[column]:
                first = column * step * 3
                y, u, v = yuv_of(
                    _mean(upper, lower, first, step),
                    _mean(upper, lower, first + 1, step),
                    _mean(upper, lower, first + 2, step),
                )
                place = (u >> shift) * bins + (v >> shift)
                places[column] = place
                out_counts[place] += 1.0
                if y >= dark_level:
                    levels[column] = level_of[place]


@njit(cache=True, nogil=True)
def count_bins(
    pixels: NDArray[np.float32], bin_of: NDArray[np.int32], out_counts: NDArray[np.float64]
) -> None:
    """Add one to `out_counts` [B * B] for each of [N, 2] pixels (x, y), all inside, by its bin in
    [h, w]."""
    for n in range(len(pixels)):
        out_counts[bin_of[int(pixels[n, 1]), int(pixels[n, 0])]] += 1.0


@njit(cache=True, nogil=True)
def widen_mask(
    mask: NDArray[np.bool_], stride: int, mask_stride: int, out: NDArray[np.bool_]
) -> None:
    """[H, W] whether any of the 3 x 3 pixels of a smaller mask [h, w] is, about the one that lies
    there; strides are those of both in the full image."""
    height, width = mask.shape
    columns = np.empty(out.shape[1], np.int32)
    for column in range(len(columns)):
        columns[column] = column * stride // mask_stride
    near, wide = np.empty(width + 2, np.bool_), np.empty(width, np.bool_)
    last = -1
    for row in range(out.shape[0]):
        i = row * stride // mask_stride
        wider, before = out[row], out[max(row - 1, 0)]
        if i == last:
            for column in range(len(columns)):
                wider[column] = before[column]
            continue
        last = i
        upper, middle, lower = mask[max(i - 1, 0)], mask[i], mask[min(i + 1, height - 1)]
        near[0] = near[width + 1] = False
        inside = near[1 : width + 1]
        for j in range(width):
            inside[j] = upper[j] | middle[j] | lower[j]
        left, right = near[:width], near[2:]
        for j in range(width):
            wide[j] = left[j] | inside[j] | right[j]
        for column in range(len(columns)):
            wider[column] = wide[columns[column]]


@njit(cache=True, nogil=True)
def before_background(
    is_candidate: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    nearest_m: NDArray[np.float32],
    out: NDArray[np.bool_],
) -> None:
    """[h, w] which candidates have a reading and are no further away than where the background
    begins."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            z = depth_m[row, column]
            is_before = (z > 0.0) & (z <= nearest_m[row, column])
            out[row, column] = is_candidate[row, column] & is_before


@njit(cache=True, nogil=True)
def cut_at_edges(
    level: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    edge_m: float,
    box: tuple[int, int, int, int],
    out_level: NDArray[np.uint8],
) -> None:
    """[h, w] a level, 0 where there is no reading or depths of the pixel and its 8 neighbours
    differ by more than `edge_m`; inside of a box (left, top, right, bottom; all inside)."""
    height, width = level.shape
    for row in range(box[1], box[3] + 1):
        for column in range(box[0], box[2] + 1):
            if level[row, column] == 0 or depth_m[row, column] == 0.0:
                continue
            nearest_m, farthest_m = depth_m[row, column], depth_m[row, column]
            for i in range(max(row - 1, 0), min(row + 2, height)):
                for j in range(max(column - 1, 0), min(column + 2, width)):
                    nearest_m = min(nearest_m, depth_m[i, j])
                    farthest_m = max(farthest_m, depth_m[i, j])
            if farthest_m - nearest_m <= np.float32(edge_m):
                out_level[row, column] = level[row, column]


@njit(cache=True, nogil=True)
def count_lights(
    color: NDArray[np.uint8],
    step: int,
    every: int,
    dim_level: float,
    clipped_level: int,
) -> tuple[int, int, int, int]:
    """How many pixels are not black; how many of these have a Y below `dim_level`, and how many no
    colour below `clipped_level`; and over how many levels U or V spreads, whichever does more,
    without one pixel in a hundred at each end.

    Args:
        color: [H, W, 3] RGB.
        step: 1, or 2 if the mean of 2 x 2 pixels is a small pixel's colour.
        every: how many of the small pixels in each direction one is looked at for.
        dim_level: see above.
        clipped_level: see above.
    """
    tints = np.zeros((2, 256), np.int64)
    rows = color.reshape(len(color), -1)
    count, dim, clipped = 0, 0, 0
    for row in range(0, color.shape[0] // step, every):
        upper, lower = rows[row * step], rows[row * step + step - 1]
        for column in range(0, color.shape[1] // step, every):
            first = column * step * 3
            red = _mean(upper, lower, first, step)
            green = _mean(upper, lower, first + 1, step)
            blue = _mean(upper, lower, first + 2, step)
            if max(red, max(green, blue)) == 0:
                continue
            y, u, v = yuv_of(red, green, blue)
            count += 1
            dim += y < dim_level
            clipped += min(red, min(green, blue)) >= clipped_level
            tints[0, u] += 1
            tints[1, v] += 1
    rare, spread = count // 100, 0
    for channel in range(2):
        below, low, high = 0, 0, 0
        for level in range(256):
            below += tints[channel, level]
            low += below <= rare
            high += below <= count - 1 - rare
        spread = max(spread, high - low)
    return count, dim, clipped, spread


@njit(cache=True, nogil=True)
def learn_still(
    depth_m: NDArray[np.float32],
    is_somebodys: NDArray[np.bool_],
    elapsed_s: float,
    still_s: float,
    margin: Law,
    out_last_m: NDArray[np.float32],
    out_still_s: NDArray[np.float32],
    out_nearest_m: NDArray[np.float32],
) -> None:
    """Where a frame shows nobody, count for how long the depth has kept still; what has for
    `still_s`, and all that is behind it but for a margin, is the background.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        is_somebodys: [h, w].
        elapsed_s: since the last time.
        still_s: see above.
        margin: by how much the depth of what keeps still may differ.
        out_last_m: [h, w] the depth of the last time, updated.
        out_still_s: [h, w] how long it has kept still, updated.
        out_nearest_m: [h, w] where the background begins, updated.
    """
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            z = depth_m[row, column]
            if z == 0.0 or is_somebodys[row, column]:
                continue
            margin_m = np.float32(law_at(z, margin))
            if abs(z - out_last_m[row, column]) < margin_m:
                out_still_s[row, column] += np.float32(elapsed_s)
            else:
                out_still_s[row, column] = 0.0
            out_last_m[row, column] = z
            if out_still_s[row, column] >= still_s:
                out_nearest_m[row, column] = z - margin_m


@njit(cache=True, nogil=True)
def count_levels(
    level: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    stride: int,
    middle: tuple[float, float],
    radii: tuple[float, float],
    at_m: float,
    off_m: float,
    least_level: int,
) -> tuple[int, int]:
    """How many pixels in an ellipse have a depth that differs from `at_m` by less than `off_m`; and
    how many of them at least a level.

    Args:
        level: [h, w].
        depth_m: [H, W]; the level of (i, j) is that of pixel (i, j) * stride.
        stride: see above.
        middle: of the ellipse: row and column of the levels.
        radii: of the ellipse, down and across.
        at_m: see above.
        off_m: see above.
        least_level: see above.
    """
    height, width = level.shape
    v, u = middle
    down, across = radii
    seen, high = 0, 0
    for row in range(max(int(v - down), 0), min(int(v + down) + 2, height)):
        for column in range(max(int(u - across), 0), min(int(u + across) + 2, width)):
            x, y = (column - u) / across, (row - v) / down
            z = depth_m[row * stride, column * stride]
            if x * x + y * y < 1.0 and abs(z - np.float32(at_m)) < off_m:
                seen += 1
                high += level[row, column] >= least_level
    return seen, high


@njit(cache=True, nogil=True)
def connected_regions(
    level: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    low: int,
    high: int,
    least_pixels: int,
    box: tuple[int, int, int, int],
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int32], NDArray[np.float64]]:
    """Regions of 8-connected pixels above `low`, at least one of them above `high`, in the order of
    their first pixels.

    Args:
        level: [h, w].
        depth_m: [h, w] metres, 0 where there is no reading.
        low: see above.
        high: see above.
        least_pixels: of a region.
        box: left, top, right, bottom, all inside; beyond it no level is above `low`.

    Returns:
        [P, 2] pixels (x, y) of one region after the other; [K + 1] where each region's start, and
        where the last one's end; [K, 4] left, top, right, bottom, all inside; and [K, 8] mean
        level, share of pixels with a reading, median reading (0: none), `moments`.
    """
    height, width = level.shape
    most, wide = 0, width + 2
    # With a border that is never open; what has been visited is not, either.
    is_open, is_above = np.zeros((height + 2) * wide, np.bool_), np.zeros(height, np.bool_)
    for row in range(box[1], box[3] + 1):
        levels, opens, above = level[row], is_open[(row + 1) * wide + 1 :], 0
        for column in range(width):
            opens[column] = levels[column] > low
            above += levels[column] > low
        is_above[row] = above > 0
        most += above
    out_pixels, readings_m = np.empty((most, 2), np.float32), np.empty(most, np.float32)
    queue, regions = np.empty(most, np.int32), most // least_pixels + 1
    out_starts, out_boxes = np.zeros(regions + 1, np.int32), np.empty((regions, 4), np.int32)
    out_means = np.empty((regions, 8))
    count, end = 0, 0
    for first_row in range(box[1], box[3] + 1):
        if not is_above[first_row]:
            continue
        for first_column in range(box[0], box[2] + 1):
            first = (first_row + 1) * wide + first_column + 1
            if not is_open[first]:
                continue
            start = end
            left, top, right, bottom = first_column, first_row, first_column, first_row
            highest, total, readings = 0, 0, 0
            is_open[first], queue[end] = False, first
            end += 1
            at = start
            while at < end:
                place = np.int64(queue[at])
                row, column = place // wide - 1, place % wide - 1
                out_pixels[at, 0], out_pixels[at, 1] = column, row
                at += 1
                left, right, bottom = min(left, column), max(right, column), max(bottom, row)
                highest, total = max(highest, level[row, column]), total + level[row, column]
                if depth_m[row, column] > 0.0:
                    readings_m[readings] = depth_m[row, column]
                    readings += 1
                for middle in (place - wide, place, place + wide):
                    for other in (middle - 1, middle, middle + 1):
                        if is_open[np.uint32(other)]:
                            is_open[np.uint32(other)], queue[end] = False, other
                            end += 1
            size = end - start
            if size < least_pixels or highest <= high:
                end = start
                continue
            out_boxes[count, 0], out_boxes[count, 1] = left, top
            out_boxes[count, 2], out_boxes[count, 3] = right, bottom
            out_means[count, 0], out_means[count, 1] = total / size, readings / size
            out_means[count, 2] = median(readings_m[:readings]) if readings > 0 else 0.0
            _put_moments(out_pixels[start:end], out_means[count, 3:])
            count += 1
            out_starts[count] = end
    return out_pixels, out_starts[: count + 1], out_boxes[:count], out_means[:count]


@njit(cache=True, nogil=True)
def paint(pixels: NDArray[np.float32], value: int, out: NDArray[np.generic]) -> None:
    """Set [h, w] `out` to a value at [N, 2] pixels (x, y), all inside."""
    for n in range(len(pixels)):
        out[int(pixels[n, 1]), int(pixels[n, 0])] = value


@njit(cache=True, nogil=True)
def copy_levels(
    pixels: NDArray[np.float32], level: NDArray[np.uint8], out_level: NDArray[np.uint8]
) -> None:
    """Copy [h, w] levels at [N, 2] pixels (x, y), all inside."""
    for n in range(len(pixels)):
        row, column = int(pixels[n, 1]), int(pixels[n, 0])
        out_level[row, column] = level[row, column]


@njit(cache=True, nogil=True)
def shift_pixels(pixels: NDArray[np.float32], dx: float, dy: float) -> None:
    """Move [N, 2] pixels (x, y)."""
    for n in range(len(pixels)):
        pixels[n, 0] += np.float32(dx)
        pixels[n, 1] += np.float32(dy)


@njit(cache=True, nogil=True)
def move_onto(
    pixels: NDArray[np.float32], dx: float, dy: float, label_of: NDArray[np.int32], labels: int
) -> int:
    """Move [N, 2] pixels (x, y); gives the label, up to `labels`, in [h, w] on which most of them
    land, the lowest of several, 0 where none lands on any."""
    shift_pixels(pixels, dx, dy)
    height, width = label_of.shape
    counts = np.zeros(labels + 1, np.int64)
    for n in range(len(pixels)):
        column, row = int(np.floor(pixels[n, 0] + 0.5)), int(np.floor(pixels[n, 1] + 0.5))
        if 0 <= row < height and 0 <= column < width:
            counts[label_of[row, column]] += 1
    counts[0] = 0
    return int(np.argmax(counts))


@njit(cache=True, error_model="numpy", nogil=True)
def label_inside(
    label_of: NDArray[np.int32],
    labels: int,
    middle: tuple[float, float],
    axes: tuple[float, float],
    along: tuple[float, float],
) -> int:
    """The label, up to `labels`, of which most pixels of [h, w] lie inside an ellipse, the lowest
    of several, 0 where none does.

    Args:
        label_of: 0 where there is no label.
        labels: see above.
        middle: x and y.
        axes: major and minor semi-axis.
        along: the major axis, of length 1.
    """
    height, width = label_of.shape
    # As exact as NumPy is with places of 32 bits.
    x, y = np.float32(middle[0]), np.float32(middle[1])
    major, minor = np.float32(axes[0]), np.float32(axes[1])
    c, s = np.float32(along[0]), np.float32(along[1])
    reach = axes[0] + 1.0
    counts = np.zeros(labels + 1, np.int64)
    for row in range(max(int(middle[1] - reach), 0), min(int(middle[1] + reach) + 1, height)):
        for column in range(max(int(middle[0] - reach), 0), min(int(middle[0] + reach) + 1, width)):
            label = label_of[row, column]
            if label > 0:
                dx, dy = np.float32(column) - x, np.float32(row) - y
                off = np.hypot((c * dx + s * dy) / major, (c * dy - s * dx) / minor)
                counts[label] += off <= np.float32(1.0)
    return int(np.argmax(counts))


@njit(nogil=True)
def moments(pixels: NDArray[np.float32]) -> tuple[float, float, float, float, float]:
    """Means of x and y, and means of the squares and the product of their deviations, of [N, 2]."""
    x = y = 0.0
    for n in range(len(pixels)):
        x += pixels[n, 0]
        y += pixels[n, 1]
    x /= len(pixels)
    y /= len(pixels)
    s_xx = s_yy = s_xy = 0.0
    for n in range(len(pixels)):
        dx, dy = pixels[n, 0] - x, pixels[n, 1] - y
        s_xx += dx * dx
        s_yy += dy * dy
        s_xy += dx * dy
    return x, y, s_xx / len(pixels), s_yy / len(pixels), s_xy / len(pixels)


@njit(nogil=True)
def _put_moments(pixels: NDArray[np.float32], out: NDArray[np.float64]) -> None:
    """Fill [5] with the `moments` of [N, 2]."""
    out[0], out[1], out[2], out[3], out[4] = moments(pixels)


@njit(nogil=True)
def _median_reading(pixels: NDArray[np.float32], depth_m: NDArray[np.float32]) -> float:
    """Of [h, w] depths at [N, 2] pixels (x, y), all inside; 0 where there is none."""
    readings_m = np.empty(len(pixels), np.float32)
    readings = 0
    for n in range(len(pixels)):
        reading_m = depth_m[int(pixels[n, 1]), int(pixels[n, 0])]
        if reading_m > 0.0:
            readings_m[readings] = reading_m
            readings += 1
    return median(readings_m[:readings]) if readings > 0 else 0.0


@njit(nogil=True)
def look_at_end(
    pixels: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    along_x: float,
    along_y: float,
    length_px: float,
) -> tuple[float, float, float]:
    """The end of [N, 2] pixels (x, y) in a direction (of length 1): those less than `length_px`
    from the last.

    Returns:
        x and y of their mean, and the median of their readings in [h, w] `depth_m`, 0 where none
        has one.
    """
    height, width = depth_m.shape
    last = -np.inf
    for n in range(len(pixels)):
        last = max(last, pixels[n, 0] * along_x + pixels[n, 1] * along_y)
    readings_m = np.empty(len(pixels), np.float32)
    x, y, count, readings = 0.0, 0.0, 0, 0
    for n in range(len(pixels)):
        if pixels[n, 0] * along_x + pixels[n, 1] * along_y < last - length_px:
            continue
        x, y, count = x + pixels[n, 0], y + pixels[n, 1], count + 1
        column, row = int(np.floor(pixels[n, 0] + 0.5)), int(np.floor(pixels[n, 1] + 0.5))
        if 0 <= row < height and 0 <= column < width and depth_m[row, column] > 0.0:
            readings_m[readings] = depth_m[row, column]
            readings += 1
    median_m = median(readings_m[:readings]) if readings > 0 else 0.0
    return x / count, y / count, median_m


@njit(cache=True, nogil=True)
def look_at_ends(
    pixels: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    along_x: float,
    along_y: float,
    length_px: float,
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """What `look_at_end` tells of the end against a direction, and of the one along it."""
    return (
        look_at_end(pixels, depth_m, -along_x, -along_y, length_px),
        look_at_end(pixels, depth_m, along_x, along_y, length_px),
    )


@njit(cache=True, nogil=True)
def perimeter(pixels: NDArray[np.float32]) -> float:
    """Length of the outline, holes included, of [N, 2] pixels (x, y), in pixels.

    By the formula of Cauchy and Crofton from the lines of pixels in four directions: right for a
    large disc, and for squares whichever way they are turned, to 11 %.
    """
    left, top = pixels[0, 0], pixels[0, 1]
    right, bottom = left, top
    for n in range(len(pixels)):
        left, right = min(left, pixels[n, 0]), max(right, pixels[n, 0])
        top, bottom = min(top, pixels[n, 1]), max(bottom, pixels[n, 1])
    is_its = np.zeros((int(bottom - top + 0.5) + 3, int(right - left + 0.5) + 3), np.bool_)
    for n in range(len(pixels)):
        is_its[int(pixels[n, 1] - top + 0.5) + 1, int(pixels[n, 0] - left + 0.5) + 1] = True
    straight, diagonal = 0, 0
    for row in range(1, is_its.shape[0] - 1):
        for column in range(1, is_its.shape[1] - 1):
            if not is_its[row, column]:
                continue
            for i in (-1, 1):
                straight += not is_its[row + i, column]
                straight += not is_its[row, column + i]
                diagonal += not is_its[row + i, column + i]
                diagonal += not is_its[row + i, column - i]
    return np.pi / 8.0 * (straight + diagonal / np.sqrt(2.0))


@njit(cache=True, error_model="numpy", nogil=True)
def share_pixels(
    pixels: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    ellipses: NDArray[np.float64],
    depths_m: NDArray[np.float64],
    same_depth_m: float,
) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float64]]:
    """Which pixels belong to which ellipse: to all in which they lie, else to the nearest one; of
    those at a pixel's depth, if there are any.

    Args:
        pixels: [N, 2] (x, y), all inside the image.
        depth_m: [h, w] metres, 0 where there is no reading, which is at every depth.
        ellipses: [K, 5] x, y, major and minor semi-axis, angle.
        depths_m: [K] of the ellipses, 0 where not known, which is at every depth.
        same_depth_m: what differs by less is at the same depth.

    Returns:
        [P, 2] the pixels of one ellipse after the other; [K + 1] where each one's start, and where
        the last one's end; and [K, 7] share of them that are others', too, median reading (0:
        none), `moments`; of those that have any.
    """
    count, size = len(ellipses), len(pixels)
    cosines, sines = np.cos(ellipses[:, 4]), np.sin(ellipses[:, 4])
    x, y, z = np.empty(size, np.float32), np.empty(size, np.float32), np.empty(size, np.float32)
    for n in range(size):
        x[n], y[n] = pixels[n, 0], pixels[n, 1]
        z[n] = depth_m[int(pixels[n, 1]), int(pixels[n, 0])]
    # Ellipse by ellipse without branches, so that several pixels are looked at together.
    squares, is_near = np.empty((count, size)), np.empty((count, size), np.bool_)
    is_any_near, least = np.zeros(size, np.bool_), np.full(size, np.inf)
    for k in range(count):
        square, near, at_m = squares[k], is_near[k], depths_m[k]
        for n in range(size):
            near[n] = (z[n] == 0.0) | (at_m == 0.0) | (abs(z[n] - at_m) < same_depth_m)
            is_any_near[n] |= near[n]
            dx, dy = x[n] - ellipses[k, 0], y[n] - ellipses[k, 1]
            along = (cosines[k] * dx + sines[k] * dy) / ellipses[k, 2]
            across = (cosines[k] * dy - sines[k] * dx) / ellipses[k, 3]
            square[n] = along * along + across * across
    for k in range(count):
        square, near = squares[k], is_near[k]
        for n in range(size):
            square[n] = square[n] if near[n] | (not is_any_near[n]) else np.inf
            least[n] = min(least[n], square[n])
    belongs = np.empty((count, size), np.bool_)
    own, shared = np.zeros(count, np.int64), np.zeros(count)
    for n in range(size):
        claims = 0
        for k in range(count):
            is_first = claims == 0 and squares[k, n] == least[n]
            belongs[k, n] = squares[k, n] <= 1.0 or (least[n] > 1.0 and is_first)
            claims += belongs[k, n]
        for k in range(count):
            own[k] += belongs[k, n]
            shared[k] += belongs[k, n] and claims > 1
    return _gathered(pixels, depth_m, belongs, own, shared)


@njit(nogil=True)
def _gathered(
    pixels: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    belongs: NDArray[np.bool_],
    own: NDArray[np.int64],
    shared: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float64]]:
    """What `share_pixels` gives, of which pixels belong to each, [K, N], how many, [K], and how
    many of these are others', too, [K]."""
    count = len(own)
    starts, values = np.zeros(count + 1, np.int64), np.zeros((count, 7))
    out_pixels = np.empty((own.sum(), 2), np.float32)
    at = 0
    for k in range(count):
        starts[k] = at
        for n in range(len(pixels)):
            if belongs[k, n]:
                out_pixels[at, 0], out_pixels[at, 1] = pixels[n, 0], pixels[n, 1]
                at += 1
        if own[k] > 0:
            its = out_pixels[starts[k] : at]
            values[k, 0], values[k, 1] = shared[k] / own[k], _median_reading(its, depth_m)
            _put_moments(its, values[k, 2:])
    starts[count] = at
    return out_pixels, starts, values


@njit(cache=True, nogil=True)
def multiply_shares(
    values: NDArray[np.float64],
    ranges: NDArray[np.float64],
    columns: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Multiply for each row of [N, F] values what tables say of those that are known.

    Args:
        values: NaN where not known.
        ranges: [F, 3] of the tables: from, to, bins of the same width; values beyond fall into the
            outermost bin.
        columns: [F, B, K] the tables.
        out: [N, K] is filled.
    """
    out[:] = 1.0
    for n in range(len(values)):
        for f in range(len(ranges)):
            low, high, bins = ranges[f]
            place = (values[n, f] - low) / (high - low) * bins
            if not np.isnan(place):
                column = columns[f, int(min(max(place, 0.0), bins - 1.0))]
                for k in range(len(column)):
                    out[n, k] *= column[k]


@njit(cache=True, nogil=True)
def nearest_within(
    points: NDArray[np.float64], others: NDArray[np.float64], reach_m: float
) -> NDArray[np.int64]:
    """For each of [N, 3] points the index of the nearest of [K, 3] others, -1 where none is within
    reach."""
    nearest = np.empty(len(points), np.int64)
    for n in range(len(points)):
        nearest[n], least_m = -1, np.inf
        for k in range(len(others)):
            x, y = points[n, 0] - others[k, 0], points[n, 1] - others[k, 1]
            z = points[n, 2] - others[k, 2]
            away_m = np.sqrt(x * x + y * y + z * z)
            if away_m < min(least_m, reach_m):
                nearest[n], least_m = k, away_m
    return nearest


@njit(cache=True, error_model="numpy", nogil=True)
def mix_levels(
    trained: NDArray[np.float64],
    skin: NDArray[np.float64],
    seen: NDArray[np.float64],
    weight: float,
    out_level: NDArray[np.uint8],
) -> None:
    """[B, B] levels of 255: the trained probability of each colour, and that of the last frames,
    which counts the rest of the weight.

    Args:
        trained: [B, B].
        skin: [B, B] how many pixels of skin had the colour. The trained probability weighs as much
            as one pixel, against chance.
        seen: [B, B] how many pixels had it.
        weight: of the trained probability, 0 to 1.
        out_level: [B, B] is filled.
    """
    for row in range(trained.shape[0]):
        for column in range(trained.shape[1]):
            before = trained[row, column]
            recent = min((skin[row, column] + before) / (seen[row, column] + 1.0), 1.0)
            mixed = weight * before + (1.0 - weight) * recent
            out_level[row, column] = np.uint8(np.rint(255.0 * mixed))
