"""Limbs as they usually are, and what the whole body costs with them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rendered_bodies import MODEL, evidence_of, joints_of, standing_pose, subject
from topview.body import JOINT_NAMES
from topview.body.parts import LEFT_UPPER_ARM, RIGHT_UPPER_ARM
from topview.geometry.rotations import rotations_from_angles
from topview.kernels.threads import use_threads
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.methods.topview.usual_limbs import (
    DIFFERENT_LENGTHS,
    LIMB_POSES,
    LimbScan,
    usual_limbs,
)
from topview.track.methods.topview.whole_body import FrameContext, costs_of
from topview.track.pose import LIMBS, MIRRORED, OTHER_SIDE, Pose

SETTINGS = RefinementSettings()
limbs = pytest.mark.parametrize("upper", LIMBS)


def look_at(pose: Pose) -> FrameContext:
    evidence = evidence_of(pose).with_normals()
    return FrameContext(MODEL, evidence, subject().clock, 1 / 30)


def with_limb(pose: Pose, upper: int, limb: np.ndarray) -> Pose:
    relative = pose.relative()
    relative[upper : upper + 2] = limb
    return Pose.from_relative(pose.neck_camera, relative)


@limbs
def test_usual_limbs_are_rotations_and_those_of_the_other_side_their_mirror_images(upper):
    usual = usual_limbs(upper)
    assert usual.shape == (LIMB_POSES, 2, 3, 3)
    assert_allclose(
        usual @ np.swapaxes(usual, -1, -2), np.broadcast_to(np.eye(3), usual.shape), atol=1e-6
    )
    assert_allclose(usual_limbs(OTHER_SIDE[upper]), MIRRORED @ usual @ MIRRORED)


@limbs
def test_usual_limbs_are_spread_over_all_that_limbs_do(upper):
    ways = usual_limbs(upper)[:, 0, :, 1]
    apart = np.linalg.norm(ways[:, None] - ways, axis=-1)
    assert (np.sort(apart, axis=1)[:, 1] < 0.5).all()
    assert apart.max() > 1.5


@limbs
def test_a_limbs_cost_is_what_the_whole_bodys_changes_by(upper):
    """But for points of which next to nothing is left open."""
    pose = standing_pose()
    look, tried = look_at(pose), usual_limbs(upper)[:60]
    scanned = LimbScan(pose, look, SETTINGS).costs(upper, tried)
    poses = [with_limb(pose, upper, limb) for limb in tried]
    whole = costs_of(refine(poses, None, MODEL, look.evidence, SETTINGS, iterations=0))
    assert_allclose(scanned - scanned[0], whole - whole[0], atol=1e-4)
    assert np.ptp(whole) > 0.1


@limbs
def test_the_true_limb_costs_least(upper):
    pose = standing_pose()
    limb = pose.relative()[None, upper : upper + 2]
    tried = np.concatenate([usual_limbs(upper), limb])
    away = with_limb(pose, upper, usual_limbs(upper)[0])
    found = LimbScan(away, look_at(pose), SETTINGS).likeliest(upper, tried, 3)
    assert_array_equal(found[0], limb[0])


@pytest.mark.parametrize("margin", [-0.05, 0.0, 0.02])
def test_what_costs_more_than_the_limb_as_it_is_is_left_out(margin):
    upper = RIGHT_UPPER_ARM
    away = with_limb(standing_pose(), upper, usual_limbs(upper)[0])
    scan = LimbScan(away, look_at(standing_pose()), SETTINGS)
    found = scan.likeliest(upper, usual_limbs(upper), 400)
    own, *costs = scan.costs(upper, np.concatenate([usual_limbs(upper)[:1], found]))
    is_left = np.array(costs) < own + margin
    assert is_left.any()
    assert not is_left.all()
    assert_array_equal(scan.likeliest(upper, usual_limbs(upper), 400, margin), found[is_left])


def test_what_is_likeliest_differs():
    pose = standing_pose()
    tried = usual_limbs(RIGHT_UPPER_ARM)
    scan = LimbScan(pose, look_at(pose), SETTINGS)
    found = scan.likeliest(RIGHT_UPPER_ARM, tried, 6)
    elbows = found[:, 0, :, 1]
    ends = np.concatenate([elbows, elbows + (found[:, 0] @ found[:, 1])[..., 1]], axis=1)
    apart = np.linalg.norm(ends[:, None] - ends, axis=-1)
    assert len(found) == 6
    assert (apart[~np.eye(6, dtype=bool)] > DIFFERENT_LENGTHS).all()


def test_threads_change_nothing():
    pose = standing_pose()
    look, tried = look_at(pose), usual_limbs(LEFT_UPPER_ARM)
    costs = []
    for threads in (1, 2):
        use_threads(threads)
        costs.append(LimbScan(pose, look, SETTINGS).costs(LEFT_UPPER_ARM, tried))
    assert_array_equal(*costs)


def test_an_arm_that_is_elsewhere_is_found_by_its_points():
    hanging = standing_pose()
    relative = hanging.relative()
    relative[LEFT_UPPER_ARM] = rotations_from_angles(np.radians([0.0, 0.0, 80.0]))
    raised = Pose.from_relative(hanging.neck_camera, relative)
    look = look_at(raised)
    scan = LimbScan(hanging, look, SETTINGS)
    likeliest = scan.likeliest(LEFT_UPPER_ARM, usual_limbs(LEFT_UPPER_ARM), 2)
    starts = [with_limb(hanging, LEFT_UPPER_ARM, limb) for limb in likeliest]
    refined = refine(starts, None, MODEL, look.evidence, SETTINGS)
    best = refined.poses[int(np.argmin(costs_of(refined)))]
    hand = JOINT_NAMES.index("left_hand")
    assert np.linalg.norm(joints_of(best)[hand] - joints_of(raised)[hand]) < 0.05


def test_limbs_that_end_where_points_are_open_are_tried_too():
    hanging = standing_pose()
    relative = hanging.relative()
    relative[LEFT_UPPER_ARM] = rotations_from_angles(np.radians([0.0, 0.0, 80.0]))
    raised = Pose.from_relative(hanging.neck_camera, relative)
    scan = LimbScan(hanging, look_at(raised), SETTINGS)
    hand, place = JOINT_NAMES.index("left_hand"), joints_of(raised)
    away = [
        np.linalg.norm(joints_of(with_limb(hanging, LEFT_UPPER_ARM, limb))[hand] - place[hand])
        for limb in scan.likeliest(LEFT_UPPER_ARM, np.empty((0, 2, 3, 3)), 2)
    ]
    assert min(away) < 0.15
