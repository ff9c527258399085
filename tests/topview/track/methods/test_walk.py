"""Somebody who comes to be hidden goes on as before for a while."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rendered_bodies import UP, evidence_of, standing_pose
from topview.body.parts import UPPER_TORSO
from topview.geometry.rotations import rotations_from_vectors
from topview.track.methods.topview.walk import FADED_S, SEEN_S, Walk
from topview.track.pose import Pose
from topview.track.stances import heading

STEP_S = 1 / 30
VELOCITY = np.array([1.2, 0.0, -0.3])  # metres a second
TURNING_RAD_S = np.radians(60.0)
SEEN = evidence_of(standing_pose())
HEAD_HIDDEN = replace(SEEN, head_is_seen=False)


def walked(pose: Pose, elapsed_s: float) -> Pose:
    turn = rotations_from_vectors((elapsed_s * TURNING_RAD_S * UP)[None])[0]
    return Pose(pose.neck_camera + elapsed_s * VELOCITY, turn @ pose.Rs)


def watched(seconds: float = 1.0, step_s: float = STEP_S) -> tuple[Walk, Pose]:
    """Somebody who has walked and turned in sight, and the last pose."""
    walk, pose = Walk(), standing_pose()
    for _ in range(round(seconds / step_s)):
        before, pose = pose, walked(pose, step_s)
        walk.update(before, pose, UP, step_s)
    return walk, pose


def yaw(pose: Pose) -> float:
    return heading(pose.Rs[UPPER_TORSO], UP)


def test_who_was_not_seen_to_move_stays() -> None:
    walk, pose = Walk(), standing_pose()
    walk.update(pose, pose, UP, STEP_S)
    after = walk.goes_on(pose, HEAD_HIDDEN, 1.0)
    assert_allclose(after.neck_camera, pose.neck_camera)
    assert_allclose(after.Rs, pose.Rs, atol=1e-12)


def test_who_walked_and_turned_goes_on_so() -> None:
    walk, pose = watched()
    after, expected = walk.goes_on(pose, HEAD_HIDDEN, STEP_S), walked(pose, STEP_S)
    assert_allclose(after.neck_camera, expected.neck_camera, atol=0.003)
    assert yaw(after) - yaw(pose) == pytest.approx(yaw(expected) - yaw(pose), rel=0.05)


def test_a_walk_fades() -> None:
    walk, pose = watched()
    after = pose
    for _ in range(300):
        after = walk.goes_on(after, HEAD_HIDDEN, STEP_S)
    assert_allclose(after.neck_camera - pose.neck_camera, FADED_S * VELOCITY, atol=0.02)
    assert yaw(after) == pytest.approx(yaw(walked(pose, FADED_S)), abs=0.03)
    assert_allclose(
        walk.goes_on(after, HEAD_HIDDEN, STEP_S).neck_camera, after.neck_camera, atol=1e-4
    )


def test_it_ends_where_the_head_is_seen_to_stop() -> None:
    walk, pose = watched()
    walk.look_back(SEEN)
    after = pose
    for _ in range(60):
        after = walk.goes_on(after, SEEN, STEP_S)
        walk.look_back(SEEN)
    too_far_m = np.linalg.norm(after.neck_camera - pose.neck_camera)
    assert too_far_m < SEEN_S * np.linalg.norm(VELOCITY)


def test_who_sets_out_while_hidden_goes_where_the_head_goes() -> None:
    walk, pose, head_camera = Walk(), standing_pose(), SEEN.head_camera
    for frame in range(60):
        seen = replace(SEEN, head_camera=head_camera + frame * STEP_S * VELOCITY)
        pose = walk.goes_on(pose, seen, STEP_S)
        walk.look_back(seen)
    way = pose.neck_camera - standing_pose().neck_camera
    assert 0.6 < way @ VELOCITY / (VELOCITY @ VELOCITY) / (60 * STEP_S) < 1.0


def test_a_head_that_was_not_seen_a_frame_ago_tells_no_way() -> None:
    walk, pose = Walk(), standing_pose()
    walk.look_back(HEAD_HIDDEN)
    moved = replace(SEEN, head_camera=SEEN.head_camera + 1.0)
    assert_allclose(walk.goes_on(pose, moved, STEP_S).neck_camera, pose.neck_camera)


def test_it_does_not_depend_on_how_often_frames_come() -> None:
    places = []
    for step_s in (STEP_S, 3 * STEP_S):
        walk, pose = watched(1.5, step_s)
        for _ in range(round(0.6 / step_s)):
            pose = walk.goes_on(pose, HEAD_HIDDEN, step_s)
        places.append(pose.neck_camera)
    assert_allclose(*places, atol=0.005)
