"""Which way somebody faces, over time."""

from __future__ import annotations

import numpy as np
import pytest

from rendered_bodies import MODEL, UP, joints_of
from topview.filter.turning import N_YAWS, RATES_RAD, turned_on
from topview.track.methods.topview.yaw_belief import YawBelief, trunk_yaws
from topview.track.stances import STANDING, stand

EVIDENCE = 0.1
SIGMAS_RAD = np.radians((9.0, 9.0))
HEAD_AHEAD = np.array([0.0, -0.5, 2.6])


@pytest.mark.parametrize("yaw_deg", [-170.0, -90.0, -20.0, 0.0, 45.0, 130.0])
def test_a_trunk_turns_as_the_body_does(yaw_deg):
    facing, turned = (
        joints_of(stand(MODEL, HEAD_AHEAD, STANDING, np.radians(deg), UP)) for deg in (0.0, yaw_deg)
    )
    yaws_rad, _ = trunk_yaws(np.stack([facing, turned]), np.full((2, 16, 3), 0.02))
    assert abs(np.degrees(yaws_rad[0])) < 0.5
    off_rad = np.abs(yaws_rad[1]) - np.abs(np.radians(yaw_deg))
    assert abs(np.degrees(off_rad)) < 0.5


def test_surer_joints_tell_a_surer_yaw_and_none_tell_none():
    places = np.repeat(joints_of(stand(MODEL, HEAD_AHEAD, STANDING, 0.7, UP))[None], 3, axis=0)
    scales_m = np.stack([np.full((16, 3), scale_m) for scale_m in (0.02, 0.04, np.inf)])
    _, (sure, unsure, unknown) = trunk_yaws(places, scales_m)
    assert unsure == pytest.approx(2.0 * sure)
    assert unknown == np.inf


def test_whoever_turns_round_goes_on_turning_though_the_weights_say_otherwise():
    """The first mode is the mirror image of the true yaw from the side view on."""
    belief, likely = YawBelief(EVIDENCE), np.zeros(2)
    for yaw_deg in np.arange(0.0, 160.0, 4.0):
        past = yaw_deg > 90.0
        yaws_rad = np.radians((180.0 - yaw_deg if past else yaw_deg, yaw_deg))
        weights = np.array((0.9, 0.1) if past else (0.5, 0.5))
        likely = belief.update(yaws_rad, SIGMAS_RAD, weights, weights, 1 / 30)
    assert likely[1] > 0.8  # by the weights alone it were below 0.1


def test_weights_tell_between_modes_that_face_alike():
    weights = np.array((0.3, 0.7))
    likely = YawBelief(EVIDENCE).update(np.ones(2), SIGMAS_RAD, weights, weights, 0.0)
    np.testing.assert_allclose(likely, weights)


def test_after_a_long_time_anybody_may_face_any_way():
    yaws_rad, sure = np.radians((0.0, 180.0)), np.array((0.99, 0.01))
    belief = YawBelief(EVIDENCE)
    for _ in range(30):
        belief.update(yaws_rad, SIGMAS_RAD, sure, sure, 1 / 30)
    again = belief.update(yaws_rad, SIGMAS_RAD, sure[::-1], sure[::-1], 60.0)
    first = YawBelief(EVIDENCE).update(yaws_rad, SIGMAS_RAD, sure[::-1], sure[::-1], 0.0)
    np.testing.assert_array_equal(again, first)


@pytest.mark.parametrize("frames", [0.0, 0.5, 1.0, 6.0, 30.0])
def test_turning_on_keeps_a_belief_one(frames):
    belief = np.zeros((len(RATES_RAD), N_YAWS))
    belief[3, 7] = 1.0
    moved = turned_on(belief, frames)
    assert moved.sum() == pytest.approx(1.0)
    assert (moved >= 0.0).all()
