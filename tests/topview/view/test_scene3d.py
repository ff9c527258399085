from __future__ import annotations

import numpy as np
import pytest

from topview.camera import project
from topview.records import Camera
from topview.view.palette import PANEL
from topview.view.scene3d import Painting, Stage, _cast_on_capsule, paint_scene

UP = np.array([0.0, -1.0, 0.0])


def distance_to_axis(points, low, high):
    """[...] distance of [..., 3] points from the segment low..high on y."""
    nearest = np.zeros_like(points)
    nearest[..., 1] = np.clip(points[..., 1], low, high)
    return np.linalg.norm(points - nearest, axis=-1)


def test_a_ray_hits_the_capsule_on_its_surface_and_no_nearer_point_is_inside():
    rng = np.random.default_rng(1)
    start = np.array([0.5, 1.0, -6.0])
    rays = rng.normal([0.0, 0.0, 3.0], 1.0, (500, 3))
    low, high = 0.5, 3.0
    distance, normals = _cast_on_capsule(start, rays, low, high)
    hits = np.isfinite(distance)
    assert 50 < hits.sum() < 450
    on_surface = start + distance[hits, None] * rays[hits]
    np.testing.assert_allclose(distance_to_axis(on_surface, low, high), 1.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normals[hits], axis=-1), 1.0, atol=1e-9)
    assert (np.sum(normals[hits] * rays[hits], axis=-1) <= 1e-9).all()
    along = np.linspace(0.0, 1.0, 400)[:, None, None]
    reach = np.where(hits, distance, 20.0)[:, None]
    before = start + (along * 0.999) * reach * rays
    assert (distance_to_axis(before, low, high) > 1.0 - 1e-9).all()


def test_a_solid_has_its_depth_and_stays_in_its_outline():
    eye = Camera(200.0, 200.0, 99.5, 74.5, 200, 150)
    painting = Painting(eye)
    T = np.eye(4)
    T[:3, 3] = 0.0, -0.5, 3.0
    painting.solid(T, (0.2, 0.1), 1.0, (255, 0, 0))
    assert painting.depth_m[74, 99] == pytest.approx(2.9, abs=1e-3)
    rows, columns = np.nonzero(np.isfinite(painting.depth_m))
    assert abs(columns - 99.5).max() <= 200 * 0.2 / 2.9 + 1
    assert abs(rows - 74.5).max() <= 200 * 0.5 / 2.9 + 1
    np.testing.assert_array_equal(
        np.isfinite(painting.depth_m), (painting.image != PANEL).any(axis=-1)
    )


@pytest.mark.parametrize("order", [(2.0, 4.0), (4.0, 2.0)])
def test_what_is_nearer_hides_what_is_behind(order):
    painting = Painting(Camera(100.0, 100.0, 49.5, 49.5, 100, 100))
    colors = {2.0: (255, 0, 0), 4.0: (0, 0, 255)}
    for depth_m in order:
        T = np.eye(4)
        T[:3, 3] = 0.0, -0.5, depth_m
        painting.solid(T, (0.2, 0.2), 1.0, colors[depth_m])
    assert painting.image[50, 50, 0] > 0
    assert painting.image[50, 50, 2] == 0


def test_solids_behind_or_beside_the_eye_are_left_out():
    painting = Painting(Camera(100.0, 100.0, 49.5, 49.5, 100, 100))
    for place in ((0.0, 0.0, -3.0), (50.0, 0.0, 3.0), (0.0, -50.0, 3.0)):
        T = np.eye(4)
        T[:3, 3] = place
        painting.solid(T, (0.2, 0.2), 1.0, (255, 0, 0))
    assert not np.isfinite(painting.depth_m).any()


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_the_stage_is_level_and_the_eye_sees_everyone(make_person, tilt):
    up = np.array([0.0, -np.cos(tilt), -np.sin(tilt)])
    joints = np.concatenate(
        [make_person(1, (-1.0, -0.8, 3.0)).joints_camera, make_person(2).joints_camera]
    )
    stage = Stage.around(joints, up, 1.1)
    T = stage.T_stage_camera
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(T[:3, :3] @ up, UP, atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], [0.0, -1.1, 0.0])
    eye, T_eye_camera = stage.eye((320, 240))
    np.testing.assert_allclose(T_eye_camera[:3, :3] @ T_eye_camera[:3, :3].T, np.eye(3), atol=1e-12)
    places = project(joints @ T_eye_camera[:3, :3].T + T_eye_camera[:3, 3], eye)
    assert (places > 0).all()
    assert (places < (320, 240)).all()


def test_a_scene_shows_the_people_and_paints_the_same_twice(make_frame, make_person):
    people = [make_person(1), make_person(2, (1.0, -0.8, 3.5))]
    joints = np.concatenate([person.joints_camera for person in people])
    stage = Stage.around(joints, UP, 1.0)
    scene = paint_scene(make_frame(), people, stage, (320, 240))
    assert scene.shape == (240, 320, 3)
    empty = paint_scene(make_frame(), [], stage, (320, 240))
    assert (scene != empty).any(axis=-1).mean() > 0.02
    np.testing.assert_array_equal(scene, paint_scene(make_frame(), people, stage, (320, 240)))
