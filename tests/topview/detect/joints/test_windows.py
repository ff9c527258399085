"""Windows: what they show does not depend on where in the image somebody is, nor on the side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.camera.pyramid import DepthView
from topview.detect.joints.windows import (
    BOX_MARGIN_M,
    DEPTH,
    HALF_BOX_M,
    LEAST_HALF_BOX_M,
    LEAST_WINDOW_PIXELS,
    OTHER,
    OWN,
    TIMES_ASIDE,
    WINDOW_PIXELS,
    Windows,
    box_of,
    cut_windows,
    window_pixels,
)
from topview.kernels.windows import middle_and_reach

MIRROR = np.array([-1.0, 1.0, 1.0])
SEEDS = st.integers(0, 10_000)


def scene(seed: int) -> tuple[DepthView, np.ndarray]:
    """Two people of blocks before a wall, with holes; the image's sides are even or odd."""
    rng = np.random.default_rng(seed)
    height, width = rng.integers(50, 90, 2)
    depth_mm = rng.integers(3000, 5000, (height, width))
    labels = np.zeros((height, width), np.int32)
    for person in (1, 2):
        row, column = rng.integers(0, height - 20), rng.integers(0, width - 12)
        block = np.s_[row : row + rng.integers(12, 40), column : column + rng.integers(8, 24)]
        depth_mm[block] = rng.integers(700, 3500) + rng.integers(0, 300, depth_mm[block].shape)
        labels[block] = person
    depth_mm[rng.random(depth_mm.shape) < 0.1] = 0
    depth_m = (depth_mm / 1000.0).astype(np.float32)
    fx, fy = rng.uniform(50.0, 90.0, 2)
    return DepthView(depth_m, fx, fy, width / 2 - 0.5, height / 2 - 0.5), labels


def places(seed: int) -> np.ndarray:
    """[2, 5, 3] in the boxes of two people."""
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (2, 5, 3))


@given(SEEDS, st.integers(0, 9), st.integers(0, 9))
def test_somebody_shifted_by_whole_pixels_shows_the_same(seed: int, right: int, down: int) -> None:
    view, labels = scene(seed)
    pad = ((down, 0), (right, 0))
    moved = DepthView(np.pad(view.depth_m, pad), view.fx, view.fy, view.cx + right, view.cy + down)
    here = cut_windows(view, labels, [1, 2])
    there = cut_windows(moved, np.pad(labels, pad), [1, 2])
    np.testing.assert_array_equal(there.images, here.images)
    assert there.to_camera(places(seed)) == pytest.approx(here.to_camera(places(seed)), abs=1e-12)


@given(SEEDS)
def test_a_mirrored_image_gives_mirrored_windows_and_places(seed: int) -> None:
    view, labels = scene(seed)
    cx = view.depth_m.shape[1] - 1 - view.cx
    mirrored = replace(view, depth_m=np.ascontiguousarray(view.depth_m[:, ::-1]), cx=cx)
    here = cut_windows(view, labels, [1, 2])
    there = cut_windows(mirrored, np.ascontiguousarray(labels[:, ::-1]), [1, 2])
    np.testing.assert_array_equal(there.images, here.images[..., ::-1])
    want = here.to_camera(places(seed)) * MIRROR
    assert there.to_camera(places(seed) * MIRROR) == pytest.approx(want, abs=1e-12)


@given(SEEDS)
def test_the_nearest_of_others_is_the_nearest_of_the_points_that_are_shown(seed: int) -> None:
    view, labels = scene(seed)
    windows = cut_windows(view, labels, [1, 2])
    joints_camera = windows.to_camera(places(seed))
    told_m = windows.to_cover_m(joints_camera)
    steps = (np.arange(WINDOW_PIXELS) + 0.5) * 2.0 / WINDOW_PIXELS - 1.0
    across, down = np.meshgrid(steps, steps)
    for person, image in enumerate(windows.images):
        boxed = np.stack([across, down, image[DEPTH].astype(np.float64)], axis=-1)
        shown = np.tile(boxed, (2, 1, 1, 1))
        points = windows.to_camera(shown)[person]
        others = points[(image[OTHER] > 0.0) & (np.abs(image[DEPTH]) < 1.0)]
        ways = (joints_camera[person][:, None] - others) * (TIMES_ASIDE, TIMES_ASIDE, 1.0)
        distances_m = np.where(ways[..., 2] > 0.0, np.linalg.norm(ways, axis=-1), np.inf)
        want = distances_m.min(axis=1, initial=np.inf)
        assert told_m[person] == pytest.approx(want, abs=1e-9)


def test_only_what_is_looked_at_is_mirrored() -> None:
    view, labels = scene(0)
    here, there = (cut_windows(view, labels, [1, 2], way) for way in (None, [False, True]))
    np.testing.assert_array_equal(there.images, here.images)
    np.testing.assert_array_equal(here.looked_at, here.images)
    np.testing.assert_array_equal(there.looked_at[0], here.images[0])
    np.testing.assert_array_equal(there.looked_at[1], here.images[1, ..., ::-1])


@given(SEEDS)
def test_somebody_further_off_through_a_longer_lens_fills_the_same_box(seed: int) -> None:
    view, labels = scene(seed)
    near = cut_windows(view, labels, [1])
    longer = 1.0 + 1.0 / near.middles[0, 2]
    far_m = np.where(view.depth_m > 0.0, view.depth_m + np.float32(1.0), 0.0)
    lens = longer * view.fx, longer * view.fy, view.cx, view.cy
    far = cut_windows(DepthView(far_m.astype(np.float32), *lens), labels, [1])
    np.testing.assert_array_equal(far.images[:, OWN:], near.images[:, OWN:])
    np.testing.assert_allclose(far.images[:, DEPTH], near.images[:, DEPTH], atol=1e-6)


@given(SEEDS)
def test_each_pixel_shows_what_lies_at_its_place(seed: int) -> None:
    view, labels = scene(seed)
    windows = cut_windows(view, labels, [1, 2])
    centres = (np.arange(WINDOW_PIXELS) + 0.5) * 2.0 / WINDOW_PIXELS - 1.0
    across, down = np.meshgrid(centres, centres)
    points = windows.to_camera(np.stack([across, down, windows.images[0, DEPTH]], axis=-1)[None])[0]
    rows, columns = window_pixels(view, windows.middles[0], windows.halves_m[0])
    is_seen = (np.abs(windows.images[0, DEPTH]) < 1.0) & windows.is_used[0]
    x, y, z = points[is_seen].T
    row, column = (np.broadcast_to(at, is_seen.shape)[is_seen] for at in (rows, columns))
    assert np.abs(view.fx * x / z + view.cx - column).max(initial=0.0) < 0.5 + 1e-9
    assert np.abs(view.fy * y / z + view.cy - row).max(initial=0.0) < 0.5 + 1e-9
    np.testing.assert_allclose(z, view.depth_m[row, column], atol=1e-6)
    np.testing.assert_array_equal(windows.images[0, OWN][is_seen], labels[row, column] == 1)


@given(SEEDS)
def test_places_come_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middles = rng.uniform((0.0, 0.0, 1.5), (640.0, 480.0, 8.0), (2, 3))
    images = np.zeros((2, 3, WINDOW_PIXELS, WINDOW_PIXELS), np.float32)
    halves_m = rng.uniform(LEAST_HALF_BOX_M, HALF_BOX_M, 2)
    is_used, is_mirrored = np.ones(2, np.bool_), np.zeros(2, np.bool_)
    lens = 520.0, 530.0, 310.0, 250.0
    windows = Windows(images, middles, halves_m, is_used, *lens, is_mirrored)
    inside = rng.uniform(-1.0, 1.0, (2, 3, 4, 3))
    assert windows.from_camera(windows.to_camera(inside)) == pytest.approx(inside, abs=1e-9)
    assert windows.to_camera(np.zeros((2, 3)))[:, 2] == pytest.approx(middles[:, 2])


@pytest.mark.parametrize(
    ("side", "half_m"),
    [(10, LEAST_HALF_BOX_M), (61, 1.0 + BOX_MARGIN_M), (95, HALF_BOX_M)],
)
def test_a_box_is_as_large_as_somebody_needs(side: int, half_m: float) -> None:
    """A square of 10, 61 or 95 pixels, 2 metres off; each pixel is 1 / 30 metres wide."""
    view = DepthView(np.full((100, 100), 2.0, np.float32), 60.0, 60.0, 49.5, 49.5)
    labels = np.zeros((100, 100), np.int32)
    labels[2 : 2 + side, 3 : 3 + side] = 1
    labels[0, 0] = 1  # one stray pixel
    assert cut_windows(view, labels, [1]).halves_m == pytest.approx([half_m])
    box = box_of(view, labels, 1)
    assert box is not None
    assert LEAST_HALF_BOX_M <= box.half_m(0.5) <= box.half_m() <= box.half_m(2.0) <= HALF_BOX_M


def test_beyond_the_image_s_edge_nothing_is_seen() -> None:
    view = DepthView(np.full((60, 60), 2.0, np.float32), 60.0, 60.0, 29.5, 29.5)
    labels = np.zeros((60, 60), np.int32)
    labels[20:40, :6], labels[45:, 6:20] = 3, 4
    windows = cut_windows(view, labels, [3])
    (image,) = windows.images
    rows, columns = window_pixels(view, windows.middles[0], windows.halves_m[0])
    is_outside = (columns < 0) | (rows < 0) | (rows > 59)
    assert 0.3 < is_outside.mean() < 0.7
    assert (image[:, is_outside] == [[1.0], [0.0], [0.0]]).all()
    assert (image[DEPTH, ~is_outside] == 0.0).all()
    assert image[OWN].any()
    assert image[OTHER].any()


def test_without_enough_pixels_there_is_no_window() -> None:
    view = DepthView(np.full((60, 60), 2.0, np.float32), 60.0, 60.0, 29.5, 29.5)
    labels = np.zeros((60, 60), np.int32)
    labels[0, : LEAST_WINDOW_PIXELS - 1], labels[5, :LEAST_WINDOW_PIXELS] = 1, 2
    windows = cut_windows(view, labels, [1, 2, 3])
    assert windows.is_used.tolist() == [False, True, False]
    assert not windows.images[[0, 2]].any()
    assert np.isfinite(windows.to_camera(np.zeros((3, 1, 3)))).all()
    assert cut_windows(view, labels, []).images.shape == (0, 3, WINDOW_PIXELS, WINDOW_PIXELS)


@given(st.lists(st.integers(0, 6), min_size=1, max_size=30))
def test_medians_of_counts_are_medians_and_reach_to_the_outermost(values: list[int]) -> None:
    middle, reach = middle_and_reach(np.bincount(values).astype(np.int32), 0.0)
    assert middle == np.median(values)
    assert reach == np.abs(np.array(values) - middle).max()


def test_a_box_reaches_as_far_in_front_as_behind() -> None:
    depth_m = np.full((60, 60), 2.0, np.float32)
    depth_m[10], depth_m[50] = 2.0 - 1.5 * HALF_BOX_M, 2.0 + 1.5 * HALF_BOX_M
    view = DepthView(depth_m, 60.0, 60.0, 29.5, 29.5)
    (image,) = cut_windows(view, np.ones((60, 60), np.int32), [1]).images
    assert {-1.0, 0.0, 1.0} == set(np.unique(image[DEPTH]).tolist())
