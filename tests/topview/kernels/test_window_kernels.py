"""One person's pixels, counted, placed and cut out, against NumPy."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from topview.camera.pyramid import DepthView, thinned
from topview.detect.joints.windows import NO_READING, WINDOW_PIXELS, encode, picked_pixels
from topview.kernels.windows import count_own, fill_window, own_points

SEEDS = st.integers(0, 10_000)
FARTHEST_M = 60.0


def scene(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """[H, W] metres with holes, and whose each pixel is: 0 to 2."""
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(20, 60, 2))
    depth_m = rng.uniform(0.5, 70.0, shape) * (rng.random(shape) < 0.9)
    return depth_m.astype(np.float32), rng.integers(0, 3, shape).astype(np.int32)


@given(SEEDS, st.integers(1, 3))
def test_own_points_are_those_of_the_thinned_image(seed: int, stride: int) -> None:
    depth_m, labels = scene(seed)
    pixels = np.flatnonzero(labels > 0).astype(np.int32)  # some may be somebody else's, too
    view = DepthView(thinned(depth_m, stride), 50.0, 51.0, 20.3, 14.8)
    mask = np.zeros(view.depth_m.shape, np.bool_)
    points, thin_pixels = np.empty((len(pixels), 3)), np.empty(len(pixels), np.int32)
    count, median_m, *box = own_points(
        pixels, labels, 1, view.depth_m, stride, (view.fx, view.fy, view.cx, view.cy), mask, points,
        thin_pixels,
    )  # fmt: skip
    expected = (labels[::stride, ::stride] == 1) & (view.depth_m > 0.0)
    rows, columns = np.nonzero(expected)
    assert_array_equal(mask, expected)
    assert_array_equal(points[:count], view.points(rows, columns))
    assert_array_equal(thin_pixels[:count], np.flatnonzero(expected))
    assert median_m == np.median(points[:count, 2])
    assert box == [rows.min(), rows.max() + 1, columns.min(), columns.max() + 1]


def test_nobody_has_no_points() -> None:
    depth_m, labels = scene(0)
    mask = np.zeros(depth_m.shape, np.bool_)
    nothing = np.empty(0, np.int32)
    count, median_m, top, bottom, _, _ = own_points(
        nothing, labels, 3, thinned(depth_m, 1), 1, (50.0, 50.0, 20.0, 15.0), mask,
        np.empty((0, 3)), np.empty(0, np.int32),
    )  # fmt: skip
    assert (count, median_m) == (0, 1.0)
    assert bottom <= top
    assert not mask.any()


@given(SEEDS)
def test_own_pixels_are_counted(seed: int) -> None:
    depth_m, labels = scene(seed)
    height, width = labels.shape
    in_columns, in_rows = np.zeros(width, np.int32), np.zeros(height, np.int32)
    median_mm = count_own(depth_m, labels, 2, FARTHEST_M, in_columns, in_rows)
    is_own = (labels == 2) & (depth_m > 0.0)
    assert_array_equal(in_columns, is_own.sum(0))
    assert_array_equal(in_rows, is_own.sum(1))
    readings_m = np.minimum(depth_m[is_own], np.float32(FARTHEST_M))
    assert median_mm == np.median(np.rint(readings_m * np.float32(1000.0)).astype(np.float64))


@given(SEEDS)
def test_a_window_is_what_its_definition_says(seed: int) -> None:
    depth_m, labels = scene(seed)
    rng = np.random.default_rng(seed)
    rows, columns = (np.sort(rng.integers(-9, 69, WINDOW_PIXELS)) for _ in range(2))
    middle_m, half_m = rng.uniform(0.5, 60.0), rng.uniform(0.7, 1.2)
    expected, window = np.empty((2, 3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
    seen_m, owners = picked_pixels(depth_m, labels, rows[:, None], columns[None])
    encode(seen_m, owners, 1, middle_m, half_m, expected)
    fill_window(depth_m, labels, rows, columns, 1, middle_m, half_m, NO_READING, window)
    assert_array_equal(window, expected)
