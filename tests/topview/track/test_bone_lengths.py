"""Bones are learnt from proposed joints."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rendered_bodies import joints_of, standing_pose
from topview.body.model import BodyModel
from topview.body.parts import JOINT_NAMES, LOWER_TORSO, PARTS
from topview.body.proportions import ANATOMICAL
from topview.detect.joints import JointProposals
from topview.track.bone_lengths import PROPOSED_LENGTHS, BoneLengths, model_of_bones
from topview.track.joint_fit import JointFitSettings, fit_joints

STATURE_M = 1.6
# Somebody whose bones are not those of the stature.
RATIOS = dict(zip(PROPOSED_LENGTHS, np.linspace(0.85, 1.2, len(PROPOSED_LENGTHS)), strict=True))
TRUE_M = {name: float(RATIOS[name]) * share * STATURE_M for name, share in PROPOSED_LENGTHS.items()}
TRUTH = model_of_bones(TRUE_M, STATURE_M)


def seen(joints: np.ndarray, scale_m: float, noise: np.ndarray | None = None) -> JointProposals:
    """[16, 3] joints as proposals with errors of Laplace's law."""
    moved = joints if noise is None else joints + scale_m * noise
    return JointProposals(
        moved[None, None],
        np.full((1, 1, len(joints), 3), scale_m),
        np.ones((1, 1)),
        np.ones(1),
        JOINT_NAMES,
    )


def learnt(scales_m: list[float], *, is_noisy: bool = True) -> np.ndarray:
    """The lengths after frames of these scales."""
    rng, bones = np.random.default_rng(0), BoneLengths()
    joints = joints_of(standing_pose(), TRUTH)
    for scale_m in scales_m:
        noise = rng.laplace(size=joints.shape) if is_noisy else None
        bones.update(seen(joints, scale_m, noise), 0, STATURE_M)
    return bones.lengths_m(STATURE_M)


def test_before_any_frame_they_are_those_of_the_stature():
    assert_allclose(learnt([]), np.array(list(PROPOSED_LENGTHS.values())) * STATURE_M)


def test_noisy_joints_tell_them_in_the_end():
    assert_allclose(learnt([0.01] * 300), list(TRUE_M.values()), atol=0.006)


def test_doubted_joints_tell_them_too_where_they_are_right():
    assert_allclose(learnt([0.03] * 2000, is_noisy=False), list(TRUE_M.values()), atol=0.002)


def test_unsure_frames_hardly_count():
    sure = learnt([0.01] * 20)
    assert_allclose(learnt([0.01] * 20 + [0.5] * 20), sure, atol=0.004)


def test_a_joint_that_is_not_proposed_teaches_nothing():
    joints, bones = joints_of(standing_pose(), TRUTH), BoneLengths()
    whole = seen(joints, 0.005)
    kept = [index for index, name in enumerate(JOINT_NAMES) if "knee" not in name]
    bones.update(
        JointProposals(
            whole.positions_camera[:, :, kept],
            whole.scales_m[:, :, kept],
            whole.weights,
            whole.p_person,
            tuple(JOINT_NAMES[index] for index in kept),
        ),
        0,
        STATURE_M,
    )
    told = dict(zip(PROPOSED_LENGTHS, bones.lengths_m(STATURE_M), strict=True))
    for name, share in PROPOSED_LENGTHS.items():
        is_prior = told[name] == pytest.approx(share * STATURE_M)
        assert is_prior == name.endswith("_leg"), name


def test_a_body_of_these_bones_has_its_joints_where_they_are_proposed():
    """Also for a fit to the body of the stature, whose joints then lie elsewhere."""
    joints, bones = joints_of(standing_pose(), TRUTH), BoneLengths()
    for _ in range(100):
        bones.update(seen(joints, 0.005), 0, STATURE_M)
    model, settings = bones.model(STATURE_M), JointFitSettings()
    (pose,) = fit_joints(model, seen(joints, 0.01), settings).poses
    assert np.abs(joints_of(pose, model) - joints).max() < 0.005
    by_stature = BodyModel.of(STATURE_M, ANATOMICAL)
    (pose,) = fit_joints(by_stature, seen(joints, 0.01), settings).poses
    assert np.abs(joints_of(pose, by_stature) - joints).max() > 0.03


def test_the_parts_hang_together():
    """Every part but the arms and legs begins where the one that it hangs from ends."""
    for index, part in enumerate(PARTS):
        if part.parent >= 0 and "upper_arm" not in part.name:
            assert TRUTH.joints_parent[index, 1] == TRUTH.lengths_m[part.parent]
    assert TRUTH.joints_part[JOINT_NAMES.index("pelvis"), 1] == TRUTH.lengths_m[LOWER_TORSO]
    assert TRUTH.stature_m == STATURE_M


def test_joints_that_are_proposed_at_one_place_tell_no_length():
    """As a proposer does that knows nothing of them."""
    joints = joints_of(standing_pose(), TRUTH)
    elbow, hand = (JOINT_NAMES.index(f"left_{name}") for name in ("elbow", "hand"))
    joints[hand] = joints[elbow]
    bones = BoneLengths()
    bones.update(seen(joints, 0.01), 0, STATURE_M)
    forearm = list(PROPOSED_LENGTHS).index("forearm")
    lengths_m = bones.lengths_m(STATURE_M)
    assert np.isfinite(lengths_m).all()
    assert lengths_m[forearm] == pytest.approx(TRUE_M["forearm"], abs=0.02)
