"""Laws of the body that is fitted to proposed joints."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, joints_of
from topview.body.limits import KNEE_FLEXION_RAD, LIMITS_RAD
from topview.body.parts import HEAD, JOINT_NAMES, JOINTS, PARTS, UPPER_TORSO
from topview.detect.joints import JointProposals
from topview.geometry.rotations import rotations_from_angles, rotations_from_vectors
from topview.records import InputError
from topview.track.degrees_of_freedom import DOF_AXIS, DOF_PART, N_DOFS
from topview.track.joint_fit import JointFitSettings, fit_joints, robust_residual
from topview.track.pose import OTHER_SIDE, Pose

SETTINGS = JointFitSettings(iterations=30)  # where it ends, whatever the pose
OTHER_WORD = {"left": "right", "right": "left"}
MIRROR = np.diag([-1.0, 1.0, 1.0])
OTHER_JOINTS = [
    JOINT_NAMES.index(re.sub("left|right", lambda side: OTHER_WORD[side[0]], name))
    for name in JOINT_NAMES
]


def posed(seed: int) -> Pose:
    """Somebody who faces the camera, more or less, with every joint anywhere within its limits."""
    rng = np.random.default_rng(seed)
    relative = rotations_from_angles(rng.uniform(LIMITS_RAD[..., 0], LIMITS_RAD[..., 1]))
    relative[HEAD] = rotations_from_vectors(rng.normal(0.0, 0.3, 3))
    facing = np.diag([-1.0, 1.0, -1.0])
    relative[UPPER_TORSO] = facing @ rotations_from_vectors(rng.normal(0.0, 0.5, 3))
    return Pose.from_relative(rng.normal((0.0, 0.0, 3.0), 0.3), relative)


poses = st.integers(0, 2**32 - 1).map(posed)


def proposed(*modes: np.ndarray, scales_m: float | np.ndarray = 0.005) -> JointProposals:
    """[16, 3] joints of each mode, as proposals for one person."""
    M = len(modes)
    return JointProposals(
        np.stack(modes)[None],
        np.broadcast_to(scales_m, (1, M, len(JOINTS), 3)).copy(),
        np.full((1, M), 1.0 / M),
        np.ones(1),
        JOINT_NAMES,
    )


def fitted(proposals: JointProposals) -> list[np.ndarray]:
    """[16, 3] joints of the body fitted to each mode."""
    return [joints_of(pose) for pose in fit_joints(MODEL, proposals, SETTINGS).poses]


@settings(max_examples=30)
@given(poses, st.integers(1, 3))
def test_a_body_is_recovered_from_its_own_joints(pose, modes):
    joints = joints_of(pose)
    found = fit_joints(MODEL, proposed(*[joints] * modes), SETTINGS)
    for fit in found.poses:
        assert_allclose(joints_of(fit), joints, atol=0.001)
        assert_allclose(fit.Rs @ np.swapaxes(fit.Rs, 1, 2), [np.eye(3)] * len(PARTS), atol=1e-9)
    assert found.residuals.max() < 0.02


@settings(max_examples=10)
@given(poses, poses)
def test_every_mode_is_fitted_as_if_it_were_alone(one, other):
    joints = joints_of(one), joints_of(other)
    together = fit_joints(MODEL, proposed(*joints), SETTINGS)
    for index in (0, 1):
        alone = fit_joints(MODEL, proposed(joints[index]), SETTINGS)
        assert_array_equal(alone.poses[0].Rs, together.poses[index].Rs)
        assert_array_equal(alone.poses[0].neck_camera, together.poses[index].neck_camera)
        assert alone.residuals[0] == together.residuals[index]


@settings(max_examples=10)
@given(poses, st.integers(0, 2**32 - 1))
def test_a_rigid_motion_of_the_joints_moves_the_pose_likewise(pose, seed):
    rng = np.random.default_rng(seed)
    turn, shift = rotations_from_vectors(rng.normal(0.0, 0.1, 3)), rng.normal(0.0, 0.1, 3)
    joints = joints_of(pose)
    here, there = fitted(proposed(joints)), fitted(proposed(joints @ turn.T + shift))
    assert_allclose(there[0], here[0] @ turn.T + shift, atol=0.001)


@settings(max_examples=10)
@given(poses, st.integers(0, 2**32 - 1))
def test_mirrored_joints_with_exchanged_sides_give_the_mirrored_pose(pose, seed):
    """Joints that are off, so that the residuals count too."""
    joints = joints_of(pose) + np.random.default_rng(seed).normal(0.0, 0.01, (len(JOINTS), 3))
    (fit,) = fit_joints(MODEL, proposed(joints, scales_m=0.02), SETTINGS).poses
    mirrored = (joints @ MIRROR)[OTHER_JOINTS]
    (other,) = fit_joints(MODEL, proposed(mirrored, scales_m=0.02), SETTINGS).poses
    assert_allclose(other.neck_camera, MIRROR @ fit.neck_camera, atol=1e-6)
    # x and its mirror image are opposite: the frames stay right-handed
    assert_allclose(other.Rs, (MIRROR @ fit.Rs @ MIRROR)[list(OTHER_SIDE)], atol=1e-5)


@settings(max_examples=10)
@given(poses, st.integers(0, len(JOINTS) - 1))
def test_a_joint_of_huge_scale_does_not_matter(pose, index):
    joints, scales_m = joints_of(pose), np.full((len(JOINTS), 3), 0.005)
    away = joints.copy()
    away[index] += (0.5, -0.4, 0.3)
    scales_m[index] = 1e3
    here, there = fitted(proposed(joints, away, scales_m=scales_m))
    assert_allclose(there, here, atol=0.001)
    beside = [k for k in range(len(JOINTS)) if k != index]
    assert_allclose(there[beside], joints[beside], atol=0.01)


@settings(max_examples=10)
@given(poses)
def test_joints_that_are_not_proposed_are_left_out(pose):
    joints, hand = joints_of(pose), JOINT_NAMES.index("left_hand")
    kept = [index for index in range(len(JOINTS)) if index != hand]
    whole = proposed(joints)
    part = JointProposals(
        whole.positions_camera[:, :, kept],
        whole.scales_m[:, :, kept],
        whole.weights,
        whole.p_person,
        tuple(JOINT_NAMES[index] for index in kept),
    )
    found = fit_joints(MODEL, part, SETTINGS)
    assert_allclose(joints_of(found.poses[0])[kept], joints[kept], atol=0.001)


def astray(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """[16, 3] joints that no body has, and their scales, which are unlike."""
    rng = np.random.default_rng(seed)
    joints = joints_of(posed(seed)) + rng.normal(0.0, 0.03, (len(JOINTS), 3))
    return joints, rng.uniform(0.01, 0.1, joints.shape)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_the_kernel_s_residual_is_the_defined_one(seed):
    joints, scales_m = astray(seed)
    found = fit_joints(MODEL, proposed(joints, scales_m=scales_m), SETTINGS)
    defined = robust_residual(joints_of(found.poses[0]), joints, scales_m)
    assert found.residuals[0] == pytest.approx(defined, abs=1e-9)


@settings(max_examples=3)
@given(st.integers(0, 2**32 - 1))
def test_no_small_step_lowers_the_residual_of_a_fitted_body(seed):
    """Its slope is none, by finite differences: the kernel's derivative is the definition's."""
    joints, scales_m = astray(seed)
    alone = JointFitSettings(iterations=100, limit_weight=0.0, prior_weight=0.001)
    (pose,) = fit_joints(MODEL, proposed(joints, scales_m=scales_m), alone).poses

    def residual(steps: np.ndarray) -> float:
        relative = pose.relative()
        for d in range(3, N_DOFS):
            turn = steps[d] * np.eye(3)[DOF_AXIS[d]]
            relative[DOF_PART[d]] = relative[DOF_PART[d]] @ rotations_from_vectors(turn)
        moved = Pose.from_relative(pose.neck_camera + steps[:3], relative)
        return robust_residual(joints_of(moved), joints, scales_m)

    def slopes(at: float) -> np.ndarray:
        ways = np.eye(N_DOFS)
        return np.array(
            [(residual((at + 1e-5) * w) - residual((at - 1e-5) * w)) / 2e-5 for w in ways]
        )

    assert np.abs(slopes(0.0)).max() < 1e-3
    assert np.abs(slopes(0.02)).max() > 1.0


def test_a_hand_that_is_not_believed_bends_no_elbow_beyond_its_limit():
    """The limits count where the joints are unsure."""
    pose = posed(3)
    joints = joints_of(pose)
    knee, ankle = JOINT_NAMES.index("left_knee"), JOINT_NAMES.index("left_ankle")
    hip = JOINT_NAMES.index("left_hip")
    joints[ankle] = joints[knee] + 0.9 * (joints[hip] - joints[knee])  # folded onto the thigh
    angles = []
    for scale_m in (0.005, 1.0):
        scales_m = np.full((len(JOINTS), 3), 0.005)
        scales_m[ankle] = scale_m
        found = fitted(proposed(joints, scales_m=scales_m))[0]
        bone, other = found[hip] - found[knee], found[ankle] - found[knee]
        cosine = bone @ other / np.linalg.norm(bone) / np.linalg.norm(other)
        angles.append(180.0 - np.degrees(np.arccos(cosine)))
    assert angles[0] > 150.0 > np.degrees(KNEE_FLEXION_RAD) + 1.0 > angles[1]


@pytest.mark.parametrize("name", ["iterations", "limit_weight", "prior_weight"])
def test_a_setting_out_of_range_is_one_line(name):
    with pytest.raises(InputError, match=f"{name} is -1"):
        JointFitSettings(**{name: -1})
