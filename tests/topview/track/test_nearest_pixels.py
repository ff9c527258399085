"""Which of a user's pixels is nearest to a place in the image."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from topview.kernels.body import nearest_own
from topview.track.evidence import NearestPixels

SEEDS = st.integers(0, 10_000)


def masks(seed: int) -> tuple[np.ndarray, tuple[int, int, int, int]]:
    """[H, W] somebody's pixels, and the box round them."""
    rng = np.random.default_rng(seed)
    height, width = rng.integers(20, 70, 2)
    mask = np.zeros((height, width), np.bool_)
    row, column = rng.integers(0, height - 10), rng.integers(0, width - 10)
    block = np.s_[row : row + rng.integers(4, 30), column : column + rng.integers(4, 30)]
    mask[block] = rng.random(mask[block].shape) < rng.uniform(0.005, 0.9)
    mask[row, column] = True
    rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    return mask, (int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)


@given(SEEDS)
def test_no_pixel_is_nearer_than_the_one_that_is_told(seed: int) -> None:
    mask, box = masks(seed)
    nearest = NearestPixels.of(mask, *box)
    own = np.argwhere(mask)
    rng = np.random.default_rng(seed)
    places = rng.integers((0, 0), mask.shape, (50, 2))
    for place in places.tolist():
        found = nearest_own(nearest.columns, nearest.corner, *place)
        assert mask[found]
        assert ((np.array(found) - place) ** 2).sum() == ((own - place) ** 2).sum(1).min()


def test_of_no_pixels_none_is_nearest() -> None:
    nearest = NearestPixels.of(np.zeros((4, 5), np.bool_), 4, 0, 5, 0)
    assert nearest_own(nearest.columns, nearest.corner, 3, 2) == (-1, -1)
