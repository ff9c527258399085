"""One assignment of rows to columns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def assign(scores: NDArray[np.float64], unmatched: float = 0.0) -> dict[int, int]:
    """Row to column of the assignment with the highest sum of [rows, columns] scores; pairs whose
    score is -inf are never made, but count as `unmatched`."""
    if not scores.size or not np.isfinite(scores).any():
        return {}
    from scipy.optimize import linear_sum_assignment  # slow; not before it is needed

    is_pair = np.isfinite(scores)
    rows, columns = linear_sum_assignment(np.where(is_pair, scores, unmatched), maximize=True)
    return {
        int(row): int(column)
        for row, column in zip(rows, columns, strict=True)
        if is_pair[row, column]
    }
