"""What is out of sight, and an arm that comes into it."""

from __future__ import annotations

import numpy as np

from rendered_bodies import (
    CAMERA,
    MODEL,
    UP,
    at_frame,
    evidence_in,
    evidence_of,
    joints_of,
    render,
    standing_pose,
    subject,
)
from topview.body import JOINT_NAMES
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM
from topview.geometry.rotations import rotations_from_angles
from topview.track.evidence import Evidence
from topview.track.methods.topview.tracker import TopviewSettings, TopviewTracker
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


def in_profile(distance_m: float) -> Pose:
    """The left side is the far one; its arm hangs behind the trunk."""
    return stand(MODEL, np.array([0.05, -0.75, distance_m]), STANDING, -np.pi / 2, UP)


def with_left_arm_stretched(pose: Pose) -> Pose:
    """To the front."""
    Rs = pose.relative()
    Rs[LEFT_UPPER_ARM] = rotations_from_angles(np.radians([90.0, 0.0, 0.0]))
    return Pose.from_relative(pose.neck_camera, Rs)


def test_places_are_out_of_sight_behind_the_screen_and_beside_the_image():
    pose = standing_pose(0.0)
    evidence = behind_a_screen(pose)
    joints = joints_of(pose)
    names = [JOINT_NAMES.index(name) for name in ("left_hand", "right_hand", "head")]
    assert evidence.out_of_sight(joints[names], 0.05).tolist() == [True, False, False]
    assert evidence.out_of_sight(np.array([[50.0, 0.0, 2.0]]), 0.05).all()
    before_the_screen = joints[names[:1]] * (SCREEN_M - 0.3) / joints[names[0], 2]
    assert not evidence.out_of_sight(before_the_screen, 0.05).any()


def stretched_arm_cosines(distance_m: float) -> np.ndarray:
    """[2] of the arm's two parts with their true directions, half a second after it came out; 0 if
    the arm still hung."""
    hanging = in_profile(distance_m)
    stretched = with_left_arm_stretched(hanging)
    tracker = TopviewTracker(subject(), TopviewSettings())
    for frame in range(10):
        tracker.update(at_frame(evidence_of(hanging), frame))
    found = [tracker.update(at_frame(evidence_of(stretched), frame)) for frame in range(10, 25)][-1]
    return (found.Rs[LEFT_ARM, :, 1] * stretched.Rs[LEFT_ARM, :, 1]).sum(1)


def test_an_arm_comes_out_from_behind_the_own_body_when_its_points_are_seen():
    cosines = stretched_arm_cosines(2.6)
    assert cosines.min() > 0.9


def test_wherever_someone_stands_an_arm_comes_out_from_behind_the_own_body():
    off_deg = np.degrees(
        [np.arccos(stretched_arm_cosines(distance_m).min()) for distance_m in (2.4, 2.5, 2.7, 2.8)]
    )
    assert np.mean(off_deg) < 30.0
    assert max(off_deg) < 45.0
