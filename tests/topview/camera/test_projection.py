"""The pinhole: there and back, and which way is up, with pixels that are not square."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from topview.camera.projection import pixel_rays, project, unproject_depth
from topview.records import Camera

CAMERA = Camera(fx=250.0, fy=310.0, cx=14.25, cy=10.75, width=32, height=24)
metres = st.floats(0.1, 9.0)


@given(metres, st.integers(0, 2**32 - 1))
def test_a_reading_comes_back_to_its_pixel(depth_m, seed):
    depth = np.random.default_rng(seed).uniform(0.1, depth_m + 0.1, (24, 32)).astype(np.float32)
    pixels = project(unproject_depth(depth, CAMERA), CAMERA)
    v, u = np.mgrid[:24, :32]
    assert_allclose(pixels, np.stack([u, v], axis=-1), atol=1e-4)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), metres, st.floats(0.1, 5.0))
def test_all_points_of_a_ray_are_seen_at_one_pixel(x, y, z, factor):
    point = np.array([x, y, z])
    assert_allclose(project(factor * point, CAMERA), project(point, CAMERA), rtol=1e-9, atol=1e-9)


def test_right_is_right_down_is_down_and_a_focal_length_is_a_pixel_per_tangent():
    assert_allclose(project(np.array([0.0, 0.0, 2.0]), CAMERA), (CAMERA.cx, CAMERA.cy))
    assert_allclose(project(np.array([0.2, 0.0, 2.0]), CAMERA), (CAMERA.cx + 25.0, CAMERA.cy))
    assert_allclose(project(np.array([0.0, 0.2, 2.0]), CAMERA), (CAMERA.cx, CAMERA.cy + 31.0))
    assert_allclose(pixel_rays(CAMERA)[10, 14], (-0.25 / 250, -0.75 / 310, 1.0), rtol=1e-6)


def test_what_has_no_reading_or_lies_behind_is_nowhere():
    assert not unproject_depth(np.zeros((24, 32), np.float32), CAMERA).any()
    behind = project(np.array([[0.1, 0.1, -1.0], [0.1, 0.1, 0.0]]), CAMERA)
    assert np.isnan(behind).all()
