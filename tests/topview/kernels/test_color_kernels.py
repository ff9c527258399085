"""Colours of clothes: the kernel against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np

from topview.kernels.colors import count_clothes


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
