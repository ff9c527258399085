"""How many threads the kernels use."""

from __future__ import annotations

import numba


def use_threads(count: int) -> int:
    """Set the number of threads of every kernel called from this thread, 0 for all cores; gives
    the number in use. No result depends on it."""
    cores: int = numba.config.NUMBA_NUM_THREADS  # pyright: ignore - numba sets it at run time
    count = min(count or cores, cores)
    numba.set_num_threads(count)
    return count
