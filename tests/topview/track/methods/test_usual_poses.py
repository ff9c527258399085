"""What bodies usually do, by poses of captured motion."""

from __future__ import annotations

import numpy as np

from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, UPPER_TORSO
from topview.geometry.rotations import are_rotations, rotations_from_angles
from topview.track.methods.topview.lookup import shipped_poses
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import OTHER_SIDE, Pose

NECK_CAMERA = np.array([0.2, -0.4, 2.5])
TURN = rotations_from_angles(np.array([0.1, 2.0, -0.2]))


def some_pose(index: int = 700) -> Pose:
    return Pose(NECK_CAMERA, TURN @ shipped_poses().Rs[index])


def apart_rad(one: Pose, other: Pose, part: int) -> float:
    cosine = (np.trace(one.Rs[part].T @ other.Rs[part]) - 1.0) / 2.0
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def test_neck_and_torso_stay_and_nothing_moves_by_no_share() -> None:
    pose = some_pose()
    there, still = (usual_poses().towards(pose, share) for share in (0.5, 0.0))
    for moved in (there, still):
        np.testing.assert_array_equal(moved.neck_camera, NECK_CAMERA)
        np.testing.assert_allclose(moved.Rs[UPPER_TORSO], pose.Rs[UPPER_TORSO])
        assert are_rotations(moved.Rs).all()
    np.testing.assert_allclose(still.Rs, pose.Rs, atol=1e-9)


def test_an_arm_that_nobody_has_comes_back() -> None:
    usual = usual_poses()
    pose = some_pose()
    Rs = pose.Rs.copy()
    bent = rotations_from_angles(np.array([-1.2, 0.0, 0.9]))  # far behind the back
    for part in (LEFT_UPPER_ARM, LEFT_FOREARM):
        Rs[part] = Rs[UPPER_TORSO] @ bent @ Rs[UPPER_TORSO].T @ Rs[part]
    odd = Pose(pose.neck_camera, Rs)
    moved = usual.towards(odd, 0.5)
    usual_again = usual.towards(pose, 0.5)
    assert apart_rad(moved, odd, LEFT_UPPER_ARM) > 2.0 * apart_rad(
        usual_again, pose, LEFT_UPPER_ARM
    )


def test_turned_people_do_alike() -> None:
    pose = some_pose()
    level = Pose(NECK_CAMERA, TURN.T @ pose.Rs)
    moved, of_level = (usual_poses().towards(own, 0.4) for own in (pose, level))
    np.testing.assert_allclose(TURN.T @ moved.Rs, of_level.Rs, atol=1e-5)


def test_mirrored_people_do_mirrored() -> None:
    flip, pose = np.diag([-1.0, 1.0, 1.0]), some_pose()
    other = Pose(NECK_CAMERA, flip @ pose.Rs[list(OTHER_SIDE)] @ flip)
    moved, of_mirrored = (usual_poses().towards(own, 0.4).Rs for own in (pose, other))
    np.testing.assert_allclose(flip @ moved[list(OTHER_SIDE)] @ flip, of_mirrored, atol=1e-5)
