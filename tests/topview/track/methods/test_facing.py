"""Front or back: the twin that is turned round, and what tells which of the two is true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rendered_bodies import MODEL, UP, evidence_of, standing_pose
from topview.body.parts import LEFT_FOREARM, RIGHT_FOREARM
from topview.geometry.rotations import rotations_from_angles
from topview.track.methods.topview.facing import Facing, FacingSettings
from topview.track.pose import OTHER_SIDE, Pose
from topview.track.run import track_recording
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.sim import scene_by_name

yaws = st.floats(-np.pi, np.pi)


def walking(pose: Pose, direction: np.ndarray, metres: float, facing: Facing) -> None:
    for way_m in np.linspace(0.0, metres, 30):
        facing.step(Pose(pose.neck_camera + way_m * direction, pose.Rs), UP)


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


@given(yaws)
def test_people_walk_to_their_front(yaw_rad):
    pose = standing_pose(yaw_rad)
    front, right = pose.Rs[1][:, 2], pose.Rs[1][:, 0]
    facing, reversed_facing, aside = (Facing(FacingSettings()) for _ in range(3))
    walking(pose, front, 1.0, facing)
    walking(pose, -front, 1.0, reversed_facing)
    walking(pose, right, 1.0, aside)
    assert facing.belief > 1.0
    assert reversed_facing.belief < -1.0
    assert aside.belief == 0.0


def test_joints_that_would_bend_the_wrong_way_tell_the_front():
    """With elbows bent to the front, and the head over the trunk."""
    pose = standing_pose(0.0)
    Rs = pose.relative()
    for forearm in (LEFT_FOREARM, RIGHT_FOREARM):
        Rs[forearm] = rotations_from_angles(np.radians([80.0, 0.0, 0.0]))
    pose = Pose.from_relative(pose.neck_camera, Rs)
    evidence = evidence_of(pose)
    right, wrong = Facing(FacingSettings(frontal=0.0)), Facing(FacingSettings(frontal=0.0))
    right.look(pose, pose.turned_round(), MODEL, evidence)
    wrong.look(pose.turned_round(), pose, MODEL, evidence)
    assert right.belief > wrong.belief + 1.0


def test_the_head_is_carried_before_the_trunk():
    pose = standing_pose(0.0)
    evidence = evidence_of(pose)
    beliefs = []
    for before_m in (-0.06, 0.0, 0.06):
        head = evidence.head_camera + before_m * pose.Rs[1][:, 2]
        facing = Facing(FacingSettings())
        facing.look(pose, pose.turned_round(), MODEL, replace(evidence, head_camera=head))
        beliefs.append(facing.belief)
    assert beliefs[0] < beliefs[1] < beliefs[2]


def test_a_face_that_is_seen_tells_who_faces_the_camera():
    evidence = evidence_of(standing_pose(0.0))
    beliefs = {}
    for yaw_rad in (0.0, np.pi):
        pose = standing_pose(yaw_rad)
        for share in (0.0, None, 1.0):
            facing = Facing(FacingSettings())
            seen = replace(evidence, face_share=share, head_is_seen=False)
            facing.look(pose, pose.turned_round(), MODEL, seen)
            beliefs[yaw_rad, share] = facing.belief
    assert beliefs[0.0, 0.0] < beliefs[0.0, None] < beliefs[0.0, 1.0]
    assert beliefs[np.pi, 0.0] > beliefs[np.pi, None] > beliefs[np.pi, 1.0]


@given(st.lists(st.sampled_from([-1.0, 1.0]), max_size=40))
def test_belief_stays_within_what_can_be_overturned(ways):
    settings = FacingSettings()
    facing, pose = Facing(settings), standing_pose(0.0)
    facing.step(pose, UP)
    for way in ways:
        pose = Pose(pose.neck_camera + way * 0.3 * pose.Rs[1][:, 2], pose.Rs)
        facing.step(pose, UP)
        assert abs(facing.belief) <= settings.surest


@pytest.mark.slow
def test_somebody_first_seen_in_profile_is_turned_round():
    """He walks along behind; the start takes him to face the other way."""
    recording = RecordingWithTruth(scene_by_name("walk", seed=503, frames=45))
    skeletons = track_recording(recording).skeletons
    left, right = (skeletons.joint_names.index(f"{side}_shoulder") for side in ("left", "right"))
    across = skeletons.joints_camera[-1, 0, right] - skeletons.joints_camera[-1, 0, left]
    truth = recording.reference()
    columns = [truth.joint_names.index(f"{side}_shoulder") for side in ("left", "right")]
    true_left, true_right = truth.joints_camera[-1, 0, columns]
    assert across @ (true_right - true_left) > 0.0
