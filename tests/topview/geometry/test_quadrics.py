"""Laws of quadrics and of the rays that meet them, then what a cylinder looks like."""

from __future__ import annotations

import numpy as np
import pytest
from geometry_strategies import rotations, vectors
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from topview.geometry.quadrics import (
    closed_cylinder_depths,
    elliptic_cylinder,
    evaluate,
    pair_of_planes,
    ray_roots,
    transformed,
)
from topview.geometry.rotations import transform

LENGTH, RX, RZ = 0.5, 0.15, 0.1
GRID = np.stack(np.meshgrid(np.linspace(-0.3, 0.3, 25), np.linspace(-0.3, 0.3, 25)), axis=-1)
RAYS = np.concatenate([GRID, np.ones((25, 25, 1))], axis=-1)

# Everywhere in view, from straight on to end on, and partly out of view.
poses = st.builds(
    transform,
    rotations(),
    vectors(1.0).map(lambda v: np.array([0.4 * v[0], 0.4 * v[1], 2.0 + v[2]])),
)


def depths(T_camera_part: np.ndarray, rays: np.ndarray = RAYS) -> np.ndarray:
    return closed_cylinder_depths(rays, T_camera_part, LENGTH, RX, RZ)


def excess_of(points_part: np.ndarray) -> np.ndarray:
    """[...] negative inside of the closed cylinder, zero on its surface."""
    x, y, z = np.moveaxis(points_part, -1, 0)
    return np.max([np.hypot(x / RX, z / RZ) - 1.0, -y, y - LENGTH], axis=0)


def in_part(T_camera_part: np.ndarray, points_camera: np.ndarray) -> np.ndarray:
    return (points_camera - T_camera_part[:3, 3]) @ T_camera_part[:3, :3]


@given(poses)
def test_a_hit_lies_on_the_surface_and_nothing_is_nearer(T):
    t = depths(T)
    is_hit = np.isfinite(t)
    hits = RAYS[is_hit] * t[is_hit, None]
    assert_allclose(excess_of(in_part(T, hits)), 0.0, atol=1e-7)
    shares = np.linspace(0.0, 1.0 - 1e-6, 200)[:, None, None]
    assert (excess_of(in_part(T, shares * hits)) > -1e-7).all()


@given(poses)
def test_a_miss_never_enters_the_cylinder(T):
    is_miss = np.isinf(depths(T))
    along = np.linspace(0.5, 4.0, 400)[:, None, None]
    assert (excess_of(in_part(T, along * RAYS[is_miss])) > -1e-9).all()


@given(poses)
def test_a_ray_at_a_point_inside_hits(T):
    inside_part = np.array([[0.0, 0.25, 0.0], [0.14, 0.01, 0.0], [0.0, 0.49, -0.09]])
    inside = inside_part @ T[:3, :3].T + T[:3, 3]
    t = depths(T, inside / inside[:, 2:])
    assert (t <= inside[:, 2]).all()


def assert_same_image(actual: np.ndarray, expected: np.ndarray) -> None:
    """Equal but where rounding decides: at the silhouette, or a row of rays in an end's plane."""
    differs = ~np.isclose(actual, expected, rtol=0.0, atol=1e-6)
    assert differs.sum() <= len(GRID)


@given(poses, rotations())
def test_moving_camera_and_body_together_changes_nothing(T, R):
    turned = transform(R @ T[:3, :3], R @ T[:3, 3])
    assert_same_image(depths(turned, RAYS @ R.T), depths(T))


@given(poses)
def test_a_mirrored_pose_has_a_mirrored_image(T):
    mirror = np.diag([-1.0, 1.0, 1.0])
    mirrored = transform(mirror @ T[:3, :3] @ mirror, mirror @ T[:3, 3])
    assert_same_image(depths(mirrored), depths(T)[:, ::-1])


@given(poses, vectors(1.0))
def test_a_transformed_quadric_has_the_same_value_at_the_moved_point(T, point_part):
    for Q in (elliptic_cylinder(RX, RZ), pair_of_planes(0.0, LENGTH)):
        expected = evaluate(Q, point_part)
        moved = T[:3, :3] @ point_part + T[:3, 3]
        assert_allclose(evaluate(transformed(Q, T), moved), expected, atol=1e-9)


@given(st.floats(-1, 1), st.floats(-1, 1), vectors(2.0))
def test_pair_of_planes_is_negative_between_them(y0, y1, point):
    y = point[1]
    value = evaluate(pair_of_planes(y0, y1), point)
    assert_allclose(value, (y - y0) * (y - y1), atol=1e-12)


@given(vectors(2.0))
def test_roots_are_where_the_ray_meets_the_quadric(ray):
    assume(np.linalg.norm(ray[[0, 2]]) > 1e-3)
    Q = transformed(elliptic_cylinder(RX, RZ), transform(np.eye(3), np.array([0.0, 0.0, 2.0])))
    t = ray_roots(Q, ray)
    t = t[np.isfinite(t)]
    assert_allclose(evaluate(Q, t[:, None] * ray), 0.0, atol=1e-6)


LYING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # +y points away
AWAY = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


@pytest.mark.parametrize(
    ("R", "origin", "expected"),
    [
        pytest.param(np.eye(3), (0.0, -0.25, 2.0), 2.0 - RZ, id="upright: its front"),
        pytest.param(AWAY, (0.0, 0.25, 2.0), 2.0 - RZ, id="upside down: the same front"),
        pytest.param(LYING, (0.0, 0.0, 2.0), 2.0, id="end on: the near disc"),
        pytest.param(LYING.T, (0.0, 0.0, 2.0), 2.0 - LENGTH, id="the other end first"),
        pytest.param(np.eye(3), (0.0, 0.01, 2.0), np.inf, id="just below the ray"),
        pytest.param(np.eye(3), (0.0, -0.25, -2.0), np.inf, id="behind the camera"),
    ],
)
def test_depth_of_the_middle_ray(R, origin, expected):
    T = transform(R, np.array(origin))
    middle = np.array([0.0, 0.0, 1.0])
    assert depths(T, middle) == pytest.approx(expected)


def test_wide_and_narrow_side_are_told_apart():
    upright = transform(np.eye(3), np.array([0.0, -0.25, 2.0]))
    row = np.isfinite(depths(upright)[12])
    seen_half_width = np.abs(RAYS[12, row, 0]).max() * 2.0
    assert RZ < seen_half_width <= RX * 1.01
