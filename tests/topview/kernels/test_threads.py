"""Dealing rows to threads: each row once, whatever the number of threads."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_array_equal

from topview.kernels.threads import over_threads, use_threads


@over_threads("counts")
@njit(nogil=True)
def count_up(first_row, row_step, counts, row_count):
    for row in range(first_row, row_count, row_step):
        counts[row] += row + 1


@over_threads("row_count")
@njit(nogil=True)
def count_up_to(first_row, row_step, counts, row_count):
    for row in range(first_row, row_count, row_step):
        counts[row] += row + 1


@pytest.fixture(params=[1, 2, 0])
def threads(request):
    use_threads(request.param)
    yield
    use_threads(0)


@pytest.mark.parametrize("kernel", [count_up, count_up_to])
@pytest.mark.parametrize("rows", [0, 1, 2, 7])
def test_every_row_is_done_once(threads, kernel, rows):
    counts = np.zeros(rows, np.int64)
    kernel(counts, rows)
    assert_array_equal(counts, np.arange(rows) + 1)


def test_it_deals_no_more_shares_than_threads_or_rows():
    shares = []

    @over_threads("rows")
    def note(first_row, row_step, rows):
        shares.append((first_row, row_step))

    use_threads(1)
    note([0] * 5)
    assert shares == [(0, 1)]
    shares.clear()
    in_use = use_threads(0)
    note([0] * 100)
    assert sorted(shares) == [(share, in_use) for share in range(in_use)]
    shares.clear()
    note([0])
    assert shares == [(0, 1)]


def test_an_error_in_any_share_is_raised():
    @over_threads("rows")
    def fail(first_row, row_step, rows):
        if first_row == row_step - 1:
            raise ValueError("the last share")

    with pytest.raises(ValueError, match="the last share"):
        fail([0] * 5)


def test_the_number_is_that_of_the_calling_thread():
    use_threads(1)
    with ThreadPoolExecutor(1) as other:
        other.submit(use_threads, 0).result()
    shares = []

    @over_threads("rows")
    def note(first_row, row_step, rows):
        shares.append(first_row)

    note([0] * 5)
    use_threads(0)
    assert shares == [0]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.skipif(sys.version_info >= (3, 12), reason="forking with threads warns")
def test_a_forked_process_has_threads_of_its_own():
    counts = np.zeros(7, np.int64)
    count_up(counts, 7)
    child = os.fork()
    if child == 0:
        counts[:] = 0
        count_up(counts, 7)
        os._exit(0 if (counts == np.arange(7) + 1).all() else 1)
    assert os.waitpid(child, 0)[1] == 0
