"""Which way somebody faces: the twin that is turned round, and which of the two is true."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, UP, evidence_of, standing_pose
from topview.body.parts import UPPER_TORSO
from topview.track.methods.topview.facing import FacingBelief
from topview.track.methods.topview.lookup import FACING_GRID, Likeness, shipped_poses
from topview.track.pose import OTHER_SIDE, Pose
from topview.track.stances import facing, heading

yaws = st.floats(-np.pi, np.pi)
HEAD_CAMERA = np.array([0.1, -0.5, 2.6])
FRAME_S = 1 / 30


def cost_of(belief: FacingBelief, pose: Pose) -> float:
    return float(belief.costs(pose.Rs[UPPER_TORSO][None], UP)[0])


def alike(pose: Pose) -> Likeness:
    return shipped_poses().likeness(evidence_of(pose), MODEL.stature_m)


def captured(yaw_rad: float, index: int = 1100) -> Pose:
    """One of the table, which faces so."""
    R = shipped_poses().Rs[index]
    to_camera_rad = heading(R[UPPER_TORSO], -FACING_GRID[1])
    return Pose.below_head(
        HEAD_CAMERA, facing(yaw_rad - to_camera_rad, UP) @ FACING_GRID.T @ R, MODEL
    )


@given(yaws)
def test_whoever_is_turned_round_fills_the_same_volume_and_faces_the_other_way(yaw_rad):
    pose = standing_pose(yaw_rad)
    twin = pose.turned_round()
    assert_allclose(twin.Rs[1][:, 2], -pose.Rs[1][:, 2])
    assert_allclose(twin.origins(MODEL), pose.origins(MODEL)[list(OTHER_SIDE)], atol=1e-12)
    assert_allclose(twin.Rs[..., 1], pose.Rs[list(OTHER_SIDE)][..., 1])


@given(yaws)
def test_turned_round_twice_is_as_before(yaw_rad):
    pose = standing_pose(yaw_rad)
    assert_allclose(pose.turned_round().turned_round().Rs, pose.Rs)


@pytest.mark.parametrize("yaw_rad", [0.0, 1.2, np.pi, -2.0])
def test_who_is_seen_for_a_while_is_believed_to_face_where_they_do(yaw_rad):
    belief, pose = FacingBelief(), captured(yaw_rad)
    for _ in range(45):
        belief.update(alike(pose), FRAME_S)
    assert np.cos(belief.likeliest_rad - yaw_rad) > np.cos(np.radians(30))
    assert cost_of(belief, pose) + 0.01 < cost_of(belief, pose.turned_round())


def test_who_turns_round_is_followed():
    belief = FacingBelief()
    for yaw_rad in np.linspace(0.0, np.pi, 60):
        belief.update(alike(captured(yaw_rad)), FRAME_S)
    assert np.cos(belief.likeliest_rad - np.pi) > np.cos(np.radians(30))


def test_a_yaw_that_was_known_a_moment_ago_outweighs_a_frame():
    belief, pose = FacingBelief(), captured(0.5)
    belief.begin(pose.turned_round(), UP)
    belief.update(alike(pose), FRAME_S)
    assert cost_of(belief, pose.turned_round()) < cost_of(belief, pose)


def test_who_is_new_may_face_any_way_and_the_first_frame_tells_the_most():
    belief, pose = FacingBelief(), captured(-2.0)
    assert cost_of(belief, pose) < 0.005
    belief.update(alike(pose), 0.0)
    assert cost_of(belief, pose) + 0.02 < cost_of(belief, pose.turned_round())
