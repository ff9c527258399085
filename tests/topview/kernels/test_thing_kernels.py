"""What tells things: the kernels and their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from topview.kernels.things import STEPS_OF_A_SHARE, forget_changed, mean_around
from topview.records import KINECT1_NOISE


@pytest.mark.parametrize("radius_m", [0.0, 0.1, 0.3, 5.0])
def test_the_mean_is_that_of_all_points_within_the_radius(radius_m):
    rng = np.random.default_rng(4)
    points = rng.uniform(-0.5, 0.5, (300, 3))
    shares, out = rng.uniform(0.0, 1.0, 300), np.empty(300)
    mean_around(points, points, shares, radius_m, out)
    is_near = np.linalg.norm(points[:, None] - points, axis=-1) <= radius_m
    assert_allclose(out, is_near @ shares / is_near.sum(1), atol=0.5 / STEPS_OF_A_SHARE)


def test_what_is_known_is_forgotten_where_the_depth_is_another():
    depth_m = np.array([[2.0, 2.0, 0.0, 2.0]], np.float32)
    last_m = np.array([[2.0, 2.5, 2.5, 0.0]], np.float32)
    known = np.ones_like(depth_m)
    forget_changed(depth_m, KINECT1_NOISE.times(3.0, 0.02), last_m, known)
    assert_array_equal(known, [[1.0, 0.0, 1.0, 0.0]])
    assert_array_equal(last_m, [[2.0, 2.0, 2.5, 2.0]])
