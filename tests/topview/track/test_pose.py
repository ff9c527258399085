"""Laws of the pose that goes from frame to frame."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from rendered_bodies import MODEL, standing_pose
from topview.body.kinematics import forward_kinematics, rotations_in_parent
from topview.body.parts import HEAD, HEAD_CENTRE_JOINT, PARTS, UPPER_TORSO
from topview.track.pose import FROM_UPPER_TORSO, HINGE_BENDS, HINGE_PAIRS, TREE_PARENT, Pose


def pose_of(seed: int) -> Pose:
    rng = np.random.default_rng(seed)
    Rs = Rotation.from_quat(rng.normal(size=(len(PARTS), 4))).as_matrix()
    return Pose(rng.normal(size=3), Rs)


poses = st.integers(0, 2**32 - 1).map(pose_of)


@given(poses)
def test_relative_and_from_relative_are_inverse(pose):
    back = Pose.from_relative(pose.neck_camera, pose.relative())
    assert_allclose(back.Rs, pose.Rs, atol=1e-12)
    assert_array_equal(back.neck_camera, pose.neck_camera)


@given(poses)
def test_relative_rotations_ignore_how_the_whole_body_is_turned(pose):
    turned = Pose(pose.neck_camera, pose.Rs[HEAD] @ pose.Rs)
    others = [part for part in range(len(PARTS)) if part != UPPER_TORSO]
    assert_allclose(turned.relative()[others], pose.relative()[others], atol=1e-12)


@given(poses)
def test_both_trees_place_the_parts_alike(pose):
    """From the neck, and from the crown as the table of parts hangs."""
    Ts = pose.transforms(MODEL)
    assert_allclose(forward_kinematics(MODEL, Ts[HEAD, :3, 3], pose.Rs), Ts, atol=1e-12)
    assert_allclose(Ts[UPPER_TORSO, :3, 3], pose.neck_camera)
    below = slice(2, None)
    assert_allclose(pose.relative()[below], rotations_in_parent(pose.Rs)[below], atol=1e-12)


def test_the_tree_hangs_from_the_upper_torso_and_parents_come_first():
    assert TREE_PARENT[UPPER_TORSO] == -1
    placed = {UPPER_TORSO}
    for part, parent in FROM_UPPER_TORSO:
        assert parent == TREE_PARENT[part]
        assert parent in placed
        placed.add(part)
    assert placed == set(range(len(PARTS)))


def test_elbows_bend_to_the_front_and_knees_to_the_back():
    assert len(HINGE_PAIRS) == 4
    for upper, lower in HINGE_PAIRS:
        assert PARTS[lower].parent == upper
        assert HINGE_BENDS[upper] == (1.0 if PARTS[upper].name.endswith("arm") else -1.0)


def test_parts_end_at_their_lengths_of_one_pose_and_of_many():
    pose = standing_pose()
    tips = np.zeros((len(MODEL.lengths_m), 4, 1))
    tips[:, 1, 0], tips[:, 3, 0] = MODEL.lengths_m, 1.0
    ends = (pose.transforms(MODEL) @ tips)[:, :3, 0]
    assert_allclose(pose.ends(MODEL), ends, atol=1e-12)
    many = Pose.together([pose, pose.turned_round()]).ends(MODEL)
    assert_array_equal(many[:, 0], pose.ends(MODEL))
    assert_array_equal(many[:, 1], pose.turned_round().ends(MODEL))


@given(st.lists(poses, min_size=1, max_size=4), poses)
def test_heads_of_one_pose_and_of_many_are_where_they_are_told(several, place):
    head_camera = place.neck_camera
    many = Pose.below_head(head_camera, Pose.together(several).Rs, MODEL)
    for index, pose in enumerate(several):
        below = Pose.below_head(head_camera, pose.Rs, MODEL)
        assert_array_equal(many.neck_camera[index], below.neck_camera)
        in_head = np.append(MODEL.joints_part[HEAD_CENTRE_JOINT], 1.0)
        assert_allclose((below.transforms(MODEL)[HEAD] @ in_head)[:3], head_camera, atol=1e-12)
