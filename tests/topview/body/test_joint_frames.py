"""Rotations, offsets and lengths of the outputs' joints give their places back."""

from __future__ import annotations

import numpy as np
import pytest
from body_strategies import body_rotations
from hypothesis import given
from numpy.testing import assert_allclose

from topview.body.ends import FEET_AT_REST, output_joints
from topview.body.joint_frames import (
    JOINT_PARENTS,
    bone_lengths,
    joint_frames,
    joints_from_frames,
)
from topview.body.kinematics import R_CAMERA_FACING, forward_kinematics, rotations_in_camera
from topview.body.model import BodyModel
from topview.body.parts import OUTPUT_JOINT_NAMES, PART_NAMES, PARTS
from topview.body.proportions import ANATOMICAL
from topview.geometry.rotations import rotations_from_angles

MODEL = BodyModel.of(1.75, ANATOMICAL)
CROWN = np.array([0.2, -0.6, 2.5])
AT_REST = np.repeat(R_CAMERA_FACING[None], len(PARTS), axis=0)
ON_THE_SPINE = ("neck", "left_shoulder", "right_shoulder")
Bodies = tuple[np.ndarray, np.ndarray]


def bodies(*Rs_camera_part: np.ndarray, feet_leg_m: np.ndarray | None = None) -> Bodies:
    """[N, 20, 3] joints and [N, 11, 4, 4] parts."""
    Ts = [forward_kinematics(MODEL, CROWN, Rs) for Rs in Rs_camera_part]
    return np.stack([output_joints(MODEL, T, feet_leg_m) for T in Ts]), np.stack(Ts)


def at(name: str) -> int:
    return OUTPUT_JOINT_NAMES.index(name)


def bent(part: str, degrees: tuple[float, float, float]) -> Bodies:
    """Upright, but for one part."""
    angles = np.zeros((len(PARTS), 3))
    angles[PART_NAMES.index(part)] = np.radians(degrees)
    Rs = rotations_from_angles(angles)
    Rs[0] = R_CAMERA_FACING @ Rs[0]
    return bodies(rotations_in_camera(Rs))


@given(body_rotations)
def test_forward_kinematics_gives_the_joints(Rs):
    joints, Ts = bodies(Rs)
    assert_allclose(joints_from_frames(*joint_frames(joints, Ts)), joints, atol=1e-12)


@given(body_rotations)
def test_bones_keep_their_lengths_but_where_the_spine_bends(Rs):
    joints, Ts = bodies(AT_REST, Rs)
    lengths_m = bone_lengths(joints, Ts)
    assert_allclose(lengths_m[1], lengths_m[0], atol=1e-12)
    assert lengths_m[0, at("pelvis")] == 0.0
    _, offsets_m = joint_frames(joints, Ts)
    rigid = [
        j
        for j, name in enumerate(OUTPUT_JOINT_NAMES)
        if JOINT_PARENTS[j] >= 0 and name not in ON_THE_SPINE
    ]
    assert_allclose(np.linalg.norm(offsets_m[1, rigid], axis=-1), lengths_m[0, rigid], atol=1e-12)
    assert_allclose(offsets_m[1, rigid], offsets_m[0, rigid], atol=1e-12)


def test_nothing_is_turned_in_who_stands_upright_with_hanging_arms():
    Rs, offsets_m = (of[0] for of in joint_frames(*bodies(AT_REST)))
    root = JOINT_PARENTS.index(-1)
    assert_allclose(np.delete(Rs, root, 0), np.tile(np.eye(3), (19, 1, 1)), atol=1e-12)
    assert_allclose(Rs[root], R_CAMERA_FACING, atol=1e-12)
    assert_allclose(offsets_m[at("left_knee")], (0.0, 0.245 * 1.75, 0.0), atol=1e-12)
    lengths_m = bone_lengths(*bodies(AT_REST))[0]
    assert_allclose(np.delete(np.linalg.norm(offsets_m, axis=-1), root), np.delete(lengths_m, root))


@pytest.mark.parametrize(
    ("part", "degrees", "joint"),
    [
        ("right_forearm", (70.0, 0.0, 0.0), "right_elbow"),
        ("left_upper_leg", (50.0, 0.0, 20.0), "left_hip"),
        ("left_lower_leg", (-60.0, 0.0, 0.0), "left_knee"),
        ("lower_torso", (0.0, -20.0, 0.0), "torso"),
        ("upper_torso", (20.0, 0.0, 0.0), "neck"),
    ],
)
def test_one_joint_turns_alone_as_table_3_2_says(part, degrees, joint):
    Rs = joint_frames(*bent(part, degrees))[0][0]
    turned = [
        j
        for j in range(len(Rs))
        if JOINT_PARENTS[j] >= 0 and np.abs(Rs[j] - np.eye(3)).max() > 1e-9
    ]
    assert turned == [at(joint)]
    expected = rotations_from_angles(np.radians(degrees))
    # Parts hang from the head, joints from the pelvis: of the trunk the turn is the inverse.
    is_of_trunk = joint in ("torso", "neck")
    assert_allclose(Rs[at(joint)], expected.T if is_of_trunk else expected, atol=1e-12)


def test_a_foot_that_points_elsewhere_turns_its_ankle_alone():
    up = MODEL.stature_m * FEET_AT_REST[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    joints, Ts = bodies(AT_REST, feet_leg_m=up)
    Rs, offsets_m = (of[0] for of in joint_frames(joints, Ts))
    for side, at_rest in zip(("left", "right"), MODEL.stature_m * FEET_AT_REST, strict=True):
        assert_allclose(offsets_m[at(f"{side}_foot")], at_rest, atol=1e-12)
        assert np.trace(Rs[at(f"{side}_ankle")]) == pytest.approx(
            1.0 + 2.0 * np.cos(np.arccos(FEET_AT_REST[0, 0] ** 2 / (FEET_AT_REST[0] ** 2).sum()))
        )
        assert_allclose(Rs[at(f"{side}_foot")], np.eye(3), atol=1e-12)
    assert_allclose(joints_from_frames(Rs[None], offsets_m[None])[0], joints[0], atol=1e-12)


def test_an_unknown_leg_leaves_all_others_as_they_are():
    joints, Ts = (of.copy() for of in bodies(AT_REST))
    whole, _ = joint_frames(joints, Ts)
    Ts[:, [name.startswith("left") and name.endswith("leg") for name in PART_NAMES]] = np.nan
    leg = [at(f"left_{name}") for name in ("hip", "knee", "ankle", "foot")]
    joints[:, leg] = np.nan
    Rs, offsets_m = joint_frames(joints, Ts)
    assert np.isnan(Rs[:, leg]).all()
    assert np.isnan(offsets_m[:, leg]).all()
    assert np.isnan(bone_lengths(joints, Ts)[:, leg]).all()
    assert_allclose(np.delete(Rs, leg, 1), np.delete(whole, leg, 1), atol=1e-12)


def test_every_joint_hangs_from_the_pelvis():
    assert [OUTPUT_JOINT_NAMES[j] for j, parent in enumerate(JOINT_PARENTS) if parent < 0] == [
        "pelvis"
    ]
    for joint in range(len(JOINT_PARENTS)):
        way = [joint]
        while JOINT_PARENTS[way[-1]] >= 0:
            assert len(way) < len(JOINT_PARENTS)
            way.append(JOINT_PARENTS[way[-1]])
        assert way[-1] == at("pelvis")
    hangs = {
        name: OUTPUT_JOINT_NAMES[JOINT_PARENTS[at(name)]] for name in ("left_hand", "right_foot")
    }
    assert hangs == {"left_hand": "left_wrist", "right_foot": "right_ankle"}
