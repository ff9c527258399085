"""Laws of the limits on the joints."""

from __future__ import annotations

import numpy as np
import pytest
from body_strategies import rotations
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from topview.body.limits import (
    ANATOMICAL_LIMITS_RAD,
    HIP_FLEXION_RAD,
    KNEE_FLEXION_RAD,
    LIMITS_RAD,
    angles_rad,
    direction_excess_rad,
    excess_rad,
)
from topview.body.parts import LEFT_LOWER_LEG, LEFT_UPPER_LEG, PART_NAMES, PARTS
from topview.geometry.rotations import rotations_from_angles

parts = st.integers(1, len(PARTS) - 1)
shares = st.tuples(*[st.floats(0.0, 1.0)] * 3)


def index_of(name: str) -> int:
    return PART_NAMES.index(name)


@pytest.mark.parametrize("part", range(len(PARTS)), ids=PART_NAMES)
def test_at_rest_every_part_is_within_its_limits(part):
    assert excess_rad(part, np.eye(3)) == 0.0


@example(part=3, share=(0.0, 0.5, 1.0))  # z at its limit of 180 degrees, which -180 is too
@example(part=5, share=(0.0, 0.5, 0.0))
@given(parts, shares)
def test_within_the_limits_there_is_no_excess(part, share):
    low, high = np.array(PARTS[part].limits_rad).T
    angles = low + np.array(share) * (high - low)
    if abs(abs(angles[2]) - np.pi / 2) < 1e-4:  # x and y cannot be told apart there
        angles[2] = 0.0
    assert excess_rad(part, rotations_from_angles(angles)) == pytest.approx(0.0, abs=1e-6)


def test_a_little_beyond_half_a_turn_is_a_little_beyond():
    """An arm raised to the front is limited to 180 degrees: 190 is 10 too many, not 130 too few."""
    raised = rotations_from_angles(np.radians([190.0, 0.0, 0.0]))
    assert excess_rad(index_of("left_upper_arm"), raised) == pytest.approx(np.radians(10))
    assert_allclose(angles_rad(index_of("left_upper_arm"), raised), np.radians([190, 0, 0]))


@given(parts, rotations(1))
def test_angles_are_those_of_the_rotation_and_told_around_the_limits(part, R):
    angles = angles_rad(part, R)
    assert_allclose(rotations_from_angles(angles), R, atol=1e-6)
    assert (np.abs(angles - LIMITS_RAD[part].mean(-1)) <= np.pi + 1e-9).all()


@given(parts, rotations(1))
def test_excess_is_never_negative_and_zero_for_the_free_head(part, R):
    assert excess_rad(part, R)[0] >= 0.0
    assert excess_rad(0, R)[0] == 0.0


@given(
    st.sampled_from(
        [
            ("left_forearm", 0, 160),
            ("right_forearm", 0, -10),
            ("left_lower_leg", 0, 10),
            ("right_lower_leg", 0, -100),
            ("left_upper_arm", 0, -60),
            ("right_upper_leg", 0, 100),
            ("left_upper_leg", 2, -10),
            ("right_upper_arm", 2, 10),
            ("upper_torso", 0, 60),
            ("upper_torso", 2, -45),
            ("lower_torso", 1, 30),
        ]
    ),
    st.floats(0.1, 19.0),
)
def test_beyond_a_limit_the_excess_is_how_far_beyond(case, degrees):
    name, axis, limit = case
    angles = np.zeros(3)
    angles[axis] = np.radians(limit + np.copysign(degrees, limit))
    excess = excess_rad(index_of(name), rotations_from_angles(angles))
    assert excess == pytest.approx(np.radians(degrees), abs=1e-9)


@pytest.mark.parametrize(("degrees", "excess"), [(5, 0), (60, 50), (95, 85), (150, 30), (180, 0)])
def test_an_arm_may_be_raised_to_its_own_side_up_to_the_vertical(degrees, excess):
    """The other arm gets there across the chest, or over the head, whichever is nearer."""
    raised = rotations_from_angles(np.radians([0.0, 0.0, degrees]))
    assert excess_rad(index_of("left_upper_arm"), raised) == pytest.approx(0.0, abs=1e-9)
    beyond = excess_rad(index_of("right_upper_arm"), raised)
    assert beyond == pytest.approx(np.radians(excess), abs=1e-9)


def test_hinges_turn_about_x_alone():
    for name in ("left_forearm", "right_lower_leg"):
        for angles in ((0.0, 0.3, 0.0), (0.0, 0.0, 0.3)):
            excess = excess_rad(index_of(name), rotations_from_angles(np.array(angles)))
            assert excess == pytest.approx(0.3)


@given(parts, rotations(4))
def test_batches_are_many_single_ones(part, Rs):
    assert_allclose(excess_rad(part, Rs), [excess_rad(part, R) for R in Rs])


@pytest.mark.parametrize("name", ["left_upper_arm", "right_upper_leg"])
@given(rotations(1))
def test_a_direction_is_within_the_limits_if_some_turn_about_the_own_axis_is(name, R):
    turns = np.zeros((8, 3))
    turns[:, 1] = np.arange(8) * np.pi / 4
    turned = R @ rotations_from_angles(turns)
    part = index_of(name)
    assert_allclose(direction_excess_rad(part, R), excess_rad(part, turned).min(), atol=1e-9)


def test_by_anatomy_hips_and_knees_alone_bend_farther_than_in_the_table() -> None:
    farther = ANATOMICAL_LIMITS_RAD != LIMITS_RAD
    assert {PART_NAMES[part] for part in np.flatnonzero(farther.any((1, 2)))} == {
        f"{side}_{half}_leg" for side in ("left", "right") for half in ("upper", "lower")
    }
    assert (np.ptp(ANATOMICAL_LIMITS_RAD, axis=-1) >= np.ptp(LIMITS_RAD, axis=-1)).all()
    assert_allclose(ANATOMICAL_LIMITS_RAD[LEFT_UPPER_LEG, 0, 1], HIP_FLEXION_RAD)
    assert_allclose(ANATOMICAL_LIMITS_RAD[LEFT_LOWER_LEG, 0, 0], -KNEE_FLEXION_RAD)
