"""Laws of rotations and transforms."""

from __future__ import annotations

import numpy as np
import pytest
from geometry_strategies import rigid_motions, rotations, vectors
from hypothesis import assume, given
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from topview.geometry.rotations import (
    angles_from_rotations,
    horizontal,
    nearest_rotations,
    rotations_from_angles,
    rotations_from_vectors,
    shortest_turns,
    skew,
    transform,
    unit,
    vectors_from_rotations,
)


@given(vectors(np.pi))
def test_angles_turn_about_y_then_z_then_x(angles):
    x, y, z = angles
    expected = Rotation.from_euler("XZY", [x, z, y]).as_matrix()
    assert_allclose(rotations_from_angles(angles), expected, atol=1e-12)


@given(vectors(np.pi))
def test_x_and_z_alone_say_where_a_part_points(angles):
    x, _, z = angles
    direction = rotations_from_angles(angles) @ (0.0, 1.0, 0.0)
    expected = (-np.sin(z), np.cos(x) * np.cos(z), np.sin(x) * np.cos(z))
    assert_allclose(direction, expected, atol=1e-12)


@given(vectors(1.0))
def test_angles_come_back(shares):
    angles = shares * (3.1, 3.1, 1.55)  # z within 90 degrees, where the angles are unique
    assert_allclose(angles_from_rotations(rotations_from_angles(angles)), angles, atol=1e-9)


@given(rotations())
def test_every_rotation_has_angles(R):
    assume(abs(R[0, 1]) < 1.0 - 1e-9)  # at z = +-90 degrees x and y cannot be told apart
    assert_allclose(rotations_from_angles(angles_from_rotations(R)), R, atol=1e-6)


@given(vectors(10.0))
def test_rodrigues_formula_agrees_with_scipy(vector):
    expected = Rotation.from_rotvec(vector).as_matrix()
    assert_allclose(rotations_from_vectors(vector), expected, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1.1e-8, 1e-5])
def test_small_turns_are_exact(angle):
    vector = angle * np.array([0.6, 0.0, -0.8])
    expected = Rotation.from_rotvec(vector).as_matrix()
    assert_allclose(rotations_from_vectors(vector), expected, rtol=0, atol=1e-15)
    assert_allclose(vectors_from_rotations(expected), vector, rtol=1e-6, atol=1e-16)


@given(vectors(1.75))
def test_vectors_come_back(vector):
    assume(np.linalg.norm(vector) < 3.1)
    assert_allclose(vectors_from_rotations(rotations_from_vectors(vector)), vector, atol=1e-9)


def test_batches_are_many_single_ones():
    vectors_rad = np.random.default_rng(1).normal(size=(4, 5, 3))
    for function in (rotations_from_angles, rotations_from_vectors, skew):
        batch = function(vectors_rad)
        assert batch.shape == (4, 5, 3, 3)
        assert_allclose(batch[2, 3], function(vectors_rad[2, 3]), atol=1e-15)
    Rs = rotations_from_vectors(vectors_rad)
    assert_allclose(vectors_from_rotations(Rs)[2, 3], vectors_from_rotations(Rs[2, 3]))
    assert_allclose(transform(Rs, vectors_rad)[2, 3], transform(Rs[2, 3], vectors_rad[2, 3]))


@given(rotations(), rotations())
def test_the_nearest_rotation_is_one_and_no_other_is_nearer(R, other):
    assert_allclose(nearest_rotations(3.0 * R), R, atol=1e-9)
    M = 2.0 * R + np.diag([0.3, -0.2, 0.1])
    nearest = nearest_rotations(M)
    assert_allclose(nearest @ nearest.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(nearest) == pytest.approx(1.0)
    assert np.linalg.norm(M - nearest) <= np.linalg.norm(M - other) + 1e-9


@pytest.mark.parametrize("way", [(0.3, -0.5, 0.8), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)])
def test_the_shortest_turn_has_an_axis_across_both_directions(way):
    start, end = np.array([0.0, 0.0, 1.0]), unit(np.array(way))
    R = shortest_turns(start, end)
    assert_allclose(R @ start, end, atol=1e-12)
    assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert np.trace(R) == pytest.approx(1.0 + 2.0 * start @ end)  # the angle is that between them


def test_shortest_turns_of_many_are_those_of_each():
    rng = np.random.default_rng(1)
    starts, ends = unit(rng.normal(size=(2, 3))), unit(rng.normal(size=(5, 2, 3)))
    ends[1, 1], ends[2, 0] = -starts[1], np.nan
    turns = shortest_turns(starts, ends)
    assert np.isnan(turns[2, 0]).all()
    for n in (0, 1, 3, 4):
        for k in range(2):
            assert_allclose(turns[n, k], shortest_turns(starts[k], ends[n, k]), atol=1e-12)
            assert_allclose(turns[n, k] @ starts[k], ends[n, k], atol=1e-12)


@given(vectors(5.0), vectors(5.0))
def test_skew_is_the_cross_product(a, b):
    assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-12)


@given(rigid_motions(5.0), rigid_motions(5.0), vectors(5.0))
def test_transforms_compose_and_undo(T_a_b, T_b_c, point_c):
    p_c = np.append(point_c, 1.0)
    R, origin = T_a_b[:3, :3], T_a_b[:3, 3]
    p_b = T_b_c @ p_c
    assert_allclose((T_a_b @ T_b_c) @ p_c, np.append(R @ p_b[:3] + origin, 1.0), atol=1e-12)
    assert_allclose(transform(R.T, -R.T @ origin) @ T_a_b, np.eye(4), atol=1e-12)


@given(vectors(5.0))
def test_unit_keeps_the_direction(vector):
    length = np.linalg.norm(vector)
    assume(length == 0.0 or length > 1e-100)
    assert_allclose(unit(vector) * length, vector, atol=1e-12)
    assert_allclose(np.linalg.norm(unit(vector)), float(length > 0))


@given(vectors(5.0), vectors(1.0).filter(lambda v: np.linalg.norm(v) > 0.1))
def test_a_horizontal_vector_has_no_height_and_loses_nothing_else(vector, upwards):
    up = unit(upwards)
    along_floor = horizontal(vector, up)
    assert abs(along_floor @ up) < 1e-12
    assert_allclose(np.cross(vector - along_floor, up), 0.0, atol=1e-12)
