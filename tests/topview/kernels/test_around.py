"""The mean around a point: the kernel and its definition."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from topview.kernels.around import STEPS_OF_A_SHARE, mean_around


@pytest.mark.parametrize("radius_m", [0.0, 0.1, 0.3, 5.0])
def test_the_mean_is_that_of_all_points_within_the_radius(radius_m):
    rng = np.random.default_rng(4)
    points = rng.uniform(-0.5, 0.5, (300, 3))
    shares, out = rng.uniform(0.0, 1.0, 300), np.empty(300)
    mean_around(points, shares, radius_m, out)
    is_near = np.linalg.norm(points[:, None] - points, axis=-1) <= radius_m
    assert_allclose(out, is_near @ shares / is_near.sum(1), atol=0.5 / STEPS_OF_A_SHARE)
