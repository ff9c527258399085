"""Elbows on their circle, and hypotheses that are spread."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from topview.track.elbows import elbows_on_circle, spread_points

lengths = st.floats(0.15, 0.4)
palms = arrays(np.float64, 3, elements=st.floats(-0.8, 0.8))
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
