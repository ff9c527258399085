"""Colours of a head against those of its body: the kernel against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from topview.kernels.colors import color_shares

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
