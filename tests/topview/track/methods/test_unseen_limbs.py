"""Limbs that are out of sight are where they are on average, as a law of the other parts."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, UP, standing_pose
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
from topview.track.methods.topview.posture import POSTURE_BLOCKS, mirrored_traits, posture_traits
from topview.track.methods.topview.unseen_limbs import (
    LIMB_PARTS,
    UnseenLimbs,
    shipped_unseen_limbs,
)
from topview.track.pose import MIRRORED, OTHER_SIDE, Pose

TRAITS = 38
POSE = standing_pose(0.4)
NOTHING_OUT = np.zeros(len(PARTS))
ARM = [LEFT_UPPER_ARM, LEFT_FOREARM]


def arms_ahead() -> UnseenLimbs:
    """All limbs point to the front and down, whatever the others do."""
    weights = np.zeros((len(LIMB_PARTS), 3, TRAITS))
    weights[:, :, 0] = (0.0, 0.3, 0.4)
    return UnseenLimbs("made up", weights, np.full(TRAITS, -9.0), np.full(TRAITS, 9.0))


def told(law: UnseenLimbs, out: np.ndarray, pose: Pose = POSE) -> Pose:
    return law.told(pose, MODEL, UP, out)


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


def test_a_limb_out_of_sight_points_where_the_law_says() -> None:
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


def test_traits_are_taken_as_no_farther_out_than_known() -> None:
    weights = np.ones((len(LIMB_PARTS), 3, TRAITS))
    law = UnseenLimbs("made up", weights, np.full(TRAITS, -0.5), np.full(TRAITS, 0.5))
    assert_allclose(law.axes(np.full(TRAITS, 9.0)), 0.5 * TRAITS)


def test_what_ships_treats_left_and_right_alike() -> None:
    law, (signs, order) = shipped_unseen_limbs(), mirrored_traits(POSTURE_BLOCKS)
    traits = posture_traits(POSE, MODEL, UP)
    in_mirror = law.axes(signs * traits[order])
    others = [LIMB_PARTS.index(OTHER_SIDE[part]) for part in LIMB_PARTS]
    assert_allclose((law.axes(traits) @ MIRRORED)[others], in_mirror, atol=1e-6)


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
