"""How many threads the kernels use, and how rows of work are dealt to them.

Kernels are compiled without numba's own `parallel=True`, which makes each compile two to three
times as long: it compiles the loop's body four times over. They release the interpreter's lock
instead, so that Python's threads run them side by side.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import wraps
from inspect import signature
from typing import Any

from numba.core import config


class _InUse(threading.local):
    """Of the thread that calls the kernels."""

    threads = 0


_in_use = _InUse()
_pool: ThreadPoolExecutor | None = None


def use_threads(count: int) -> int:
    """Set the number of threads of every kernel called from this thread, 0 for all cores; gives
    the number in use. No result depends on it."""
    cores: int = config.NUMBA_NUM_THREADS  # pyright: ignore - numba sets it at run time
    _in_use.threads = min(count or cores, cores)
    return _in_use.threads


def over_threads(
    rows: str,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Deal a kernel's rows to the threads: it is called with `first_row` and `row_step`
    before its other arguments, and does the rows `range(first_row, rows, row_step)`.

    A kernel must do each row on its own, so that the result does not depend on the threads.

    Args:
        rows: the argument that says how many rows there are, itself or by its length.
    """

    def decorate(kernel: Callable[..., None]) -> Callable[..., None]:
        place = list(signature(kernel).parameters).index(rows) - 2

        @wraps(kernel, updated=())
        def deal(*arguments: Any) -> None:
            sized = arguments[place]
            count = sized if isinstance(sized, int) else len(sized)
            threads = min(_in_use.threads or use_threads(0), count)
            if threads < 2:
                kernel(0, 1, *arguments)
                return
            pool = _threads()
            others = [
                pool.submit(kernel, first, threads, *arguments) for first in range(1, threads)
            ]
            kernel(0, threads, *arguments)
            for other in others:
                other.result()

        return deal

    return decorate


def _threads() -> ThreadPoolExecutor:
    global _pool
    if _pool is None:
        cores: int = config.NUMBA_NUM_THREADS  # pyright: ignore - numba sets it at run time
        _pool = ThreadPoolExecutor(cores, "topview-kernel")
    return _pool


def _forget_threads() -> None:
    global _pool
    _pool = None


# A forked process has none of its parent's threads.
os.register_at_fork(after_in_child=_forget_threads)
