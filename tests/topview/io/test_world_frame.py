"""The world of the outputs: its floor, its up, and who says what they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import topview
from moving_bodies import CAMERA_HEIGHT_M, TILT_RAD, UP_CAMERA, moving_people
from topview import Camera, InputError, SkeletonSequence
from topview.io.camera_values import camera_from, camera_values
from topview.skeletons import About, TrackedFrame

CAMERA = Camera(285, 285, 15, 11, 32, 24)
PEOPLE = moving_people()
NOTHING = {"gravity_camera": np.full(3, np.nan), "floor_camera": np.full(4, np.nan)}


def world_of(points_camera: np.ndarray, people: SkeletonSequence = PEOPLE) -> np.ndarray:
    T = topview.T_world_camera(people)
    return points_camera @ T[:3, :3].T + T[:3, 3]


def test_the_floor_is_level_and_below_the_camera():
    below_camera = -CAMERA_HEIGHT_M * UP_CAMERA
    np.testing.assert_allclose(world_of(np.zeros(3)), [0, 0, CAMERA_HEIGHT_M], atol=1e-12)
    np.testing.assert_allclose(world_of(below_camera), [0, 0, 0], atol=1e-12)
    ahead, left = np.array([0, -np.sin(TILT_RAD), np.cos(TILT_RAD)]), np.array([-1.0, 0, 0])
    np.testing.assert_allclose(world_of(below_camera + ahead), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(world_of(below_camera + left), [0, 1, 0], atol=1e-12)


def test_gravity_that_is_given_counts_more_than_the_floor():
    """The floor may be a ramp; it is as high as it is below the camera."""
    ramp = replace(PEOPLE, gravity_camera=np.array([0.0, 1.0, 0.0]))
    height_m = CAMERA_HEIGHT_M / np.cos(TILT_RAD)
    np.testing.assert_allclose(world_of(np.array([0, height_m, 0]), ramp), [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(world_of(np.array([0, 0, 1.0]), ramp), [1, 0, height_m], atol=1e-12)
    floating = replace(ramp, floor_camera=NOTHING["floor_camera"])
    np.testing.assert_allclose(world_of(np.zeros(3), floating), [0, 0, 0])


def test_a_pose_of_the_user_s_counts_more_than_both_and_nothing_tells_nothing():
    T = np.eye(4)
    T[:3, 3] = 1.0, 2.0, 3.0
    given = replace(PEOPLE, camera=replace(CAMERA, T_world_camera=T))
    np.testing.assert_array_equal(topview.T_world_camera(given), T)
    assert np.isnan(topview.T_world_camera(replace(PEOPLE, **NOTHING))).all()


def test_the_file_of_a_run_says_it(tmp_path):
    about = About((), (), camera=replace(CAMERA, gravity_camera=np.array([0.0, 9.81, 0.0])))
    nobody = TrackedFrame(0, 0.0, "", about.packed([]), (0.0, -0.6, -0.8, 1.0))
    topview.write_skeletons(SkeletonSequence.from_frames([nobody], about), tmp_path / "o.npz")
    with np.load(tmp_path / "o.npz") as data:
        np.testing.assert_array_equal(data["gravity_camera"], [0, 1, 0])
        np.testing.assert_array_equal(data["T_world_camera"][2], [0, -1, 0, 0])
    people = topview.read_skeletons(tmp_path / "o.npz")
    assert people.camera == about.camera


def test_a_camera_s_gravity_is_kept_and_points_down():
    camera = replace(CAMERA, gravity_camera=np.array([0.1, 0.9, 0.2]))
    assert camera_from(camera_values(camera)) == camera
    assert camera != CAMERA
    for wrong in ([0, -9.81, 0], [0, 0.1, 1], [0, 1], [0, np.nan, 1], [1e308] * 3, "down"):
        with pytest.raises(InputError, match=r"gravity_camera is .*it must be three numbers that"):
            replace(CAMERA, gravity_camera=wrong)
