"""Which hypotheses are the parents of new ones."""

from __future__ import annotations

from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def resample(weights, start, out):
    """Fill `out` [M] with parents in proportion to their weights.

    Args:
        weights: [N], sums to one.
        start: 0 to 1, from where on the M places are equally spaced.
    """
    parent, reached, count = 0, weights[0], out.shape[0]
    for m in range(count):
        place = (start + m) / count
        while parent < weights.shape[0] - 1 and reached < place:
            parent += 1
            reached += weights[parent]
        out[m] = parent
