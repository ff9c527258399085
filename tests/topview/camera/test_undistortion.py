"""Images through a lens, as a pinhole camera would have taken them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lenses import LENSES, camera_with, plane_depth
from topview.camera import (
    pixel_rays,
    project,
    undistort,
    undistorted,
    undistorted_camera,
    undistortion,
    unproject_depth,
)
from topview.records import Camera, Distortion, Frame, InputError

ALL = pytest.mark.parametrize("lens", LENSES.values(), ids=list(LENSES))
NORMAL, DISTANCE_M = np.array([0.3, -0.4, np.sqrt(0.75)]), 2.0


def frame_of(camera: Camera, depth_m, color=None) -> Frame:
    return Frame(3, 0.1, depth_m, camera, color, "depth_3.png")


@ALL
def test_a_plane_seen_through_a_lens_is_a_plane(lens):
    camera = camera_with(lens)
    frame = undistorted(frame_of(camera, plane_depth(camera, tuple(NORMAL), DISTANCE_M)))
    is_read = frame.depth_m > 0.0
    points = unproject_depth(frame.depth_m, frame.camera)[is_read]
    off_m = np.abs(points @ NORMAL - DISTANCE_M)
    # A reading is at most half a pixel's diagonal from the ray that it is taken for.
    rays = pixel_rays(camera)[..., :2].astype(np.float64)
    diagonals = rays[1:, 1:] - rays[:-1, :-1], rays[1:, :-1] - rays[:-1, 1:]
    longest = max(np.linalg.norm(diagonal, axis=-1).max() for diagonal in diagonals)
    assert (off_m <= 0.51 * longest * points[:, 2] * np.hypot(*NORMAL[:2])).all()
    bent = plane_depth(camera, tuple(NORMAL), DISTANCE_M)
    untold = unproject_depth(bent, replace(camera, distortion=None))[bent > 0.0]
    assert np.abs(untold @ NORMAL - DISTANCE_M).mean() > 3.0 * off_m.mean()


@ALL
def test_every_reading_is_one_of_the_originals(lens):
    """So that no depth is mixed from two surfaces."""
    camera = camera_with(lens)
    depth_m = np.where(np.arange(320) % 7 < 3, 1.5, 3.0) * np.ones((240, 1))
    depth_m[100:110] = 0.0
    seen = undistorted(frame_of(camera, depth_m.astype(np.float32))).depth_m
    assert set(np.unique(seen)) == {0.0, 1.5, 3.0}


@ALL
def test_nothing_that_the_original_shows_is_lost(lens):
    camera = camera_with(lens)
    pinhole = undistorted_camera(camera)
    rays = pixel_rays(camera)
    pixels = project(rays[np.isfinite(rays).all(-1)].astype(np.float64), pinhole)
    assert (pixels > -0.51).all()
    assert (pixels < (pinhole.width - 0.49, pinhole.height - 0.49)).all()
    assert (pinhole.fx, pinhole.fy, pinhole.is_pinhole) == (camera.fx, camera.fy, True)


@ALL
def test_colour_goes_to_where_its_depth_goes(lens):
    camera = camera_with(lens)
    _, columns = np.mgrid[:240, :320]
    is_left = columns < 150
    color = np.where(is_left[..., None], (200, 30, 30), (30, 30, 200)).astype(np.uint8)
    depth_m = np.where(is_left, 1.0, 2.0).astype(np.float32)
    frame = undistorted(frame_of(camera, depth_m, color))
    assert frame.color is not None
    is_far = frame.depth_m == 2.0
    is_blue = frame.color[..., 2] > 115
    assert (is_far != is_blue).mean() < 0.001
    assert not frame.color[frame.depth_m == 0.0].any()
    assert (frame.index, frame.timestamp_s, frame.name) == (3, 0.1, "depth_3.png")


@pytest.mark.parametrize("lens", [None, Distortion("none"), Distortion("rational", (0,) * 8)])
def test_without_distortion_the_frame_itself_is_given(lens):
    frame = frame_of(camera_with(lens), np.ones((240, 320), np.float32))
    assert undistorted(frame) is frame
    assert undistorted_camera(frame.camera) is frame.camera


def test_the_look_up_is_made_once_for_a_camera_wherever_it_stands():
    T = np.eye(4)
    T[1, 3] = 1.5
    first = undistortion(camera_with(LENSES["rational"]))
    assert undistortion(camera_with(LENSES["rational"], T_world_camera=T)) is first
    pinhole = undistorted_camera(camera_with(LENSES["rational"], T_world_camera=T, sensor="tof"))
    assert pinhole.T_world_camera is not None
    assert_array_equal(pinhole.T_world_camera, T)
    assert pinhole.sensor == "tof"


def test_places_of_the_pinhole_image_are_found_in_the_original():
    camera = camera_with(LENSES["rational"])
    look_up = undistortion(camera)
    seen = np.array([[20.0, 20.0], [160.3, 119.7], [300.2, 220.9]])
    ideal = undistort((seen - (camera.cx, camera.cy)) / (camera.fx, camera.fy), camera.distortion)
    pinhole = look_up.camera
    places = ideal * (pinhole.fx, pinhole.fy) + (pinhole.cx, pinhole.cy)
    outside = [-2.0, -2.0]
    found = look_up.original_px(np.vstack([places, outside]).T.astype(np.float32)[:, None])
    np.testing.assert_allclose(found[:, 0, :3].T, seen, atol=0.05)
    assert np.isnan(found[:, 0, 3]).all()


def test_a_lens_that_leaves_no_pixel_a_ray_is_refused_in_one_line():
    camera = Camera(
        20.0, 10.0, -300.0, 100.0, 300, 200, Distortion("brown_conrady", (-9.0, 0, 0, 0))
    )
    with pytest.raises(InputError, match="leaves no pixel a ray") as error:
        undistorted(Frame(0, 0.0, np.ones((200, 300), np.float32), camera))
    assert "\n" not in str(error.value)
