"""A thing that is taken for a part of a person is told by what the body leaves open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rendered_bodies import CAMERA, MODEL, evidence_in, evidence_of, render, standing_pose
from topview.records import KINECT1_NOISE
from topview.room.background import TOLERANCE_M
from topview.track.evidence import Evidence
from topview.track.methods.topview.refinement import RefinementSettings, explained
from topview.track.methods.topview.things import LEFT_OPEN_S, Things
from topview.track.methods.topview.whole_body import Found
from topview.track.pose import Pose

POSE = standing_pose()
FOUND = Found(POSE, MODEL, 0.1, 0.0)
ELAPSED_S = 1 / 30
FRAMES = int(3 * LEFT_OPEN_S / ELAPSED_S)
BACK = np.s_[45:85, 96:126]  # of a chair beside the body, which does not hide it


def with_chair(depth_m: float = 2.9) -> tuple[Evidence, np.ndarray]:
    """A body and a plate that is the user's as well, and [H, W] which pixels are the plate."""
    depth = render(POSE)
    is_chair = np.zeros(depth.shape, np.bool_)
    is_chair[BACK] = True
    is_chair &= depth == 0.0
    depth[is_chair] = depth_m
    head = evidence_of(POSE).head_camera
    return evidence_in(depth, depth > 0.0, head, MODEL, CAMERA).with_normals(), is_chair


def after(things: Things, evidence: Evidence, frames: int, found: Found = FOUND) -> Evidence:
    """What is left of the evidence when it has been seen in so many frames."""
    told = explained(found.pose, found.model, evidence, RefinementSettings())
    for _ in range(frames):
        things.left_out(evidence)
        things.update(evidence, told, ELAPSED_S)
    return things.left_out(evidence)


@pytest.fixture
def things() -> Things:
    return Things()


def test_nothing_of_a_body_that_is_explained_is_left_out(things):
    evidence = evidence_of(POSE).with_normals()
    assert after(things, evidence, FRAMES) is evidence


def test_what_a_body_leaves_open_is_left_out_in_time(things):
    evidence, is_chair = with_chair()
    assert things.left_out(evidence) is evidence
    assert after(things, evidence, 1) is evidence
    rest = after(things, evidence, FRAMES)
    assert np.count_nonzero(rest.user_mask & is_chair) < 0.2 * np.count_nonzero(is_chair)
    is_body = evidence.user_mask & ~is_chair
    assert np.count_nonzero(rest.user_mask & is_body) > 0.97 * np.count_nonzero(is_body)


def test_what_moves_is_the_persons_until_it_is_looked_at_anew(things):
    after(things, with_chair()[0], FRAMES)
    moved, is_chair = with_chair(2.9 - 6.0 * float(KINECT1_NOISE.sigma_m(2.9)) - TOLERANCE_M)
    assert things.left_out(moved).user_mask[is_chair].all()


def test_what_only_the_noise_moves_or_hides_for_a_frame_stays_a_thing(things):
    evidence, _ = with_chair()
    rest = after(things, evidence, FRAMES)
    noisy, _ = with_chair(2.9 - 1.5 * TOLERANCE_M)
    assert_array_equal(things.left_out(noisy).user_mask, rest.user_mask)
    things.left_out(evidence_of(POSE))  # without a reading of the chair
    assert_array_equal(things.left_out(noisy).user_mask, rest.user_mask)


def test_what_a_body_comes_to_explain_is_the_persons_again(things):
    whole = evidence_of(POSE).with_normals()
    raised = POSE.Rs.copy()
    raised[5:7] = raised[5:7] @ np.diag([1.0, -1.0, -1.0])  # the right arm, up
    without_arm = Found(Pose(POSE.neck_camera, raised), MODEL, 0.1, 0.0)
    rest = after(things, whole, FRAMES, without_arm)
    assert np.count_nonzero(rest.user_mask) < np.count_nonzero(whole.user_mask)
    again = after(things, whole, FRAMES)
    assert_array_equal(again.user_mask, whole.user_mask)


def test_a_body_that_leaves_most_open_tells_nothing(things):
    evidence, _ = with_chair()
    elsewhere = replace(FOUND, pose=Pose(POSE.neck_camera + np.array([0.0, 0.0, 0.6]), POSE.Rs))
    assert after(things, evidence, FRAMES, elsewhere) is evidence


def test_what_is_left_out_is_in_none_of_the_evidence():
    evidence, is_chair = with_chair()
    rest = evidence.without(is_chair)
    assert_array_equal(rest.user_mask, evidence.user_mask & ~is_chair)
    assert_array_equal(np.sort(rest.pixels), np.flatnonzero(rest.user_mask))
    assert len(rest.all_points_camera) == len(rest.pixels)
    rows, columns, _ = rest.view.nearest_pixels(rest.points_camera, 0.1)
    assert rest.user_mask[rows, columns].all()
    assert len(rest.normals_camera) == len(rest.points_camera) < len(evidence.points_camera)
    alone = evidence_of(POSE)
    assert rest.nearest.corner == alone.nearest.corner
    assert_array_equal(rest.nearest.columns, alone.nearest.columns)


def test_all_may_be_left_out():
    evidence = evidence_of(POSE)
    rest = evidence.without(evidence.user_mask)
    assert not rest.user_mask.any()
    assert rest.points_camera.shape == rest.normals_camera.shape == (0, 3)
