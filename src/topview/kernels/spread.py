"""Of many places some that are far from each other."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(error_model="numpy")
def _away(places, i, other):
    """How far one of [N, K] places is from [K] another."""
    squared = 0.0
    for k in range(places.shape[1]):
        d = places[i, k] - other[k]
        squared += d * d
    return np.sqrt(squared)


@njit(cache=True, error_model="numpy", nogil=True)
def farthest_first(places, start, taken):
    """Fill `taken` [n] with indices of [N, K] places, n at most N: each next one is the farthest
    from `start` [K] and from those already taken, the first of several."""
    N = places.shape[0]
    distance = np.empty(N)
    for i in range(N):
        distance[i] = _away(places, i, start)
    for n in range(taken.shape[0]):
        farthest = 0
        for i in range(N):
            if distance[i] > distance[farthest]:
                farthest = i
        taken[n] = farthest
        for i in range(N):
            distance[i] = min(distance[i], _away(places, i, places[farthest]))


@njit(cache=True, error_model="numpy", nogil=True)
def cheapest_apart(costs, places, apart, chosen):
    """Fill `chosen` [n] with indices of [N, K] places, the cheapest first, each farther than
    `apart` from those before it; returns how many there are.

    Args:
        costs: [N] finite; of equal ones the first is taken.
    """
    N = costs.shape[0]
    is_left = np.ones(N, np.bool_)
    for n in range(chosen.shape[0]):
        cheapest = -1
        for i in range(N):
            if is_left[i] and (cheapest < 0 or costs[i] < costs[cheapest]):
                cheapest = i
        if cheapest < 0:
            return n
        chosen[n] = cheapest
        for i in range(N):
            is_left[i] &= _away(places, i, places[cheapest]) > apart
    return chosen.shape[0]
