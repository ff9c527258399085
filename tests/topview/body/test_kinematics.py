"""Laws of forward kinematics, and the signs of Table 3.2."""

from __future__ import annotations

import numpy as np
import pytest
from body_strategies import body_rotations, rotations
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from topview.body.kinematics import (
    R_CAMERA_FACING,
    forward_kinematics,
    joints_from_parts,
    rotations_in_camera,
    rotations_in_parent,
)
from topview.body.model import BodyModel
from topview.body.parts import JOINT_NAMES, JOINTS, PART_NAMES, PARTS
from topview.body.proportions import ANATOMICAL, THESIS
from topview.geometry.rotations import rotations_from_angles

STATURE_M = 1.75
MODEL = BodyModel.of(STATURE_M, ANATOMICAL)
CROWN = np.array([0.2, -0.6, 2.5])
AT_REST = np.repeat(R_CAMERA_FACING[None], len(PARTS), axis=0)
# A bone's ends lie on parts that share a joint; only "torso" lies beyond one from its neighbour.
RIGID_BONES = [
    (index, joint.bone_to)
    for index, joint in enumerate(JOINTS)
    if joint.bone_to >= 0 and joint.name != "torso"
]
TO_FRONT = np.array([0.0, 0.0, -1.0])  # of a person who faces the camera
TO_LEFT = np.array([1.0, 0.0, 0.0])
DOWN = np.array([0.0, 1.0, 0.0])


def joints_of(Rs: np.ndarray, crown: np.ndarray = CROWN, model: BodyModel = MODEL) -> np.ndarray:
    return joints_from_parts(model, forward_kinematics(model, crown, Rs))


def joint(name: str, joints: np.ndarray) -> np.ndarray:
    return joints[JOINT_NAMES.index(name)]


@given(body_rotations)
def test_bones_keep_their_lengths_however_the_body_is_turned(Rs):
    at_rest, turned = joints_of(AT_REST), joints_of(Rs)
    for a, b in RIGID_BONES:
        expected = np.linalg.norm(at_rest[a] - at_rest[b])
        assert np.linalg.norm(turned[a] - turned[b]) == pytest.approx(expected)


@given(body_rotations)
def test_parts_stay_joined(Rs):
    Ts = forward_kinematics(MODEL, CROWN, Rs)
    assert_allclose(Ts[0, :3, 3], CROWN)
    assert_allclose(Ts[:, :3, :3], Rs)
    for index, part in enumerate(PARTS[1:], start=1):
        joint_camera = Ts[part.parent] @ np.append(MODEL.joints_parent[index], 1.0)
        assert_allclose(Ts[index, :3, 3], joint_camera[:3], atol=1e-12)


@given(body_rotations, rotations(1), st.floats(-3, 3))
def test_moving_the_head_rigidly_moves_everything_rigidly(Rs, R, shift_m):
    R, shift = R[0], np.array([shift_m, 0.5, 1.0])
    moved = joints_of(R @ Rs, R @ CROWN + shift)
    assert_allclose(moved, joints_of(Rs) @ R.T + shift, atol=1e-12)


@given(body_rotations)
def test_rotations_in_parents_and_in_the_camera_are_inverse(Rs):
    assert_allclose(rotations_in_camera(rotations_in_parent(Rs)), Rs, atol=1e-12)
    assert_allclose(rotations_in_parent(rotations_in_camera(Rs)), Rs, atol=1e-12)


@pytest.mark.parametrize("proportions", [THESIS, ANATOMICAL], ids=["thesis", "anatomy"])
def test_at_rest_a_person_stands_upright_and_faces_the_camera(proportions):
    model = BodyModel.of(STATURE_M, proportions)
    joints = joints_of(AT_REST, model=model)
    Ts = forward_kinematics(model, CROWN, AT_REST)
    sole = Ts[-1] @ (0.0, model.lengths_m[-1], 0.0, 1.0)
    assert sole[1] - CROWN[1] == pytest.approx(STATURE_M)
    assert_allclose(joints[:, 2], CROWN[2], atol=1e-12)
    order = ["head", "neck", "left_shoulder", "torso", "pelvis", "left_knee", "left_ankle"]
    heights = [joint(name, joints)[1] for name in order]
    assert heights == sorted(heights)
    assert joint("left_shoulder", joints)[0] > CROWN[0] > joint("right_shoulder", joints)[0]
    assert_allclose(joint("left_hip", joints)[1], joint("pelvis", joints)[1])


def bent(part: str, angles_degrees: tuple[float, float, float]) -> np.ndarray:
    """[16, 3] joints with one part turned from rest."""
    Rs = rotations_in_parent(AT_REST)
    index = PART_NAMES.index(part)
    Rs[index] = rotations_from_angles(np.radians(angles_degrees))
    return joints_of(rotations_in_camera(Rs))


@pytest.mark.parametrize(
    ("part", "angles", "end", "pivot", "towards"),
    [
        ("left_forearm", (90, 0, 0), "left_hand", "left_elbow", TO_FRONT),
        ("right_forearm", (90, 0, 0), "right_hand", "right_elbow", TO_FRONT),
        ("left_upper_leg", (90, 0, 0), "left_knee", "left_hip", TO_FRONT),
        ("left_lower_leg", (-90, 0, 0), "left_ankle", "left_knee", -TO_FRONT),
        ("right_lower_leg", (-90, 0, 0), "right_ankle", "right_knee", -TO_FRONT),
        ("left_upper_arm", (0, 0, 90), "left_elbow", "left_shoulder", TO_LEFT),
        ("right_upper_arm", (0, 0, -90), "right_elbow", "right_shoulder", -TO_LEFT),
        ("left_upper_leg", (0, 0, 90), "left_knee", "left_hip", TO_LEFT),
        ("right_upper_leg", (0, 0, -90), "right_knee", "right_hip", -TO_LEFT),
        ("left_upper_arm", (180, 0, 0), "left_elbow", "left_shoulder", -DOWN),
        ("left_upper_arm", (0, 90, 0), "left_elbow", "left_shoulder", DOWN),
    ],
)
def test_signs_of_table_3_2(part, angles, end, pivot, towards):
    joints = bent(part, angles)
    bone = joint(end, joints) - joint(pivot, joints)
    assert_allclose(bone / np.linalg.norm(bone), towards, atol=1e-12)


def test_only_what_hangs_from_a_part_moves_with_it():
    moved = np.abs(bent("left_upper_arm", (30, 10, 20)) - joints_of(AT_REST)).max(1) > 1e-9
    names = {name for name, is_moved in zip(JOINT_NAMES, moved, strict=True) if is_moved}
    assert names == {"left_elbow", "left_hand"}
