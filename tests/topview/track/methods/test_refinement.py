"""Refinement finds a body back that it knows, the same whatever is refined beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from rendered_bodies import MODEL, UP, evidence_of, joints_of, standing_pose
from topview.body.parts import PART_NAMES, PARTS
from topview.geometry.rotations import rotations_from_angles, rotations_from_vectors
from topview.kernels.body import marginal_information
from topview.track.evidence import Evidence
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.pose import Pose
from topview.track.stances import Stance, stand

SETTINGS = RefinementSettings()
TRUTH = standing_pose()


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return evidence_of(TRUTH)


def perturbed(seed: int) -> Pose:
    """The true pose with the neck 2 cm off and every joint turned by 2 degrees about its axes, so
    that every part stays within the reach of its points."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(0.0, np.radians(2.0), (len(PARTS), 3))
    turns[[part.is_hinge for part in PARTS], 1:] = 0.0
    Rs = TRUTH.relative() @ rotations_from_vectors(turns)
    return Pose.from_relative(TRUTH.neck_camera + rng.normal(0.0, 0.02, 3), Rs)


def errors_cm(poses: list[Pose]) -> np.ndarray:
    """[M, 16]"""
    truth = joints_of(TRUTH)
    return np.array([100 * np.linalg.norm(joints_of(pose) - truth, axis=1) for pose in poses])


def test_a_perturbed_body_is_found_back(evidence):
    """Two rounds, as two frames would give: a start is held softly to where it is, with 4 per
    square radian, against some 1.3 of a whole forearm's points, so that one round leaves a part."""
    start = [perturbed(seed) for seed in range(8)]
    poses = start
    for _ in range(2):
        poses = refine(poses, None, MODEL, evidence, SETTINGS).poses
    before, after = errors_cm(start), errors_cm(poses)
    assert before.max() > 15.0
    assert after.max() < 2.5
    assert after.mean() < 1.0


def test_the_true_pose_stays_and_explains_everything(evidence):
    refined = refine([TRUTH], None, MODEL, evidence, SETTINGS)
    # not zero: where two parts overlap, a point of one is taken for the other's
    assert errors_cm(refined.poses).max() < 1.0
    assert refined.unexplained[0] < 0.01
    assert refined.in_free_space[0] == 0.0


def test_legs_that_are_seen_bend_farther_than_table_3_2_and_hidden_ones_do_not():
    """Who sits low bends hips and knees by more than 100 degrees."""
    low = Stance(hip=115, knee=115)
    truth = stand(MODEL, np.array([0.05, -0.3, 2.6]), low, 1.2, UP)
    evidence = evidence_of(truth)

    def farthest_cm(is_hidden: bool) -> float:
        (found,) = refine([truth], None, MODEL, evidence, SETTINGS, is_hidden=is_hidden).poses
        return 100 * float(np.linalg.norm(joints_of(found) - joints_of(truth), axis=1).max())

    assert farthest_cm(False) < 1.5
    assert farthest_cm(True) > 3.0


@pytest.mark.parametrize("seed", range(4))
def test_a_fit_that_gains_hardly_more_ends(evidence, seed):
    few, many = (
        refine([perturbed(seed)], None, MODEL, evidence, SETTINGS, iterations=steps).poses[0]
        for steps in (12, 100)
    )
    assert_array_equal(few.Rs, many.Rs)
    assert_array_equal(few.neck_camera, many.neck_camera)


def test_costs_tell_a_wrong_pose(evidence):
    relative = TRUTH.relative()
    for part in ("left_upper_arm", "right_upper_leg"):
        raised = rotations_from_angles(np.radians([0.0, 0.0, 60.0 if "left" in part else -60.0]))
        relative[PART_NAMES.index(part)] = raised
    wrong = Pose.from_relative(TRUTH.neck_camera, relative)
    refined = refine([TRUTH, wrong], None, MODEL, evidence, SETTINGS, iterations=0)
    assert_array_equal(refined.poses[1].Rs, wrong.Rs)  # without iterations it only measures
    assert refined.unexplained[1] > refined.unexplained[0] + 0.1
    assert refined.in_free_space[1] > refined.in_free_space[0] + 0.05


def test_a_surface_that_faces_elsewhere_explains_less(evidence):
    refined = [
        refine([TRUTH], None, MODEL, own, SETTINGS, iterations=0)
        for own in (evidence, evidence.with_normals(), turned_aside(evidence.with_normals()))
    ]
    unasked, seen, aside = (one.unexplained[0] for one in refined)
    assert unasked < seen < 0.1
    assert aside > seen + 0.1


def turned_aside(evidence: Evidence) -> Evidence:
    """With all normals turned by a right angle about the line of sight's vertical."""
    x, y, z = evidence.normals_camera.T
    return replace(evidence, normals_camera=np.stack([-z, y, x], axis=1))


def test_departure_is_measured_from_the_prior(evidence):
    start = perturbed(0)
    held = refine([start], TRUTH, MODEL, evidence, SETTINGS, iterations=0)
    own = refine([start], None, MODEL, evidence, SETTINGS, iterations=0)
    assert own.departure[0] == pytest.approx(0.0, abs=1e-12)
    assert 1e-4 < held.departure[0] < 0.1


def test_a_stiffer_prior_moves_less(evidence):
    start = perturbed(1)
    stiff = replace(SETTINGS, turn_prior_weight=1e6, twist_prior_weight=1e6, place_prior_weight=1e6)
    free, held = (refine([start], None, MODEL, evidence, s).poses[0] for s in (SETTINGS, stiff))
    moved = [np.abs(joints_of(pose) - joints_of(start)).max() for pose in (free, held)]
    assert moved[1] < 0.001 < 0.02 < moved[0]


def test_every_candidate_is_refined_as_if_it_were_alone(evidence):
    candidates = [perturbed(seed) for seed in range(5)]
    together = refine(candidates, TRUTH, MODEL, evidence, SETTINGS)
    for index in (0, 3):
        alone = refine([candidates[index]], TRUTH, MODEL, evidence, SETTINGS)
        assert_array_equal(alone.poses[0].Rs, together.poses[index].Rs)
        assert_array_equal(alone.poses[0].neck_camera, together.poses[index].neck_camera)
        assert alone.unexplained[0] == together.unexplained[index]
    again = refine(candidates[::-1], TRUTH, MODEL, evidence, SETTINGS)
    assert_array_equal(again.poses[0].Rs, together.poses[-1].Rs)


def test_refinement_leaves_its_inputs_alone(evidence):
    start = perturbed(2)
    Rs, neck = start.Rs.copy(), start.neck_camera.copy()
    refine([start, start], None, MODEL, evidence, SETTINGS)
    assert_array_equal(start.Rs, Rs)
    assert_array_equal(start.neck_camera, neck)


def test_refined_rotations_are_proper(evidence):
    for pose in refine([perturbed(3)], None, MODEL, evidence, SETTINGS).poses:
        identity = pose.Rs @ np.swapaxes(pose.Rs, 1, 2)
        assert np.abs(identity - np.eye(3)).max() < 1e-9
        assert np.linalg.det(pose.Rs) == pytest.approx(1.0)


def test_what_is_known_of_each_degree_of_freedom_leaves_all_others_free():
    rng = np.random.default_rng(0)
    B = rng.normal(size=(28, 40))
    A = B @ B.T
    known = np.empty(6)
    marginal_information(np.linalg.cholesky(A), known)
    np.testing.assert_allclose(known, 1.0 / np.linalg.inv(A).diagonal()[:6])


def test_of_whom_more_is_seen_more_is_known(evidence):
    """With the prior, and never less than that."""
    few, none = (
        replace(evidence, points_camera=own, normals_camera=np.zeros_like(own))
        for own in (evidence.points_camera[::20].copy(), np.zeros((0, 3)))
    )
    known, less, nothing = (
        refine([TRUTH], None, MODEL, own, SETTINGS).information[0] for own in (evidence, few, none)
    )
    assert (known[:3] > less[:3]).all()
    assert (less[:3] > nothing[:3]).all()
    assert (nothing > 0.9 * SETTINGS.prior_weights[:6]).all()
