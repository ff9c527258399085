"""Limbs that are out of sight are where those of captured people are on average."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from rendered_bodies import UP, standing_pose
from topview.body.parts import (
    LEFT_FOREARM,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    PARTS,
    RIGHT_FOREARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import are_rotations
from topview.track.methods.topview.posture import N_UPRIGHT, UP_TRAITS, Known
from topview.track.methods.topview.unseen_limbs import (
    LIMB_PARTS,
    UnseenLimbs,
    shipped_unseen_limbs,
)
from topview.track.pose import MIRRORED, OTHER_SIDE, Pose, mirrored

POSE = standing_pose(0.4)
NOTHING_OUT = np.zeros(len(PARTS))
ARM = [LEFT_UPPER_ARM, LEFT_FOREARM]


def arms_ahead() -> UnseenLimbs:
    """All limbs point to the front and down, whatever the others do."""
    mean = np.zeros(N_UPRIGHT)
    mean[: UP_TRAITS.start] = np.tile((0.0, 0.3, 0.4), len(PARTS))
    return UnseenLimbs("made up", mean, np.zeros((N_UPRIGHT, N_UPRIGHT)))


def told(limbs: UnseenLimbs, out: np.ndarray, pose: Pose = POSE) -> Pose:
    return limbs.told(pose, Known(1.0 - out, UP, None))


def with_arm_out(share: float) -> np.ndarray:
    out = NOTHING_OUT.copy()
    out[ARM] = share
    return out


def test_what_is_in_sight_stays() -> None:
    assert told(arms_ahead(), NOTHING_OUT) is POSE
    after = told(arms_ahead(), with_arm_out(1.0))
    others = [part for part in range(len(PARTS)) if part not in ARM]
    assert_allclose(after.Rs[others], POSE.Rs[others], atol=1e-12)
    assert_allclose(after.neck_camera, POSE.neck_camera)


def test_a_limb_out_of_sight_points_where_people_s_do() -> None:
    after = told(arms_ahead(), with_arm_out(1.0))
    assert are_rotations(after.Rs).all()
    in_torso = after.Rs[ARM][..., 1] @ POSE.Rs[UPPER_TORSO]
    assert_allclose(in_torso, [[0.0, 0.6, 0.8]] * 2, atol=1e-9)


def test_what_is_partly_out_of_sight_goes_part_of_the_way() -> None:
    axis = POSE.Rs[LEFT_UPPER_ARM][:, 1]
    turned = [
        float(np.arccos(np.clip(told(arms_ahead(), with_arm_out(s)).Rs[3][:, 1] @ axis, -1, 1)))
        for s in (0.01, 0.3, 0.6, 1.0)
    ]
    assert turned[0] < 0.03
    assert np.all(np.diff(turned) > 0.1)


def test_what_is_measured_well_tells_of_what_is_not() -> None:
    """Two traits that are always the same: the one tells the other, unless it is measured badly."""
    one, other = 4, 13
    covariance = np.zeros((N_UPRIGHT, N_UPRIGHT))
    covariance[np.ix_([one, other], [one, other])] = 1.0
    limbs = UnseenLimbs("made up", np.zeros(N_UPRIGHT), covariance)
    measured, sigmas = np.zeros(N_UPRIGHT), np.full(N_UPRIGHT, 1e3)
    measured[one] = 0.8
    assert_allclose(limbs.expected(measured, sigmas), 0.0, atol=1e-5)
    sigmas[one] = 1e-3
    expected = limbs.expected(measured, sigmas)
    assert_allclose(expected[[one, other]], 0.8, atol=1e-5)
    assert np.count_nonzero(expected) == 2


def test_how_high_the_head_is_tells_of_legs() -> None:
    """Thighs of who is lower are more level, as far as the height is known."""
    out = NOTHING_OUT.copy()
    out[[LEFT_UPPER_LEG, LEFT_UPPER_LEG + 1]] = 1.0
    level = [
        shipped_unseen_limbs().axes(POSE, Known(1.0 - out, UP, height))[4, 2]
        for height in (0.9, None, 0.6)
    ]
    assert level[0] < level[1] < level[2]


def test_what_ships_treats_left_and_right_alike() -> None:
    out = NOTHING_OUT.copy()
    out[[*ARM, RIGHT_FOREARM, RIGHT_UPPER_LEG]] = 1.0
    in_mirror = Pose(POSE.neck_camera @ MIRRORED, mirrored(POSE.Rs[None])[0])
    after = told(shipped_unseen_limbs(), out[list(OTHER_SIDE)], in_mirror)
    assert_allclose(after.Rs, mirrored(told(shipped_unseen_limbs(), out).Rs[None])[0], atol=1e-6)


def test_legs_of_which_nothing_is_seen_stay_and_else_go_by_what_is() -> None:
    out = NOTHING_OUT.copy()
    legs = [LEFT_UPPER_LEG, LEFT_UPPER_LEG + 1, RIGHT_UPPER_LEG, RIGHT_UPPER_LEG + 1]
    out[legs] = 1.0
    assert told(arms_ahead(), out) is POSE
    out[RIGHT_UPPER_LEG] = 0.5
    half = told(arms_ahead(), out).Rs[legs[0], :, 1] @ POSE.Rs[legs[0], :, 1]
    out[RIGHT_UPPER_LEG] = 0.0
    after = told(arms_ahead(), out)
    in_torso = after.Rs[legs[:2]][..., 1] @ POSE.Rs[UPPER_TORSO]
    assert_allclose(in_torso, [[0.0, 0.6, 0.8]] * 2, atol=1e-9)
    assert after.Rs[legs[0], :, 1] @ POSE.Rs[legs[0], :, 1] < half < 1.0


def test_what_ships_lets_hidden_limbs_of_who_stands_hang() -> None:
    """But forearms, which people hold before them as often as not."""
    out = NOTHING_OUT.copy()
    out[LIMB_PARTS] = 1.0
    out[RIGHT_UPPER_LEG] = 0.0
    hang = [part for part in LIMB_PARTS if part not in (LEFT_FOREARM, RIGHT_FOREARM)]
    assert np.all(told(shipped_unseen_limbs(), out).Rs[hang][..., 1] @ -UP > 0.7)
