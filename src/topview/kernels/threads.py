"""How many threads the kernels use."""

from __future__ import annotations

import numba


def use_threads(count: int) -> int:
    """Set the number of threads of every kernel called from this thread, 0 for all cores; gives
    the number in use. No result depends on it."""
    count = min(count or numba.config.NUMBA_NUM_THREADS, numba.config.NUMBA_NUM_THREADS)
    numba.set_num_threads(count)
    return count
