"""What goes on with limbs that nobody sees, and what is out of sight at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rendered_bodies import (
    CAMERA,
    MODEL,
    UP,
    evidence_in,
    evidence_of,
    joints_of,
    render,
    standing_pose,
)
from topview.body import JOINT_NAMES
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, LEFT_UPPER_LEG
from topview.filter.particles import generator
from topview.geometry.rotations import rotations_from_angles
from topview.track.evidence import Evidence
from topview.track.methods.topview.limbs import LIMBS, LimbSearch, LimbSettings
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand

SCREEN_M = 1.6
LEFT_ARM = np.s_[LEFT_UPPER_ARM : LEFT_FOREARM + 1]


def behind_a_screen(pose: Pose) -> Evidence:
    """Someone whose left side, the image's right, is behind a screen."""
    depth = render(pose)
    middle = round(CAMERA.fx * pose.neck_camera[0] / pose.neck_camera[2] + CAMERA.cx)
    depth[:, middle + 3 :] = SCREEN_M
    head = pose.neck_camera - 0.5 * MODEL.lengths_m[0] * pose.Rs[0][:, 1]
    return evidence_in(depth, (depth > 0) & (depth != np.float32(SCREEN_M)), head)


def with_left_limb_raised(pose: Pose, upper: int) -> Pose:
    Rs = pose.relative()
    Rs[upper] = rotations_from_angles(np.radians([70.0, 0.0, 30.0]))
    Rs[upper + 1] = np.eye(3)
    return Pose.from_relative(pose.neck_camera, Rs)


def in_profile() -> Pose:
    """The left side is the far one; its arm hangs behind the trunk."""
    return stand(MODEL, np.array([0.05, -0.75, 2.6]), STANDING, -np.pi / 2, UP)


def with_left_arm_stretched(pose: Pose) -> Pose:
    """To the front."""
    Rs = pose.relative()
    Rs[LEFT_UPPER_ARM] = rotations_from_angles(np.radians([90.0, 0.0, 0.0]))
    return Pose.from_relative(pose.neck_camera, Rs)


def searched(pose: Pose, evidence: Evidence, frames: int) -> Pose:
    search, kept = LimbSearch(LimbSettings(), 1), {}
    for frame in range(frames):
        rngs = {upper: generator(0, 1, upper, frame) for upper in LIMBS}
        pose, kept = search.search(pose, pose, MODEL, evidence, rngs, kept)
    return pose


def test_places_are_out_of_sight_behind_the_screen_and_beside_the_image():
    pose = standing_pose(0.0)
    evidence = behind_a_screen(pose)
    joints = joints_of(pose)
    names = [JOINT_NAMES.index(name) for name in ("left_hand", "right_hand", "head")]
    assert evidence.out_of_sight(joints[names], 0.05).tolist() == [True, False, False]
    assert evidence.out_of_sight(np.array([[50.0, 0.0, 2.0]]), 0.05).all()
    before_the_screen = joints[names[:1]] * (SCREEN_M - 0.3) / joints[names[0], 2]
    assert not evidence.out_of_sight(before_the_screen, 0.05).any()


def test_the_own_body_hides_when_asked():
    pose = in_profile()
    far_elbow = joints_of(pose)[[JOINT_NAMES.index("left_elbow")]]
    evidence = evidence_of(pose)
    assert not evidence.out_of_sight(far_elbow, 0.05).any()
    assert evidence.out_of_sight(far_elbow, 0.05, own_body_hides=True).all()


@pytest.mark.parametrize("upper", [LEFT_UPPER_ARM, LEFT_UPPER_LEG])
def test_a_limb_behind_something_else_keeps_its_pose_and_one_in_sight_stays(upper):
    pose = standing_pose(0.0)
    raised = with_left_limb_raised(pose, upper)
    found = searched(raised, behind_a_screen(pose), 15)
    np.testing.assert_array_equal(found.Rs[upper : upper + 2], raised.Rs[upper : upper + 2])
    right = np.s_[LEFT_FOREARM + 1 : LEFT_FOREARM + 3]
    cosines = (found.Rs[right, :, 1] * raised.Rs[right, :, 1]).sum(1)
    assert cosines.min() > 0.9


def test_an_arm_behind_the_own_body_keeps_its_pose():
    pose = in_profile()
    found = searched(pose, evidence_of(pose), 15)
    np.testing.assert_array_equal(found.Rs[LEFT_ARM], pose.Rs[LEFT_ARM])


def test_an_arm_comes_out_from_behind_the_own_body_when_its_points_are_seen():
    hanging = in_profile()
    stretched = with_left_arm_stretched(hanging)
    found = searched(hanging, evidence_of(stretched), 15)
    cosines = (found.Rs[LEFT_ARM, :, 1] * stretched.Rs[LEFT_ARM, :, 1]).sum(1)
    assert cosines.min() > 0.9


def test_a_leg_outside_of_the_image_stands_until_something_is_known_of_it():
    pose = standing_pose(0.0)
    head_and_trunk = replace(CAMERA, height=60)
    seated = with_left_limb_raised(pose, LEFT_UPPER_LEG)
    evidence = evidence_of(pose, camera=head_and_trunk)
    found = searched(seated, evidence, 1)
    assert np.all(found.Rs[LEFT_UPPER_LEG : LEFT_UPPER_LEG + 2, :, 1] @ -UP > 0.999)
