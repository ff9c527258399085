"""Wrists and feet lie where the fitted body has them."""

from __future__ import annotations

import numpy as np
import pytest
from body_strategies import body_rotations
from hypothesis import given
from numpy.testing import assert_allclose

from topview.body.ends import FEET_AT_REST, output_joints
from topview.body.kinematics import R_CAMERA_FACING, forward_kinematics, joints_from_parts
from topview.body.model import BodyModel
from topview.body.parts import JOINTS, OUTPUT_JOINT_NAMES, OUTPUT_JOINTS, PARTS
from topview.body.proportions import ANATOMICAL, THESIS

CROWN = np.array([0.0, -0.7, 3.0])


def joint(joints: np.ndarray, name: str) -> np.ndarray:
    return joints[OUTPUT_JOINT_NAMES.index(name)]


@given(body_rotations)
def test_the_body_s_own_joints_come_first_and_are_left_alone(Rs):
    model = BodyModel.of(1.8, ANATOMICAL)
    Ts = forward_kinematics(model, CROWN, Rs)
    joints = output_joints(model, Ts)
    assert joints.shape == (len(OUTPUT_JOINTS), 3)
    assert joints[: len(JOINTS)].tobytes() == joints_from_parts(model, Ts).tobytes()


@given(body_rotations)
def test_a_wrist_lies_between_elbow_and_hand_and_a_foot_at_its_length(Rs):
    model = BodyModel.of(1.8, THESIS)
    joints = output_joints(model, forward_kinematics(model, CROWN, Rs))
    for side in ("left", "right"):
        elbow, wrist, hand = (joint(joints, f"{side}_{n}") for n in ("elbow", "wrist", "hand"))
        whole_m = np.linalg.norm(hand - elbow)
        assert np.linalg.norm(wrist - elbow) + np.linalg.norm(hand - wrist) == pytest.approx(
            whole_m
        )
        assert 0.7 * whole_m < np.linalg.norm(wrist - elbow) < 0.9 * whole_m
        foot_m = np.linalg.norm(joint(joints, f"{side}_foot") - joint(joints, f"{side}_ankle"))
        assert foot_m == pytest.approx(1.8 * np.linalg.norm(FEET_AT_REST[0]))


def test_feet_point_to_the_front_and_outwards():
    model = BodyModel.of(1.8, ANATOMICAL)
    Rs = np.repeat(R_CAMERA_FACING[None], len(PARTS), axis=0)
    joints = output_joints(model, forward_kinematics(model, CROWN, Rs))
    left, right = (
        joint(joints, f"{side}_foot") - joint(joints, f"{side}_ankle") for side in ("left", "right")
    )
    assert_allclose(left, right * (-1.0, 1.0, 1.0))
    assert left[2] < -0.1  # towards the camera
    assert 0.0 < left[0] < 0.05  # the left of somebody who faces the camera is at its right
