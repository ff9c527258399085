"""Elbows on their circle, hypotheses that are spread, and limbs as hinges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from topview.body.parts import LEFT_UPPER_ARM, RIGHT_UPPER_LEG
from topview.geometry.rotations import rotations_from_vectors, unit
from topview.kernels.body import STRAIGHT
from topview.track.elbows import elbows_on_circle, limb_rotations, spread_points
from topview.track.pose import HINGE_BENDS

lengths = st.floats(0.15, 0.4)
palms = arrays(np.float64, 3, elements=st.floats(-0.8, 0.8))
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.2)
SHOULDER = np.array([0.2, -0.3, 2.5])
TURNS = 8


def elbows_and_ends(palm, upper_m, lower_m):
    """[8, 3] each, relative to the shoulder."""
    axes = elbows_on_circle(SHOULDER, SHOULDER + palm[None], upper_m, lower_m, TURNS)
    assert_allclose(np.linalg.norm(axes, axis=-1), 1.0)
    elbows = upper_m * axes[:, 0]
    return elbows, elbows + lower_m * axes[:, 1]


@given(palms, lengths, lengths)
def test_a_palm_within_reach_is_reached_through_every_elbow(palm, upper_m, lower_m):
    """Eq. 5.4 - 5.6."""
    reach = np.linalg.norm(palm)
    assume(abs(upper_m - lower_m) + 0.02 < reach < 0.998 * (upper_m + lower_m))
    elbows, ends = elbows_and_ends(palm, upper_m, lower_m)
    assert_allclose(ends, np.broadcast_to(palm, ends.shape), atol=1e-9)
    # the circle: about the line from shoulder to palm, in the plane at i along it
    along = (reach**2 + upper_m**2 - lower_m**2) / (2 * reach)
    assert_allclose(elbows @ palm / reach, along, atol=1e-9)
    assert_allclose(elbows.mean(0), along * palm / reach, atol=1e-9)


@given(palms, lengths, lengths)
def test_elsewhere_the_end_comes_as_near_as_the_limb_allows(palm, upper_m, lower_m):
    reach = np.linalg.norm(palm)
    assume(reach > 1e-3)
    _, ends = elbows_and_ends(palm, upper_m, lower_m)
    span = np.clip(reach, abs(upper_m - lower_m) + 0.02, 0.998 * (upper_m + lower_m))
    assert_allclose(ends, np.broadcast_to(span * palm / reach, ends.shape), atol=1e-9)


def test_palms_are_taken_in_turn():
    two = SHOULDER + np.array([[0.3, 0.0, 0.0], [0.0, 0.3, 0.1]])
    axes = elbows_on_circle(SHOULDER, two, 0.3, 0.25, TURNS)
    assert axes.shape == (2 * TURNS, 2, 3)
    for k in (0, 1):
        alone = elbows_on_circle(SHOULDER, two[[k]], 0.3, 0.25, TURNS)
        assert_array_equal(axes[k * TURNS : (k + 1) * TURNS], alone)


@given(st.integers(0, 30), st.integers(1, 10), st.integers(0, 2**32 - 1))
def test_spread_points_are_some_of_the_points_and_far_apart(n, count, seed):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    taken = spread_points(points, np.zeros(3), count)
    assert len(taken) == min(n, count)
    assert all((points == point).all(1).any() for point in taken)
    assert len(np.unique(taken, axis=0)) == len(taken)
    if len(taken):
        assert np.linalg.norm(taken[0]) == pytest.approx(np.linalg.norm(points, axis=1).max())


@pytest.mark.parametrize("upper", [LEFT_UPPER_ARM, RIGHT_UPPER_LEG], ids=["arm", "leg"])
@given(upper_axis=directions, lower_axis=directions)
def test_a_limb_is_a_hinge_that_bends_the_right_way(upper, upper_axis, lower_axis):
    axes = unit(np.array([upper_axis, lower_axis]))
    assume(np.abs(axes[:, 0]).max() < 0.99)  # who is straight along the parent's x has no side
    Rs = limb_rotations(axes, np.eye(3), upper)
    assert_allclose(Rs[..., 1], axes)
    assert_allclose(Rs @ np.swapaxes(Rs, -1, -2), np.broadcast_to(np.eye(3), Rs.shape), atol=1e-7)
    assert_allclose(np.linalg.det(Rs), 1.0)
    if np.linalg.norm(np.cross(*axes)) > STRAIGHT:
        flexion = Rs[0].T @ Rs[1]
        assert_allclose(flexion[0], [1.0, 0.0, 0.0], atol=1e-9)
        assert np.sign(flexion[2, 1]) == HINGE_BENDS[upper]


def test_a_straight_limb_keeps_its_parents_side():
    R_parent = rotations_from_vectors(np.array([0.3, -0.8, 0.5]))
    straight = np.repeat(R_parent[None, :, 1], 2, axis=0)
    assert_allclose(limb_rotations(straight, R_parent, LEFT_UPPER_ARM), [R_parent, R_parent])
