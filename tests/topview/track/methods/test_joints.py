"""The method that fits a body to proposed joints, and does nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, evidence_of, joints_of, standing_pose, subject
from topview.body.parts import JOINT_NAMES
from topview.detect.joints import JointProposals
from topview.track.evidence import Evidence
from topview.track.methods import method_by_name
from topview.track.methods.joints import JointsSettings, JointsTracker
from topview.track.pose import Pose

POSES = [standing_pose(yaw_rad, 2.6 + 0.1 * k) for k, yaw_rad in enumerate((0.3, 0.5, 0.7, 0.9))]
EVIDENCE = evidence_of(POSES[0])


def evidence(pose: Pose, weights: tuple[float, float] = (0.2, 0.8)) -> Evidence:
    """Proposals whose second mode is the body, and the first one 30 cm aside."""
    joints = joints_of(pose)
    proposals = JointProposals(
        np.stack([joints + np.array([0.3, 0.0, 0.0]), joints])[None],
        np.full((1, 2, len(joints), 3), 0.01),
        np.array([weights]),
        np.ones(1),
        JOINT_NAMES,
    )
    return replace(EVIDENCE, proposals=proposals)


def tracker() -> JointsTracker:
    made = method_by_name("joints").tracker(subject())
    assert isinstance(made, JointsTracker)
    return made


def test_it_asks_for_joints():
    assert JointsSettings().needs.joints


def test_the_likeliest_mode_is_taken_and_the_bones_are_learnt():
    body = tracker()
    errors_m = []
    for _ in range(20):
        for pose in POSES:
            found = joints_of(body.update(evidence(pose)), body.model)
            errors_m.append(np.abs(found - joints_of(pose)).max())
    assert errors_m[0] < 0.08
    assert errors_m[-1] < 0.01
    assert body.model.stature_m == MODEL.stature_m


def test_the_pose_is_found_anew_in_each_frame():
    """Whatever the same person did before."""
    found = []
    for before in (POSES[0], POSES[2]):
        body = tracker()
        for _ in range(30):
            body.update(evidence(before))
        found.append(body.update(evidence(POSES[3])))
    assert_allclose(found[0].Rs, found[1].Rs, atol=0.001)
    assert_allclose(found[0].neck_camera, found[1].neck_camera, atol=0.001)


def test_without_proposals_the_pose_is_kept_below_the_head():
    body = tracker()
    pose = body.update(evidence(POSES[1]))
    head = JOINT_NAMES.index("head")
    for nothing in (EVIDENCE, evidence(POSES[2], weights=(0.0, 0.0))):
        there = replace(nothing, head_camera=np.array([0.4, -0.6, 3.0]), head_is_seen=False)
        kept = body.update(there)
        assert_array_equal(kept.Rs, pose.Rs)
        assert_allclose(joints_of(kept, body.model)[head], there.head_camera, atol=1e-12)


def test_somebody_of_whom_nothing_was_ever_proposed_stands_below_the_head():
    body = tracker()
    joints = joints_of(body.update(EVIDENCE), body.model)
    assert_allclose(joints[JOINT_NAMES.index("head")], EVIDENCE.head_camera, atol=1e-12)
    assert joints[JOINT_NAMES.index("left_ankle"), 1] > joints[JOINT_NAMES.index("neck"), 1] + 1.0
