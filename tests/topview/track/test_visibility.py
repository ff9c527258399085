"""What hides a joint is told."""

from __future__ import annotations

import numpy as np
import pytest

from rendered_bodies import CAMERA, MODEL, render, standing_pose
from topview.body.ends import output_joints
from topview.body.parts import JOINT_NAMES, OUTPUT_JOINTS
from topview.camera.pyramid import DepthView
from topview.records import JointState
from topview.track.pose import Pose
from topview.track.visibility import (
    IN_FRONT_M,
    OWN_IN_FRONT_M,
    Visibility,
    joint_visibility,
)


def joints_of(pose: Pose) -> np.ndarray:
    """[20, 3] metres."""
    return output_joints(MODEL, pose.transforms(MODEL))


def view_of(depth_m: np.ndarray) -> DepthView:
    """The image with its intrinsics."""
    return DepthView(depth_m, CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy)


POSE = standing_pose()
JOINTS = joints_of(POSE)
DEPTH = render(POSE)
OWNER = np.where(DEPTH > 0, 1, 0).astype(np.int32)
KNEE = JOINT_NAMES.index("left_knee")
VISIBLE, OUT_OF_VIEW = JointState.VISIBLE, JointState.OUT_OF_VIEW


def covered(slab_m: float, owner: int) -> Visibility:
    """The lower half of the image hidden by something at `slab_m`."""
    depth, whose = DEPTH.copy(), OWNER.copy()
    depth[60:], whose[60:] = slab_m, owner
    return joint_visibility(JOINTS, MODEL, 1, view_of(depth), whose)


def test_one_who_stands_free_is_seen_and_confirmed():
    seen = joint_visibility(JOINTS, MODEL, 1, view_of(DEPTH), OWNER)
    assert (seen.joint_state == VISIBLE).all()
    assert seen.confirmed.mean() > 0.8


@pytest.mark.parametrize(
    ("owner", "state"),
    [
        (1, JointState.SELF_OCCLUDED),
        (2, JointState.OCCLUDED_BY_PERSON),
        (0, JointState.OCCLUDED_BY_OBJECT),
    ],
)
def test_what_stands_in_front_gives_the_state(owner, state):
    seen = covered(1.2, owner)
    assert seen.joint_state[KNEE] == state
    assert seen.confirmed[KNEE] == 0.0
    assert seen.joint_state[JOINT_NAMES.index("head")] == VISIBLE


def test_what_stands_behind_hides_nothing_but_confirms_nothing():
    seen = covered(4.0, 0)
    assert seen.joint_state[KNEE] == VISIBLE
    assert seen.confirmed[KNEE] == 0.0


def test_without_any_reading_nothing_hides_and_nothing_confirms():
    seen = joint_visibility(JOINTS, MODEL, 1, view_of(np.zeros_like(DEPTH)), np.zeros_like(OWNER))
    assert (seen.joint_state == VISIBLE).all()
    assert (seen.confirmed == 0.0).all()


@pytest.mark.parametrize(
    ("owner", "state"), [(1, JointState.SELF_OCCLUDED), (2, VISIBLE), (0, VISIBLE)]
)
def test_the_own_body_hides_from_nearer_by(owner, state):
    """As an arm lies closer on the body than others, or things, come."""
    surface_m = JOINTS[KNEE, 2] - MODEL.shapes_m[OUTPUT_JOINTS[KNEE].part, :2].min()
    before_m = 0.5 * (OWN_IN_FRONT_M + IN_FRONT_M)
    assert covered(surface_m - before_m, owner).joint_state[KNEE] == state


def test_a_wide_coat_hides_nothing():
    """What is seen of it is the surface of the parts, as far before the joints as it is wide."""
    coat_m = 0.2
    depth = np.where(DEPTH > 0.0, DEPTH - np.float32(coat_m), DEPTH)
    slim = joint_visibility(JOINTS, MODEL, 1, view_of(depth), OWNER)
    coat = MODEL.thicker(np.full(len(MODEL.lengths_m), coat_m))
    wide = joint_visibility(JOINTS, coat, 1, view_of(depth), OWNER)
    assert (slim.joint_state != VISIBLE).mean() > 0.8
    assert (wide.joint_state == VISIBLE).all()
    assert slim.confirmed.mean() < 0.1 < wide.confirmed.mean()


@pytest.mark.parametrize(
    "shift_m",
    [
        pytest.param((5.0, 0.0, 0.0), id="beside the image"),
        pytest.param((0.0, 4.0, 0.0), id="below the image"),
        pytest.param((0.0, 0.0, -6.0), id="behind the camera"),
    ],
)
def test_out_of_view(shift_m):
    joints = joints_of(Pose(POSE.neck_camera + np.array(shift_m), POSE.Rs))
    seen = joint_visibility(joints, MODEL, 1, view_of(DEPTH), OWNER)
    assert (seen.joint_state == OUT_OF_VIEW).all()


def test_legs_below_the_image_are_out_of_view_alone():
    low = Pose(POSE.neck_camera + np.array([0.0, 0.9, 0.0]), POSE.Rs)
    depth = render(low)
    owner = (depth > 0).astype(np.int32)
    state = joint_visibility(joints_of(low), MODEL, 1, view_of(depth), owner).joint_state
    assert state[JOINT_NAMES.index("left_ankle")] == OUT_OF_VIEW
    assert state[JOINT_NAMES.index("neck")] == VISIBLE


def test_a_joint_that_is_not_known_is_absent():
    joints = JOINTS.copy()
    joints[KNEE] = np.nan
    seen = joint_visibility(joints, MODEL, 1, view_of(DEPTH), OWNER)
    assert (seen.joint_state == JointState.ABSENT).nonzero()[0].tolist() == [KNEE]
