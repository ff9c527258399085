"""Colours of a head against those of its body: the kernel against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from topview.kernels.colors import color_shares, count_clothes, count_head_and_body

SHIFTS, RARE = (5, 4, 4), 0.002


@pytest.mark.parametrize("stride", [1, 3])
@pytest.mark.parametrize("pixel", [(10, 12), (0, 29)], ids=["inside", "in the corner"])
def test_shares_are_means_of_what_the_histograms_say(pixel: tuple[int, int], stride: int) -> None:
    rng = np.random.default_rng(stride)
    height, width, radius, about = 20, 30, 4, 2
    color = rng.integers(0, 256, (height * stride, width * stride, 3), np.uint8)
    depth = rng.choice([2.0, 2.3, 2.6], (height, width)).astype(np.float32)
    one, other = rng.random((2, 8, 16, 16)).astype(np.float32)
    shares = color_shares(
        color, depth, stride, pixel, radius, about, one, other, SHIFTS, RARE, 2.1, 0.35
    )
    rows, columns = (
        np.clip(np.arange(at - radius - about, at + radius + about + 1), 0, size - 1)
        for at, size in zip(pixel, (height, width), strict=True)
    )
    rgb = color[np.ix_(rows * stride, columns * stride)]
    yuv = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2YUV), np.uint8)
    bins = tuple(yuv[..., k] >> SHIFTS[k] for k in range(3))
    expected = (one[bins] + RARE) / (one[bins] + other[bins] + 2 * RARE)
    expected[np.abs(depth[np.ix_(rows, columns)] - 2.1) > 0.35] = 0.5
    blurred = cv2.blur(expected, (2 * about + 1, 2 * about + 1))[about:-about, about:-about]
    np.testing.assert_allclose(shares, blurred, rtol=1e-5)
    assert np.ptp(shares) > 0.1


def histogram_of(rgb: np.ndarray) -> np.ndarray:
    """[8, 16, 16] of [N, 3] colours, by Y, U and V."""
    yuv = cv2.cvtColor(rgb[None], cv2.COLOR_RGB2YUV)
    return cv2.calcHist([yuv], [0, 1, 2], None, [8, 16, 16], [0, 256] * 3)


@pytest.mark.parametrize("stride", [1, 3])
def test_a_head_and_the_body_below_it_are_counted(stride: int) -> None:
    rng = np.random.default_rng(stride)
    shape = (20, 30)
    color = rng.integers(0, 256, (shape[0] * stride, shape[1] * stride, 3), np.uint8)
    points = rng.uniform(-0.2, 0.2, (*shape, 3)).astype(np.float32)
    body = rng.choice([0.1, 0.3, 0.5, 1.2, 1.4, np.inf], shape).astype(np.float32)
    head, below = np.zeros((2, 8, 16, 16), np.float32)
    place, own = (0.02, 0.0, -0.01), color[::stride, ::stride]
    counted = count_head_and_body(
        color, stride, points, body, place, 0.12, (0.3, 1.3), SHIFTS, head, below
    )
    off = points - np.array(place, np.float32)
    is_head = (body < np.float32(0.3)) & ((off**2).sum(-1) < 0.12**2)
    is_below = (body > np.float32(0.3)) & (body < np.float32(1.3))
    assert counted == (is_head.sum(), is_below.sum())
    np.testing.assert_array_equal(head, histogram_of(own[is_head]))
    np.testing.assert_array_equal(below, histogram_of(own[is_below]))


def test_clothes_are_counted_by_lightness_and_chromaticity() -> None:
    rng = np.random.default_rng(0)
    shape, stride = (20, 30), 2
    color = rng.integers(0, 256, (shape[0] * stride, shape[1] * stride, 3), np.uint8)
    depth = rng.choice([0.0, 2.0], shape, p=[0.1, 0.9]).astype(np.float32)
    plan = rng.uniform(-0.2, 0.2, (2, *shape)).astype(np.float32)
    heights = rng.uniform(0.8, 1.6, shape).astype(np.float32)
    heads = np.array([[0.01, 0.0], [0.2, 0.1]])
    counts = np.zeros((6, 16, 16), np.float32)
    counted = count_clothes(
        color, stride, depth, plan, heights, (3, 2, 28, 19), heads, 1.65, (0.2, 0.6), 0.16, counts
    )
    aside, other = (np.hypot(plan[0] - right, plan[1] - forward) for right, forward in heads)
    is_own = (aside < 0.16) & (aside <= other) & (depth > 0.0)
    is_own &= (1.65 - heights > 0.2) & (1.65 - heights < 0.6)
    rgb = color[::stride, ::stride][2:19, 3:28][is_own[2:19, 3:28]].astype(np.float32)
    total = rgb.sum(1) + 1.0
    channels = [total / 3.0, rgb[:, 0] / total, rgb[:, 1] / total]
    expected = cv2.calcHist(
        [np.ascontiguousarray(channel[:, None]) for channel in channels],
        [0, 1, 2], None, [6, 16, 16], [0.0, 256.0, 0.0, 1.0, 0.0, 1.0],
    )  # fmt: skip
    assert counted == len(rgb) > 50
    np.testing.assert_array_equal(counts, expected)
