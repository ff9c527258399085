"""What is tried of a body of whom no joints are proposed."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_array_equal

from rendered_bodies import standing_pose
from topview.body.parts import LOWER_TORSO, PARTS, UPPER_TORSO
from topview.filter.particles import generator
from topview.geometry.rotations import vectors_from_rotations
from topview.track.methods.topview.search import (
    TRUNK_DRAWN_M,
    TRUNK_DRAWN_RAD,
    TRUNKS,
    drawn_trunks,
)

TRUNK = [UPPER_TORSO, LOWER_TORSO]


def test_trunks_are_drawn_round_where_they_are_and_all_else_keeps_its_directions():
    pose = standing_pose()
    others = [part for part in range(len(PARTS)) if part not in TRUNK]
    turns, moves = [], []
    for frame in range(200):
        drawn = drawn_trunks(pose, generator(0, 1, UPPER_TORSO, frame))
        assert len(drawn) == TRUNKS
        for one in drawn:
            assert_array_equal(one.Rs[others], pose.Rs[others])
            turns.append(vectors_from_rotations(np.swapaxes(pose.Rs, 1, 2)[TRUNK] @ one.Rs[TRUNK]))
            moves.append(one.neck_camera - pose.neck_camera)
    assert np.abs(np.std(turns, axis=0) / TRUNK_DRAWN_RAD - 1.0).max() < 0.1
    assert np.abs(np.std(moves, axis=0) / TRUNK_DRAWN_M - 1.0).max() < 0.1
