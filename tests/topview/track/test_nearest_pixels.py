"""Which of a user's pixels is nearest: a window round the user tells what the whole image would."""

from __future__ import annotations

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

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
    mask[block] = rng.random(mask[block].shape) < rng.uniform(0.05, 0.9)
    mask[row, column] = True
    rows, columns = np.nonzero(mask)
    return mask, (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1)


def nearest_of_all(mask: np.ndarray) -> np.ndarray:
    """[H, W] by the whole image."""
    _, labels = cv2.distanceTransformWithLabels(
        (~mask).view(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    pixels = np.flatnonzero(mask)
    index_of = np.zeros(len(pixels) + 1, np.int32)
    labels = np.asarray(labels, np.int32)
    index_of[labels.ravel()[pixels]] = pixels
    return index_of[labels]


@given(SEEDS, st.integers(0, 20))
def test_a_window_tells_what_the_whole_image_would(seed: int, margin: int) -> None:
    mask, box = masks(seed)
    nearest = NearestPixels.of(mask, *box, margin)
    (top, left), (height, width) = nearest.corner, nearest.flat.shape
    whole = nearest_of_all(mask)
    assert_array_equal(nearest.flat, whole[top : top + height, left : left + width])
    for row, column in ((0, 0), (mask.shape[0] - 1, mask.shape[1] - 1), (box[0], box[2])):
        inside = np.clip(row, top, top + height - 1), np.clip(column, left, left + width - 1)
        assert nearest_own(nearest.flat, nearest.corner, row, column) == whole[inside]


def test_of_no_pixels_none_is_nearest() -> None:
    nearest = NearestPixels.of(np.zeros((4, 5), np.bool_), 4, 0, 5, 0, 3)
    assert nearest_own(nearest.flat, nearest.corner, 3, 2) == -1
