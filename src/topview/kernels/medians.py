"""Medians of scratch arrays: `np.median` would take over a second to compile, for each type."""

from __future__ import annotations

from numba import njit
from numpy.typing import NDArray


@njit(nogil=True)
def median(values: NDArray) -> float:
    """Of [N] numbers, N > 0, which are left in another order (Wirth's selection)."""
    middle = len(values) // 2
    low, high = 0, len(values) - 1
    while low < high:
        pivot = values[middle]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if j < middle:
            low = i
        if middle < i:
            high = j
    upper = values[middle]
    if len(values) % 2 == 1:
        return float(upper)
    lower = values[0]
    for i in range(1, middle):
        lower = max(lower, values[i])
    return float(lower + upper) / 2.0
