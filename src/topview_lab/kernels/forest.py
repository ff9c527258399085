"""Decision forests on depth differences: growing trees, classifying pixels, modes of votes.

J. Shotton et al., "Real-time human pose recognition in parts from single depth images", CVPR 2011.
Depth images here hold one person: `BACKGROUND_M` wherever there is anything or anybody else. The
feature is their Eq. 1 with offsets in metres at the pixel's own depth, so that neither distance nor
focal length matters. Counts are whole numbers and each task has its own, so that no result depends
on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.threads import over_threads

# "A large positive constant" (Shotton et al.): beyond any reading.
BACKGROUND_M = np.float32(10.0)
# Differences are counted in bins that grow with the square of their distance from zero (ours): the
# thresholds are 0, +-4, 16, 35 mm ... 1 m; what differs by more is background.
HALF_BINS = 16
THRESHOLD_BINS = 2 * HALF_BINS
RANGE_M = np.float32(1.0)


@njit(error_model="numpy", forceinline=True)
def _look(depths, first, width, height, u, v):
    inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    return depths[first + v * width + u] if inside else BACKGROUND_M


@njit(error_model="numpy", forceinline=True)
def _difference(depths, first, width, height, u, v, px_per_m, py_per_m, o):
    half = np.float32(0.5)
    a = _look(
        depths, first, width, height,
        u + int(np.floor(o[0] * px_per_m + half)), v + int(np.floor(o[1] * py_per_m + half)),
    )  # fmt: skip
    b = _look(
        depths, first, width, height,
        u + int(np.floor(o[2] * px_per_m + half)), v + int(np.floor(o[3] * py_per_m + half)),
    )  # fmt: skip
    return a - b


@njit(error_model="numpy", forceinline=True)
def _bin(difference):
    """0 .. THRESHOLD_BINS - 1; a difference exceeds `threshold_m(b)` if its bin is above b."""
    size = min(abs(difference) / RANGE_M, np.float32(0.999))
    step = int(np.sqrt(size) * np.float32(HALF_BINS))
    return HALF_BINS + step if difference > 0 else HALF_BINS - 1 - step


def threshold_m(bins):
    """The upper ends of bins, metres."""
    step = (np.asarray(bins, np.int64) + 1 - HALF_BINS) / HALF_BINS
    return (np.sign(step) * step**2 * float(RANGE_M)).astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def differences(depths, crops, image, u, v, choice, offsets, fx, fy, out):
    """Fill `out` [S] with the depth difference of each sample, metres.

    Args:
        depths: float32, all images one after the other.
        crops: [I, 3] int64 first place in `depths`, width and height of each.
        image, u, v: [S] int32 which image, column and row.
        choice: [S] int32 which of the offsets.
        offsets: [C, 4] float32 (x, y) of both probes, metres.
        fx, fy: float32 focal lengths in pixels.
    """
    for s in range(len(image)):
        first, width, height = crops[image[s]]
        d = depths[first + v[s] * width + u[s]]
        out[s] = _difference(
            depths, first, width, height, u[s], v[s], fx / d, fy / d, offsets[choice[s]]
        )


@over_threads("offsets")
@njit(cache=True, nogil=True, error_model="numpy")
def best_splits(
    first_row, row_step,
    depths, crops, image, u, v, label, nodes, offsets, fx, fy, block, least, most, n_log_n,
    gain, choice,
):  # fmt: skip
    """The best of many splits of every node of a level, by information gain.

    Args:
        depths, crops, image, u, v, offsets, fx, fy: as for `differences`, samples node by node.
        label: [S] uint8 class of each sample.
        nodes: [N + 1] int64 where each node's samples begin.
        block: how many offsets a task tries, a divisor of C.
        least: samples that each side must keep.
        most: samples of a node that are judged by, evenly chosen.
        n_log_n: float64 table of 0 to `most`.
        gain: [N, C / block] out, nats times samples; -inf where nothing can be split.
        choice: [N, C / block] int32 out, offset * THRESHOLD_BINS + bin, to the right what is above
            the bin.
    """
    n_nodes = len(nodes) - 1
    n_classes = int(label.max()) + 1
    for task in range(first_row, n_nodes * gain.shape[1], row_step):
        node, b = task % n_nodes, task // n_nodes
        start, stop = nodes[node], nodes[node + 1]
        gain[node, b] = -np.inf
        if stop - start < 2 * least:
            continue
        counts = np.zeros((block, THRESHOLD_BINS, n_classes), np.int32)
        total = np.zeros(n_classes, np.int32)
        step = -(-(stop - start) // most)
        for s in range(start, stop, step):
            first, width, height = crops[image[s]]
            d = depths[first + v[s] * width + u[s]]
            px_per_m, py_per_m = fx / d, fy / d
            total[label[s]] += 1
            for c in range(block):
                value = _difference(
                    depths, first, width, height, u[s], v[s], px_per_m, py_per_m,
                    offsets[b * block + c],
                )  # fmt: skip
                counts[c, _bin(value), label[s]] += 1
        present = np.flatnonzero(total)
        n = total.sum()
        whole = -n_log_n[n]
        for k in present:
            whole += n_log_n[total[k]]
        left = np.empty(n_classes, np.int32)
        best, best_choice = -np.inf, 0
        for c in range(block):
            left[:] = 0
            n_left = 0
            for i in range(THRESHOLD_BINS - 1):
                added = 0
                for k in present:
                    left[k] += counts[c, i, k]
                    added += counts[c, i, k]
                n_left += added
                if added == 0 or n_left < least or n - n_left < least:
                    continue
                value = -n_log_n[n_left] - n_log_n[n - n_left]
                for k in present:
                    value += n_log_n[left[k]] + n_log_n[total[k] - left[k]]
                if value - whole > best:
                    best, best_choice = value - whole, (b * block + c) * THRESHOLD_BINS + i
        gain[node, b] = best
        choice[node, b] = best_choice


@over_threads("u")
@njit(cache=True, nogil=True, error_model="numpy")
def classify(
    first_row, row_step, depth, u, v, fx, fy, offsets, thresholds, children, roots, leaves, out
):
    """Fill `out` [S, K] float32 with the trees' class probabilities; each row sums to about one.

    Args:
        depth: [H, W] float32 metres, one person before `BACKGROUND_M`.
        u, v: [S] int32.
        fx, fy: float32 focal lengths in pixels.
        offsets, thresholds: [N, 4] and [N] float32 of the nodes, metres.
        children: [N] int32 the left child, with the right one after it; -1 - leaf for a leaf.
        roots: [T] int32.
        leaves: [L, K] uint8, probabilities in 1/255.
    """
    height, width = depth.shape
    depths = depth.ravel()
    share = np.float32(1.0 / (255.0 * len(roots)))
    for s in range(first_row, len(u), row_step):
        d = depths[v[s] * width + u[s]]
        px_per_m, py_per_m = fx / d, fy / d
        out[s] = 0.0
        for root in roots:
            node = root
            while children[node] >= 0:
                value = _difference(
                    depths, 0, width, height, u[s], v[s], px_per_m, py_per_m, offsets[node]
                )
                node = children[node] + int(value > thresholds[node])
            leaf = leaves[-1 - children[node]]
            for k in range(out.shape[1]):
                out[s, k] += share * leaf[k]


@njit(cache=True, nogil=True, error_model="numpy")
def find_modes(points, weights, bandwidth_m, iterations, out):
    """Modes of a weighted density with Gaussian windows exp(-|x - x_i|^2 / b^2), by mean shift
    (D. Comaniciu and P. Meer, PAMI 2002). It starts from the weightiest points that are two
    bandwidths apart.

    Args:
        points: [N, 3] float32 metres.
        weights: [N] float32, all positive.
        bandwidth_m: b.
        iterations: of each start.
        out: [M, 4] float32, places and densities, 0 where there are no more.
    """
    n = len(points)
    is_free = np.ones(n, np.bool_)
    inverse = np.float32(1.0 / (bandwidth_m * bandwidth_m))
    apart = np.float32(4.0 * bandwidth_m * bandwidth_m)
    out[:] = 0.0
    for m in range(len(out)):
        start, most = -1, np.float32(0.0)
        for i in range(n):
            if is_free[i] and weights[i] > most:
                start, most = i, weights[i]
        if start < 0:
            return
        x, y, z = points[start]
        for i in range(n):
            dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
            if dx * dx + dy * dy + dz * dz < apart:
                is_free[i] = False
        density = np.float32(0.0)
        for _ in range(iterations):
            density = np.float32(0.0)
            sx, sy, sz = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for i in range(n):
                dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
                far = (dx * dx + dy * dy + dz * dz) * inverse
                if far < 9.0:
                    w = weights[i] * np.exp(-far)
                    density += w
                    sx += w * points[i, 0]
                    sy += w * points[i, 1]
                    sz += w * points[i, 2]
            x, y, z = sx / density, sy / density, sz / density
        out[m, 0], out[m, 1], out[m, 2], out[m, 3] = x, y, z, density
