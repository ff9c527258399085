"""Limits of many hypotheses against the body's own definition."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from topview.body.limits import LIMITS_RAD, direction_excess_rad, excess_rad
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, LOWER_TORSO, PARTS, RIGHT_LOWER_LEG
from topview.geometry.rotations import unit
from topview.kernels.limits import bend_about_hinge, hinge_excess, part_excess
from topview.track.pose import HINGE_BENDS

RNG = np.random.default_rng(5)
RS = Rotation.from_quat(RNG.normal(size=(200, 4))).as_matrix()
R_TORSO, R_UPPER = Rotation.from_quat(RNG.normal(size=(2, 4))).as_matrix()


@pytest.mark.parametrize("part", [LOWER_TORSO, LEFT_UPPER_ARM])
def test_parts_leave_their_limits_as_the_definition_says(part):
    with_turn, without = np.empty((2, len(RS)))
    part_excess(RS, R_TORSO, LIMITS_RAD[part], True, with_turn)
    part_excess(RS, R_TORSO, LIMITS_RAD[part], False, without)
    assert_allclose(with_turn, excess_rad(part, R_TORSO.T @ RS), atol=1e-9)
    assert_allclose(without, direction_excess_rad(part, R_TORSO.T @ RS), atol=1e-9)
    assert (without < with_turn).any()


@pytest.mark.parametrize("part", [LEFT_FOREARM, RIGHT_LOWER_LEG])
def test_a_hinge_turns_the_part_above_it(part):
    upper, known_bend = PARTS[part].parent, 0.1
    bend, most = HINGE_BENDS[upper], float(np.abs(LIMITS_RAD[part, 0]).max())
    found = np.empty(len(RS))
    hinge_excess(RS, R_UPPER, R_TORSO, LIMITS_RAD[upper], most, bend, known_bend, found)
    ys = np.broadcast_to(R_UPPER[:, 1], (len(RS), 3))
    xs = unit(bend * np.cross(ys, RS[:, :, 1]) + known_bend * R_UPPER[:, 0])
    turned = np.stack([xs, ys, np.cross(xs, ys)], axis=2)
    flexion = np.arccos(np.clip((ys * RS[:, :, 1]).sum(1), -1.0, 1.0))
    expected = excess_rad(upper, R_TORSO.T @ turned) + np.maximum(flexion - most, 0.0)
    assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("part", [LEFT_FOREARM, RIGHT_LOWER_LEG])
def test_both_parts_of_a_limb_share_its_hinge(part):
    bend, known_bend = HINGE_BENDS[PARTS[part].parent], 0.1
    for R in RS[:50]:
        upper, lower = R_UPPER.copy(), R.copy()
        bend_about_hinge(upper, lower, bend, known_bend)
        for before, after in ((R_UPPER, upper), (R, lower)):
            assert_allclose(after[:, 1], before[:, 1])
            assert_allclose(after.T @ after, np.eye(3), atol=1e-12)
        hinge = unit(bend * np.cross(R_UPPER[:, 1], R[:, 1]) + known_bend * R_UPPER[:, 0])
        assert_allclose(upper[:, 0], hinge, atol=1e-12)
        assert_allclose(lower[:, 0], unit(hinge - (hinge @ R[:, 1]) * R[:, 1]), atol=1e-12)


def test_a_straight_limb_without_a_hinge_stays_as_it_is():
    upper, lower = R_UPPER.copy(), R_UPPER.copy()
    bend_about_hinge(upper, lower, 1.0, 0.0)
    assert_allclose([upper, lower], [R_UPPER, R_UPPER])
