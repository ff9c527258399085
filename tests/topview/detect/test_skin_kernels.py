"""The kernels of skin against their definitions in NumPy and OpenCV."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from topview.detect.ellipses import Ellipse
from topview.kernels.skin import (
    connected_regions,
    count_bins,
    count_levels,
    count_lights,
    cut_at_edges,
    learn_still,
    look_at_end,
    look_up_levels,
    moments,
    move_onto,
    paint,
    perimeter,
    share_pixels,
    widen_mask,
)

LOW, HIGH, LEAST = 50, 100, 4
ROWS, COLUMNS = np.mgrid[:60, :80]

seeds = st.integers(0, 2**31)


def pixels_of(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    rows, columns = np.nonzero(mask)
    return np.stack([columns, rows], axis=1).astype(np.float32)


def disc(x: float, y: float, radius: float) -> NDArray[np.bool_]:
    return np.hypot(COLUMNS - x, ROWS - y) <= radius


def all_of(image: NDArray[np.generic]) -> tuple[int, int, int, int]:
    """The box that holds it."""
    return 0, 0, image.shape[1] - 1, image.shape[0] - 1


def regions(
    level: NDArray[np.uint8], depth_m: NDArray[np.float32]
) -> list[tuple[NDArray[np.float32], list[int], list[float]]]:
    """Pixels, box and means of each."""
    pixels, starts, boxes, means = connected_regions(
        level, depth_m, LOW, HIGH, LEAST, all_of(level)
    )
    return [
        (pixels[starts[k] : starts[k + 1]], boxes[k].tolist(), means[k].tolist())
        for k in range(len(boxes))
    ]


@settings(max_examples=25)
@given(seeds)
def test_regions_are_opencvs_components_with_a_seed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = cv2.GaussianBlur(rng.uniform(0, 255, (30, 40)).astype(np.float32), (0, 0), 1.0)
    level = np.clip((noise - 100.0) * 4.0, 0, 255).astype(np.uint8)
    depth_m = np.where(rng.random(level.shape) < 0.3, 0.0, rng.uniform(1, 4, level.shape))
    depth_m = depth_m.astype(np.float32)
    count, labels = cv2.connectedComponents((level > LOW).astype(np.uint8), connectivity=8)
    expected = []
    for label in range(1, count):
        own = np.asarray(labels) == label
        if own.sum() >= LEAST and level[own].max() > HIGH:
            expected.append(own)
    expected.sort(key=lambda own: np.flatnonzero(own)[0])  # OpenCV's order is not always this one
    found = regions(level, depth_m)
    assert len(found) == len(expected)
    for (pixels, box, (mean, read, median_m, *rest)), own in zip(found, expected, strict=True):
        truth = pixels_of(own)
        assert {tuple(p) for p in pixels.tolist()} == {tuple(p) for p in truth.tolist()}
        assert box == [*truth.min(axis=0).tolist(), *truth.max(axis=0).tolist()]
        depths = depth_m[own]
        assert mean == pytest.approx(level[own].mean())
        assert read == pytest.approx((depths > 0.0).mean())
        readings = depths[depths > 0.0]
        assert median_m == pytest.approx(np.median(readings) if len(readings) else 0.0)
        assert tuple(rest) == moments(pixels)


@given(seeds)
def test_moments_are_the_means_and_the_covariance(seed: int) -> None:
    pixels = np.random.default_rng(seed).uniform(0, 300, (50, 2)).astype(np.float32)
    covariance = np.cov(pixels.T.astype(np.float64), bias=True)
    expected = [*pixels.mean(axis=0, dtype=np.float64), *np.diag(covariance), covariance[0, 1]]
    assert moments(pixels) == pytest.approx(expected)


@settings(max_examples=25)
@given(seeds)
def test_pixels_are_shared_as_the_ellipses_distances_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ellipses = [
        Ellipse(x, y, 12.0, 5.0, angle)
        for x, y, angle in zip(*rng.uniform((20, 20, -1.5), (60, 40, 1.5), (3, 3)).T, strict=True)
    ]
    depths_m = np.array([1.5, 1.55, 0.0])
    depth_m = rng.choice([0.0, 1.5, 1.8], ROWS.shape).astype(np.float32)
    pixels = pixels_of(disc(40, 30, 15))
    values = np.array([[e.x, e.y, e.major, e.minor, e.angle] for e in ellipses])
    shared, starts, told = share_pixels(pixels, depth_m, values, depths_m, 0.1)
    belongs = np.zeros((3, len(pixels)), np.bool_)
    places = {place: n for n, place in enumerate(map(tuple, pixels.tolist()))}
    for k, (start, end) in enumerate(pairwise(starts.tolist())):
        belongs[k, [places[tuple(place)] for place in shared[start:end].tolist()]] = True
        if start < end:
            columns, rows = shared[start:end].astype(int).T
            readings = depth_m[rows, columns][depth_m[rows, columns] > 0.0]
            assert told[k, 1] == pytest.approx(np.median(readings) if len(readings) else 0.0)
            assert tuple(told[k, 2:]) == moments(shared[start:end])
    both = (belongs & (belongs.sum(0) > 1)).sum(1)
    np.testing.assert_array_equal(told[:, 0], both / np.maximum(belongs.sum(1), 1))
    for n, (x, y) in enumerate(pixels.tolist()):
        z = depth_m[int(y), int(x)]
        near = [z == 0.0 or d == 0.0 or abs(z - d) < 0.1 for d in depths_m.tolist()]
        distance = [
            float(e.distance(np.array([x, y]))) if is_near else np.inf
            for e, is_near in zip(ellipses, near, strict=True)
        ]
        inside = [d <= 1.0 for d in distance]
        nearest = [d == min(distance) for d in distance]
        assert belongs[:, n].tolist() == (inside if any(inside) else nearest)


def test_the_perimeter_of_discs_and_squares() -> None:
    for radius in (8.0, 14.0, 25.0):
        found = perimeter(pixels_of(disc(40, 29.5, radius)))
        assert found == pytest.approx(2.0 * np.pi * radius, rel=0.05)
    upright = (abs(COLUMNS - 40) <= 15) & (abs(ROWS - 30) <= 15)
    turned = abs(COLUMNS - 40) + abs(ROWS - 30) <= 21
    assert perimeter(pixels_of(upright)) == pytest.approx(4 * 31, rel=0.12)
    assert perimeter(pixels_of(turned)) == pytest.approx(4 * 21 * np.sqrt(2.0), rel=0.12)
    ring = disc(40, 29.5, 20) & ~disc(40, 29.5, 10)
    assert perimeter(pixels_of(ring)) == pytest.approx(2.0 * np.pi * 30, rel=0.05)


@given(seeds)
def test_the_label_inside_has_most_pixels_in_the_ellipse(seed: int) -> None:
    rng = np.random.default_rng(seed)
    right, down = rng.uniform(0, 60, 2)
    label_of = rng.integers(0, 4, ROWS.shape, np.int32) * disc(right, down, 12)
    x, y, angle = rng.uniform((-5, -5, -1.5), (85, 65, 1.5))
    ellipse = Ellipse(x, y, 11.0, 4.0, angle)
    shared = [ellipse.count(pixels_of(label_of == label)) for label in (1, 2, 3)]
    expected = shared.index(max(shared)) + 1 if any(shared) else 0
    assert ellipse.label_inside(label_of, 3) == expected


def test_what_is_painted_is_counted_where_it_lands() -> None:
    image = np.zeros(ROWS.shape, np.int32)
    pixels = pixels_of(disc(20, 20, 6))
    paint(pixels, 2, image)
    assert (image == 2 * disc(20, 20, 6)).all()
    moved = pixels.copy()
    assert move_onto(moved, 0.4, 0.4, image, 2) == 2
    np.testing.assert_array_equal(moved, pixels + np.float32(0.4))
    assert move_onto(moved, -100.0, -100.0, image, 2) == 0
    image[20, 20] = 1
    assert move_onto(pixels.copy(), 0.0, 0.0, image, 2) == 2


@pytest.mark.parametrize("angle", np.linspace(-np.pi, np.pi, 7))
def test_the_end_of_a_bar(angle: float) -> None:
    along = np.array([np.cos(angle), np.sin(angle)])
    s = (COLUMNS - 40) * along[0] + (ROWS - 30) * along[1]
    across = (ROWS - 30) * along[0] - (COLUMNS - 40) * along[1]
    bar = (abs(s) <= 20) & (abs(across) <= 4)
    depth_m = (2.0 + 0.01 * s).astype(np.float32)
    x, y, median_m = look_at_end(pixels_of(bar), depth_m, along[0], along[1], 10.0)
    assert np.allclose([x, y], [40, 30] + 15 * along, atol=1.0)
    assert median_m == pytest.approx(2.15, abs=0.01)
    nothing = np.zeros_like(depth_m)
    assert look_at_end(pixels_of(bar), nothing, along[0], along[1], 10.0)[2] == 0.0


@given(seeds)
@settings(max_examples=25)
def test_levels_are_cut_at_edges_and_holes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.choice([2.0, 2.05, 2.3], (20, 30), p=[0.7, 0.25, 0.05]).astype(np.float32)
    depth[rng.random(depth.shape) < 0.02] = 0.0
    level = rng.integers(0, 256, depth.shape, np.uint8)
    cut, some = np.zeros_like(level), np.zeros_like(level)
    cut_at_edges(level, depth, 0.1, all_of(level), cut)
    cut_at_edges(level, depth, 0.1, (4, 3, 20, 11), some)
    np.testing.assert_array_equal(some[3:12, 4:21], cut[3:12, 4:21])
    assert some.sum() == some[3:12, 4:21].sum()
    around = np.ones((3, 3), np.uint8)
    is_edge = (cv2.dilate(depth, around) - cv2.erode(depth, around) > 0.1) | (depth == 0.0)
    np.testing.assert_array_equal(cut, np.where(is_edge, 0, level))
    assert is_edge.any()


@pytest.mark.parametrize(("stride", "mask_stride"), [(2, 4), (1, 4), (2, 3), (3, 3)])
def test_a_mask_is_widened_and_enlarged(stride: int, mask_stride: int) -> None:
    rng = np.random.default_rng(0)
    mask = rng.random((20, 30)) < 0.05
    wide = np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((3, 3), np.uint8))) > 0
    rows, columns = (np.arange(side * mask_stride // stride) for side in mask.shape)
    found = np.empty((len(rows), len(columns)), np.bool_)
    widen_mask(mask, stride, mask_stride, found)
    of_row, of_column = rows * stride // mask_stride, columns * stride // mask_stride
    np.testing.assert_array_equal(found, wide[of_row][:, of_column])


def a_colored_image(step: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]:
    """[60 * step, 80 * step, 3] RGB, and RGB and YUV of the means of `step` x `step` pixels."""
    rng = np.random.default_rng(step)
    small = rng.choice(np.array([0, 30, 130, 252], np.uint8), (60, 80, 3))
    small[rng.random((60, 80)) < 0.2] = 0
    color = small.repeat(step, 0).repeat(step, 1)
    color += rng.integers(0, 3, color.shape, np.uint8) * (color > 0)
    rgb = np.asarray(cv2.resize(color, (80, 60), interpolation=cv2.INTER_AREA), np.uint8)
    return color, rgb, np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2YUV), np.uint8)


@pytest.mark.parametrize("step", [1, 2])
def test_lights_are_counted_where_it_is_not_black(step: int) -> None:
    color, rgb, yuv = a_colored_image(step)
    count, dim, clipped, spread = count_lights(color, step, 3, 40.0, 250)
    few, colors = rgb[::3, ::3].reshape(-1, 3), yuv[::3, ::3].reshape(-1, 3)
    is_there = few.max(1) > 0
    assert (count, dim) == (is_there.sum(), (colors[is_there, 0] < 40).sum())
    assert clipped == (few[is_there].min(1) >= 250).sum() > 0
    tints = np.sort(colors[is_there, 1:].astype(int), axis=0)
    rare = count // 100
    assert spread == (tints[count - 1 - rare] - tints[rare]).max()


@pytest.mark.parametrize("step", [1, 2])
def test_levels_are_looked_up_by_the_colour(step: int) -> None:
    color, _, yuv = a_colored_image(step)
    rng = np.random.default_rng(0)
    is_sought = rng.random((60, 80)) < 0.5
    table = rng.integers(0, 256, (64, 64), np.uint8)
    level, bin_of = np.empty((60, 80), np.uint8), np.full((60, 80), -1, np.int32)
    counts = np.zeros(64 * 64)
    look_up_levels(color, step, is_sought, table, 2, 18, level, bin_of, counts)
    luma, u, v = yuv.transpose(2, 0, 1).astype(np.int32)
    expected = np.where(is_sought, (u >> 2) * 64 + (v >> 2), -1)
    np.testing.assert_array_equal(bin_of, expected)
    np.testing.assert_array_equal(
        level, np.where(is_sought & (luma >= 18), table[u >> 2, v >> 2], 0)
    )
    np.testing.assert_array_equal(counts, np.bincount(bin_of[is_sought], minlength=64 * 64))
    some = pixels_of(is_sought & (luma > 100))
    of_some = np.zeros(64 * 64)
    count_bins(some, bin_of, of_some)
    columns, rows = some.T.astype(int)
    np.testing.assert_array_equal(of_some, np.bincount(bin_of[rows, columns], minlength=64 * 64))


@given(seeds)
@settings(max_examples=25)
def test_what_keeps_still_is_learnt(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.choice([0.0, 2.0, 2.02, 2.5], (6, 7)).astype(np.float32)
    somebody = rng.random(depth.shape) < 0.2
    last, nearest = np.full(depth.shape, 2.0, np.float32), np.full(depth.shape, 9.0, np.float32)
    still_s = rng.choice([0.0, 1.5], depth.shape).astype(np.float32)
    margin = (0.03, 0.001, 0.002)
    after = last.copy(), still_s.copy(), nearest.copy()
    learn_still(depth, somebody, 0.5, 2.0, margin, *after)
    is_free = (depth > 0.0) & ~somebody
    margin_m = margin[0] + margin[1] * depth + margin[2] * depth**2
    now_s = np.where(is_free, (still_s + 0.5) * (np.abs(depth - last) < margin_m), still_s)
    is_still = is_free & (now_s >= 2.0)
    np.testing.assert_array_equal(after[0], np.where(is_free, depth, last))
    np.testing.assert_array_equal(after[1], now_s)
    np.testing.assert_allclose(after[2], np.where(is_still, depth - margin_m, nearest), rtol=1e-6)


@given(seeds)
@settings(max_examples=25)
def test_levels_are_counted_in_an_ellipse_at_a_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    level = rng.integers(0, 256, (15, 20), np.uint8)
    depth = rng.choice([2.0, 2.1, 2.6], (30, 40)).astype(np.float32)
    v, u = rng.uniform(-2.0, 17.0), rng.uniform(-2.0, 22.0)
    counts = count_levels(level, depth, 2, (v, u), (5.0, 4.0), 2.05, 0.17, 100)
    rows, columns = np.mgrid[:15, :20]
    is_in = np.hypot((columns - u) / 4.0, (rows - v) / 5.0) < 1.0
    is_in &= np.abs(depth[::2, ::2] - 2.05) < 0.17
    assert counts == (is_in.sum(), (level[is_in] >= 100).sum())
