"""What is tried of a body of whom no joints are proposed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import standing_pose
from topview.body.parts import PARTS, UPPER_TORSO
from topview.filter.particles import generator
from topview.geometry.rotations import vectors_from_rotations
from topview.track.methods.topview.lookup import SHARES
from topview.track.methods.topview.search import (
    LEGS_EVERY,
    TRUNK_DRAWN_M,
    TRUNK_DRAWN_RAD,
    TRUNKS,
    UPPER_ARMS,
    UPPER_LEGS,
    drawn_trunks,
    limbs_in_turn,
)
from topview.track.methods.topview.usual_limbs import usual_limbs
from topview.track.pose import LIMBS, MIRRORED, OTHER_SIDE, TRUNK_PARTS


def test_trunks_are_drawn_round_where_they_are_and_all_else_keeps_its_directions():
    pose = standing_pose()
    others = [part for part in range(len(PARTS)) if part not in TRUNK_PARTS]
    turns, moves = [], []
    for frame in range(200):
        drawn = drawn_trunks(pose, generator(0, 1, UPPER_TORSO, frame))
        assert len(drawn) == TRUNKS
        for one in drawn:
            assert_array_equal(one.Rs[others], pose.Rs[others])
            turns.append(
                vectors_from_rotations(
                    np.swapaxes(pose.Rs, 1, 2)[TRUNK_PARTS] @ one.Rs[TRUNK_PARTS]
                )
            )
            moves.append(one.neck_camera - pose.neck_camera)
    assert np.abs(np.std(turns, axis=0) / TRUNK_DRAWN_RAD - 1.0).max() < 0.1
    assert np.abs(np.std(moves, axis=0) / TRUNK_DRAWN_M - 1.0).max() < 0.1


@pytest.mark.parametrize(
    ("uppers", "frames"), [(UPPER_ARMS, SHARES), (UPPER_LEGS, LEGS_EVERY * SHARES)]
)
def test_all_that_a_limb_does_is_looked_at_once_in_so_many_frames(uppers, frames):
    for upper in uppers:
        for first in range(3):
            shares = [limbs_in_turn(first + frame).get(upper) for frame in range(frames)]
            looked_at = np.concatenate([own for own in shares if own is not None])
            assert len(looked_at) == len(usual_limbs(upper))
            assert len(np.unique(looked_at, axis=0)) == len(np.unique(usual_limbs(upper), axis=0))


def test_of_a_first_pose_all_limbs_are_looked_at():
    limbs = limbs_in_turn(None)
    assert set(limbs) == set(LIMBS)
    for upper, looked_at in limbs.items():
        assert_array_equal(looked_at, usual_limbs(upper))


def test_of_both_sides_the_same_is_looked_at():
    for frame in range(LEGS_EVERY * SHARES):
        limbs = limbs_in_turn(frame)
        for upper, looked_at in limbs.items():
            assert_allclose(limbs[OTHER_SIDE[upper]], MIRRORED @ looked_at @ MIRRORED)
