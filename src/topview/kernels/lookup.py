"""Distances to many entries of a table, of which some of what would be seen is hidden.

An entry's descriptor is a sum of axes, by its components; its distance from what is seen, over what
is not hidden, is a quadratic form of these. Sums run in one order, whatever library or number of
threads numpy uses.
"""

from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 256  # entries that are looked at together, so that they stay in the cache


@njit(cache=True, error_model="numpy", nogil=True)
def project(seen, is_hidden, axes, gram, place):
    """Fill what of the axes is not hidden: their products [C, C] with each other, and [C] those
    with what is seen.

    Args:
        seen, is_hidden: [F] and [F] bool.
        axes: [F, C] orthonormal.
        gram, place: filled.
    """
    C = axes.shape[1]
    for c in range(C):
        place[c] = np.float32(0.0)
        for e in range(C):
            gram[c, e] = np.float32(1.0 if c == e else 0.0)
    for f in range(seen.shape[0]):
        if is_hidden[f]:
            for c in range(C):
                for e in range(c + 1):
                    gram[c, e] -= axes[f, c] * axes[f, e]
        else:
            for c in range(C):
                place[c] += axes[f, c] * seen[f]


@njit(cache=True, error_model="numpy", nogil=True)
def squared_distances(entries, gram, place, squares):
    """Fill [N] squared distances of [C, N] entries from what is seen, up to a constant.

    Args:
        entries: components, float32.
        gram, place: of `project`; of `gram` the lower triangle.
        squares: float32.
    """
    C, N = entries.shape
    two = np.float32(2.0)
    sums = np.empty(BLOCK, np.float32)
    for start in range(0, N, BLOCK):
        stop = min(start + BLOCK, N)
        total, added = squares[start:stop], sums[: stop - start]
        total[:] = np.float32(0.0)
        for c in range(C):
            own = entries[c, start:stop]  # slices, so that the loops over them are vectorised
            for i in range(len(own)):
                added[i] = gram[c, c] * own[i] - two * place[c]
            for e in range(c):
                weight = two * gram[c, e]
                if weight == 0.0:
                    continue
                other = entries[e, start:stop]
                for i in range(len(own)):
                    added[i] += weight * other[i]
            for i in range(len(own)):
                total[i] += own[i] * added[i]


@njit(cache=True, error_model="numpy", nogil=True)
def squares_of_nearest(entries, counts, wanted, lowest, squares):
    """Fill [M] the mean squared distance of each [M, C] wanted place from the K nearest of [C, N]
    entries, each coordinate counting as much as [C] says; all float32.

    Args:
        entries, counts, wanted: these.
        lowest: [K] that are overwritten.
        squares: filled.
    """
    C, N = entries.shape
    last = lowest.shape[0] - 1
    sums = np.empty(BLOCK, np.float32)
    for m in range(wanted.shape[0]):
        lowest[:] = np.float32(np.inf)
        for start in range(0, N, BLOCK):
            stop = min(start + BLOCK, N)
            total = sums[: stop - start]
            total[:] = np.float32(0.0)
            for c in range(C):
                own, place, count = entries[c, start:stop], wanted[m, c], counts[c]
                for i in range(len(own)):
                    off = own[i] - place
                    total[i] += count * off * off
            for i in range(len(total)):
                if total[i] < lowest[last]:
                    k = last
                    while k > 0 and lowest[k - 1] > total[i]:
                        lowest[k] = lowest[k - 1]
                        k -= 1
                    lowest[k] = total[i]
        squares[m] = lowest.mean()
