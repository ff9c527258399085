"""Pixels to points and back in a thinned image."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from topview.camera.projection import unproject_depth
from topview.camera.pyramid import Pyramid, thinned
from topview.records import Camera, Frame

CAMERA = Camera(fx=250.0, fy=310.0, cx=14.25, cy=10.75, width=32, height=24)
ROWS, COLUMNS = np.mgrid[:24, :32].reshape(2, -1)


def frame_of(seed: int) -> Frame:
    depth_m = np.random.default_rng(seed).uniform(0.2, 9.0, (24, 32)).astype(np.float32)
    return Frame(0, 0.0, depth_m, CAMERA)


@given(st.integers(0, 2**32 - 1))
def test_points_are_those_of_the_projection_and_come_back_to_their_pixels(seed):
    frame = frame_of(seed)
    view = Pyramid(frame).full
    points = view.points(ROWS, COLUMNS)
    assert_allclose(points, unproject_depth(frame.depth_m, CAMERA).reshape(-1, 3), atol=1e-5)
    rows, columns, is_inside = view.nearest_pixels(points, 0.1)
    assert_array_equal((rows, columns), (ROWS, COLUMNS))
    assert is_inside.all()


@pytest.mark.parametrize("stride", [2, 3])
def test_a_thinned_pixel_has_the_point_of_its_full_one(stride):
    image = Pyramid(frame_of(1))
    is_kept = (ROWS % stride == 0) & (COLUMNS % stride == 0)
    rows, columns = ROWS[is_kept], COLUMNS[is_kept]
    thinned = image.view(stride).points(rows // stride, columns // stride)
    assert_allclose(thinned, image.full.points(rows, columns), rtol=1e-9, atol=1e-9)


def test_what_is_beside_the_image_is_said_to_be():
    view = Pyramid(frame_of(2)).full
    beside = np.array([[-9.0, 0.0, 2.0], [9.0, 0.0, 2.0], [0.0, -9.0, 2.0], [0.0, 9.0, 2.0]])
    rows, columns, is_inside = view.nearest_pixels(beside, 0.1)
    assert not is_inside.any()
    assert not rows.any()
    assert not columns.any()
    behind = np.array([[0.0, 0.0, -2.0]])  # counts as just before the camera
    assert view.nearest_pixels(behind, 0.1)[2].all()


@pytest.mark.parametrize("stride", [1, 2, 3, 4])
def test_a_thinned_image_is_every_so_manieth_pixel(stride: int) -> None:
    depth_m = frame_of(0).depth_m[:23, :31].copy()
    thin_m = thinned(depth_m, stride)
    assert_array_equal(thin_m, depth_m[::stride, ::stride])
    assert thin_m.flags.c_contiguous
    assert not thin_m.flags.writeable
