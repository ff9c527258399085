"""Lenses: there and back, and as OpenCV has them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from lenses import LENSES, camera_with
from topview.camera import distort, pixel_rays, project, undistort
from topview.records import Camera, Distortion, InputError
from topview.room.surfaces import jump_of

ALL = pytest.mark.parametrize("lens", LENSES.values(), ids=list(LENSES))
FORWARD = pytest.mark.parametrize(
    "lens", [lens for lens in LENSES.values() if lens.model != "inverse_brown_conrady"]
)
IMAGE = np.stack(np.meshgrid(np.linspace(-0.76, 0.76, 97), np.linspace(-0.58, 0.58, 73)), -1)


@ALL
def test_there_and_back_is_where_it_was(lens):
    assert_allclose(undistort(distort(IMAGE, lens), lens), IMAGE, atol=1e-9)
    assert_allclose(distort(undistort(IMAGE, lens), lens), IMAGE, atol=1e-9)


@settings(deadline=None)
@given(
    st.tuples(*[st.floats(-0.3, 0.3)] * 2, *[st.floats(-0.01, 0.01)] * 2, st.floats(-0.1, 0.1)),
    st.sampled_from(["brown_conrady", "inverse_brown_conrady"]),
)
def test_any_lens_gives_back_a_place_or_knows_none(coefficients, model):
    lens = Distortion(model, coefficients)
    back = undistort(distort(IMAGE, lens), lens)
    is_known = np.asarray(np.isfinite(back).all(-1))
    assert is_known[36, 48]  # the middle of the image always is
    assert_allclose(back[is_known], IMAGE[is_known], atol=1e-6)


@FORWARD
def test_opencv_bends_the_same_way(lens):
    points = np.dstack([IMAGE, np.ones(IMAGE.shape[:2])]).reshape(-1, 3)
    coefficients = np.array(lens.coefficients)
    seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)
    assert_allclose(distort(IMAGE, lens).reshape(-1, 2), seen[:, 0], atol=1e-12)


@FORWARD
def test_opencv_straightens_the_same_way(lens):
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 500, 1e-12)
    places, unit = IMAGE.reshape(-1, 1, 2), np.eye(3)
    ideal = cv2.undistortPointsIter(places, unit, np.array(lens.coefficients), unit, unit, criteria)
    assert_allclose(undistort(IMAGE, lens).reshape(-1, 2), ideal[:, 0], atol=1e-6)


def test_the_inverse_model_is_brown_conrady_the_other_way_round():
    inverse = LENSES["inverse_brown_conrady"]
    forward = Distortion("brown_conrady", inverse.coefficients)
    assert_allclose(undistort(IMAGE, inverse), distort(IMAGE, forward), atol=1e-12)


def test_beyond_where_the_polynomial_comes_back_nothing_is_known():
    barrel = Distortion("brown_conrady", (-0.4, 0.0, 0.0, 0.0))  # r - 0.4 r^3 is 0.61 at most
    at_edge = np.array([[0.9, 0.0], [0.95, 0.0], [3.0, 0.0]])
    assert np.isfinite(distort(at_edge, barrel)).all(-1).tolist() == [True, False, False]
    seen = np.array([[0.6, 0.0], [0.62, 0.0]])
    assert np.isfinite(undistort(seen, barrel)).all(-1).tolist() == [True, False]


@pytest.mark.parametrize("lens", [None, Distortion("none"), Distortion("brown_conrady", (0,) * 5)])
def test_without_distortion_nothing_moves(lens):
    assert (distort(IMAGE, lens) == IMAGE).all()
    assert (undistort(IMAGE, lens) == IMAGE).all()
    assert camera_with(lens).is_pinhole


@ALL
def test_a_pixels_ray_is_seen_in_that_pixel(lens):
    camera = camera_with(lens)
    rows, columns = np.mgrid[: camera.height, : camera.width]
    pixels = project(2.5 * pixel_rays(camera), camera)
    assert_allclose(pixels, np.stack([columns, rows], -1), atol=1e-4)


class TestRecords:
    @pytest.mark.parametrize(
        ("model", "coefficients", "message"),
        [
            ("fisheye", (0.1,) * 4, "model is 'fisheye'; it must be one of none, brown_conrady"),
            ("brown_conrady", (0.1,) * 8, "brown_conrady has 8 coefficients; it must have 4 or 5"),
            ("rational", (0.1,) * 5, "rational has 5 coefficients; it must have 8"),
            ("brown_conrady", (0.1, 0.0, np.nan, 0.0), "they must be finite"),
            ("none", (0.1, 0.0, 0.0, 0.0), "they must be 0, or left out"),
        ],
    )
    def test_a_lens_that_cannot_be_is_refused_in_one_line(self, model, coefficients, message):
        with pytest.raises(InputError, match=message) as error:
            Distortion(model, coefficients)
        assert "\n" not in str(error.value)

    def test_cameras_of_equal_values_are_equal_and_hash_alike(self):
        T = np.eye(4)
        T[:3, 3] = 1.0, -2.0, 0.5
        lens = LENSES["rational"]
        one, same = (camera_with(lens, sensor="tof", T_world_camera=T.copy()) for _ in range(2))
        assert (one, hash(one)) == (same, hash(same))
        others = (
            camera_with(lens, sensor="tof"),
            camera_with(lens, T_world_camera=T),
            camera_with(None, sensor="tof", T_world_camera=T),
            camera_with(lens, sensor="tof", T_world_camera=np.eye(4)),
        )
        assert len({one, same, *others}) == 5

    def test_a_pose_is_copied_and_cannot_be_changed(self):
        T = np.eye(4)
        camera = camera_with(None, T_world_camera=T)
        T[0, 3] = 7.0
        assert camera.T_world_camera is not None
        assert camera.T_world_camera[0, 3] == 0.0
        with pytest.raises(ValueError, match="read-only"):
            camera.T_world_camera[0, 3] = 7.0

    @pytest.mark.parametrize(
        ("other", "message"),
        [
            ({"sensor": "lidar"}, "sensor is 'lidar'; it must be one of kinect1, tof, stereo"),
            ({"T_world_camera": np.eye(3)}, "T_world_camera must be 4 x 4 numbers"),
            ({"T_world_camera": 2.0 * np.eye(4)}, "T_world_camera is no rotation"),
        ],
    )
    def test_a_camera_that_cannot_be_is_refused_in_one_line(self, other, message):
        with pytest.raises(InputError, match=message) as error:
            Camera(210.0, 211.0, 157.3, 121.6, 320, 240, **other)
        assert "\n" not in str(error.value)


class TestNoise:
    def test_a_kinects_grows_with_the_square_of_the_depth(self):
        depth_m = np.linspace(0.5, 6.0, 50, dtype=np.float32)
        sigma_m = camera_with(None).noise.sigma_m(depth_m)
        assert sigma_m.dtype == np.float32
        assert (sigma_m == 0.0015 * depth_m * depth_m).all()
        assert jump_of(camera_with(None).noise) == (0.04, 0.0, 0.0035)

    @pytest.mark.parametrize(
        ("sensor", "at_2_m", "at_4_m"), [("tof", 0.005, 0.009), ("stereo", 0.0152, 0.0608)]
    )
    def test_other_sensors_have_their_own_law(self, sensor, at_2_m, at_4_m):
        noise = camera_with(None, sensor=sensor).noise
        assert_allclose(noise.sigma_m(np.array([2.0, 4.0])), [at_2_m, at_4_m])
        a, b, c = noise.times(3.0, 0.1)
        assert_allclose(a + b * 2.0 + c * 4.0, 0.1 + 3.0 * at_2_m)
