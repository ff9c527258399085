"""What bodies usually do, by poses of captured motion."""

from __future__ import annotations

import numpy as np
import pytest

from topview.body.parts import (
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import are_rotations, rotations_from_angles
from topview.track.methods.topview.lookup import shipped_poses
from topview.track.methods.topview.posture import Known
from topview.track.methods.topview.usual_poses import usual_poses
from topview.track.pose import OTHER_SIDE, Pose
from topview.track.stances import STANDING, Stance, facing, rotations_of

NECK_CAMERA = np.array([0.2, -0.4, 2.5])
TURN = rotations_from_angles(np.array([0.1, 2.0, -0.2]))
UP = np.array([0.0, -1.0, 0.0])
LEGS = [LEFT_UPPER_LEG, LEFT_LOWER_LEG, RIGHT_UPPER_LEG, RIGHT_LOWER_LEG]
SEATED = Stance(hip=85, knee=85)


def some_pose(index: int = 700) -> Pose:
    return Pose(NECK_CAMERA, TURN @ shipped_poses().Rs[index])


def with_an_odd_arm(pose: Pose) -> Pose:
    Rs = pose.Rs.copy()
    bent = rotations_from_angles(np.array([-1.2, 0.0, 0.9]))  # far behind the back
    for part in (LEFT_UPPER_ARM, LEFT_FOREARM):
        Rs[part] = Rs[UPPER_TORSO] @ bent @ Rs[UPPER_TORSO].T @ Rs[part]
    return Pose(pose.neck_camera, Rs)


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
    odd = with_an_odd_arm(pose)
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


def stance(angles: Stance = STANDING) -> Pose:
    return Pose(NECK_CAMERA, facing(0.3, UP) @ rotations_of(angles))


def known(hidden: list[int], head_height: float | None = None) -> Known:
    seen = np.ones(len(PARTS))
    seen[hidden] = 0.0
    return Known(seen, UP, head_height)


def thighs_down_deg(pose: Pose) -> np.ndarray:
    """[2] angles between thighs and straight down."""
    down = pose.Rs[[LEFT_UPPER_LEG, RIGHT_UPPER_LEG], :, 1] @ -UP
    return np.degrees(np.arccos(np.clip(down, -1.0, 1.0)))


def lean_deg(pose: Pose) -> float:
    return float(np.degrees(np.arccos(np.clip(pose.Rs[UPPER_TORSO][:, 1] @ -UP, -1.0, 1.0))))


def test_what_is_out_of_sight_tells_nothing():
    unseen, rest = known(LEGS), [part for part in range(len(PARTS)) if part not in LEGS]
    standing, seated = stance(), stance(SEATED)
    np.testing.assert_array_equal(standing.Rs[rest], seated.Rs[rest])
    moved, other = (usual_poses().towards(own, 1.0, unseen) for own in (standing, seated))
    np.testing.assert_allclose(moved.Rs, other.Rs, atol=1e-9)
    in_sight = usual_poses().towards(seated, 1.0, known([]))
    assert thighs_down_deg(in_sight).min() > 60.0


@pytest.mark.parametrize(
    ("head_height", "low_deg", "high_deg"), [(0.92, 0.0, 30.0), (0.67, 60.0, 110.0)]
)
def test_how_high_the_head_is_tells_who_sits(head_height, low_deg, high_deg):
    upright = usual_poses().towards(stance(), 1.0, known(LEGS, head_height))
    assert low_deg <= thighs_down_deg(upright).min()
    assert thighs_down_deg(upright).max() <= high_deg


def test_a_trunk_leans_as_is_usual_only_where_it_is_hidden():
    trunk = [UPPER_TORSO, LOWER_TORSO]
    bent = stance(Stance(lean=50, hip=50))
    seen = usual_poses().towards(bent, 1.0, known([]))
    np.testing.assert_allclose(seen.Rs[UPPER_TORSO], bent.Rs[UPPER_TORSO], atol=1e-9)
    hidden = usual_poses().towards(bent, 1.0, known(trunk, 0.92))
    assert lean_deg(bent) == pytest.approx(50.0)
    assert lean_deg(hidden) < 15.0


def test_parts_have_shares_of_their_own():
    pose, shares = some_pose(), np.zeros(len(PARTS))
    shares[LEFT_UPPER_ARM] = 1.0
    moved = usual_poses().towards(pose, shares, known([LEFT_UPPER_ARM]))
    still = [part for part in range(len(PARTS)) if part not in (LEFT_UPPER_ARM, LEFT_FOREARM)]
    np.testing.assert_allclose(moved.Rs[still], pose.Rs[still], atol=1e-9)
    assert apart_rad(moved, pose, LEFT_UPPER_ARM) > 0.05


@pytest.mark.parametrize(("head_height", "is_seated"), [(0.92, False), (0.67, True)])
def test_legs_are_usual_that_have_the_head_as_high_as_it_is(head_height, is_seated):
    poses = Pose.together([stance(), stance(SEATED)])
    standing, seated = usual_poses().unlikeness(poses, UP, head_height).tolist()
    assert (seated < standing) == is_seated


def test_an_arm_that_nobody_has_is_unusual():
    pose = some_pose()
    poses = Pose.together([pose, with_an_odd_arm(pose)])
    own, odd = usual_poses().unlikeness(poses, UP, None).tolist()
    assert odd > own + 1.0


def test_hidden_parts_of_mirrored_people_do_mirrored():
    flip = np.diag([-1.0, 1.0, 1.0])
    pose = stance(Stance(lean=30, hip=30))
    other = Pose(NECK_CAMERA, flip @ pose.Rs[list(OTHER_SIDE)] @ flip)
    left, right = [LEFT_UPPER_LEG, LEFT_LOWER_LEG], [RIGHT_UPPER_LEG, RIGHT_LOWER_LEG]
    moved = usual_poses().towards(pose, 0.7, known(left, 0.8)).Rs
    of_mirrored = usual_poses().towards(other, 0.7, known(right, 0.8)).Rs
    np.testing.assert_allclose(flip @ moved[list(OTHER_SIDE)] @ flip, of_mirrored, atol=1e-5)
