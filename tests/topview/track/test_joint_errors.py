"""How far joints may be off: the law's own laws, and what makes a joint less sure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs
from scipy.special import fdtri

from rendered_bodies import MODEL, standing_pose
from topview.body import OUTPUT_JOINT_NAMES as JOINT_NAMES
from topview.body.ends import output_joints
from topview.detect.joints import JointProposals
from topview.geometry.rotations import rotations_from_vectors
from topview.records import JointState
from topview.track.familiarity import Familiarity
from topview.track.joint_errors import (
    COUNTED_SHARES,
    ELLIPSOID,
    ELLIPSOID_SHARE,
    RIGHT_M,
    ErrorLaw,
    JointSigns,
    are_proposed,
    bounded,
    confidences_of,
    ellipsoid_covariances,
    kinds_of,
    shipped_joint_errors,
    told_errors,
)
from topview.track.visibility import Visibility

J = len(JOINT_NAMES)
HAND, KNEE, NECK = (JOINT_NAMES.index(name) for name in ("left_hand", "left_knee", "neck"))
JOINTS = output_joints(MODEL, standing_pose().transforms(MODEL))
ERRORS = shipped_joint_errors()
KINDS = list(range(len(ERRORS.laws)))


def proposals(
    scale_m: float = 0.02, off_m: float = 0.0, wrong_weight: float = 0.1
) -> JointProposals:
    """The joints, `off_m` farther away, and a mode that has them to the right by 20 cm."""
    modes = np.stack([JOINTS + np.array([0.0, 0.0, off_m]), JOINTS + np.array([0.2, 0.0, 0.0])])
    weights = np.array([[1.0 - wrong_weight, wrong_weight]])
    scales = np.full((1, 2, J, 3), scale_m)
    return JointProposals(modes[None], scales, weights, np.ones(1), JOINT_NAMES)


def signs(
    proposed: JointProposals | None,
    state: JointState = JointState.VISIBLE,
    confirmed: float = 1.0,
    hidden_for_s: float = 0.0,
) -> JointSigns:
    visibility = Visibility(np.full(J, state, np.uint8), np.full(J, confirmed))
    return JointSigns(JOINTS, visibility, np.full(J, hidden_for_s), proposed)


def told(own: JointSigns) -> tuple[np.ndarray, np.ndarray]:
    covariances, confidences = told_errors(own, ERRORS)
    assert covariances.dtype == confidences.dtype == np.float32
    return covariances, confidences


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.floats(2.5, 40.0), st.sampled_from(KINDS))
def test_ellipsoids_and_confidences_hold_for_errors_as_they_were_counted(seed, tails, kind):
    """Here as a Student law has them, whose matrix has these axes."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    root = axes * rng.uniform(0.25, 1.0, 3) * rng.uniform(0.02, 0.15)
    count = 20_000
    errors = rng.normal(size=(count, 3)) @ root.T
    errors /= np.sqrt(rng.chisquare(tails, count) / tails)[:, None]
    ellipsoid, *counted = 3.0 * fdtri(3.0, tails, [ELLIPSOID_SHARE, *COUNTED_SHARES])
    laws = list(ERRORS.laws)
    laws[kind] = ErrorLaw(tails, ellipsoid, tuple(counted))
    told, kinds = structs.replace(ERRORS, laws=tuple(laws)), np.array([kind])
    covariance = ellipsoid_covariances((root @ root.T)[None], told.ellipsoids_of(kinds))
    squared = (errors * np.linalg.solve(covariance[0], errors.T).T).sum(-1)
    assert (squared <= ELLIPSOID).mean() == pytest.approx(ELLIPSOID_SHARE, abs=0.01)
    stated = float(confidences_of(covariance, kinds, told)[0])
    within = (np.linalg.norm(errors, axis=-1) <= RIGHT_M).mean()
    assert stated == pytest.approx(within, abs=0.02)


def test_no_more_is_stated_than_was_counted():
    matrices = np.array([1e-10, 1e4])[:, None, None] * np.eye(3)
    for kind in KINDS:
        stated = confidences_of(matrices, np.full(2, kind), ERRORS)
        assert stated == pytest.approx([COUNTED_SHARES[-1], COUNTED_SHARES[0]])


def test_kinds_are_told_apart_by_what_is_proposed_and_by_who_is_before_them():
    is_proposed, is_behind = np.array([[True, True, False, False], [False, True, False, True]])
    assert kinds_of(is_proposed, is_behind).tolist() == KINDS
    for proposed in (None, proposals()):
        assert are_proposed(signs(proposed).terms()).tolist() == [proposed is not None] * J


def test_joints_of_an_unfamiliar_window_are_less_sure():
    own = signs(proposals())
    unfamiliar = replace(own, familiarity=Familiarity(residual=0.5, doubt=0.2))
    (covariances, confidences), (wider, less) = told(own), told(unfamiliar)
    assert (np.trace(wider, axis1=1, axis2=2) > np.trace(covariances, axis1=1, axis2=2)).all()
    assert (less < confidences).all()


@pytest.mark.parametrize("proposed", [None, proposals()])
@pytest.mark.parametrize("state", [s for s in JointState if s != JointState.ABSENT])
def test_every_joint_has_a_covariance_and_a_confidence(proposed, state):
    covariances, confidences = told(signs(proposed, state, 0.5, 0.2))
    np.testing.assert_allclose(covariances, np.swapaxes(covariances, -1, -2), rtol=1e-5)
    assert (np.linalg.eigvalsh(covariances) > 0.0).all()
    assert ((confidences > 0.0) & (confidences <= 1.0)).all()


def test_of_who_is_behind_another_arms_are_less_sure_than_trunk_and_legs():
    for state, is_less in ((JointState.OCCLUDED_BY_PERSON, True), (JointState.VISIBLE, False)):
        variances_m2 = np.trace(told(signs(proposals(), state))[0], axis1=1, axis2=2)
        less_sure = variances_m2[HAND] > 1.1 * variances_m2[[NECK, KNEE]]
        assert less_sure.all() if is_less else not less_sure.any()


def test_an_absent_joint_is_not_trusted_at_all():
    own = signs(proposals())
    joints, state = JOINTS.copy(), own.visibility.joint_state.copy()
    joints[KNEE], state[KNEE] = np.nan, JointState.ABSENT
    own = replace(own, joints_camera=joints, visibility=Visibility(state, own.visibility.confirmed))
    for proposed in (None, proposals()):
        covariances, confidences = told(replace(own, proposals=proposed))
        assert confidences[KNEE] == 0.0
        assert np.isnan(covariances[KNEE]).all()
        assert np.isfinite(np.delete(covariances, KNEE, axis=0)).all()
        assert (np.delete(confidences, KNEE) > 0.0).all()


class TestProposed:
    def test_what_is_proposed_less_surely_is_less_sure(self):
        sure, unsure = (told(signs(proposals(scale_m)))[1] for scale_m in (0.01, 0.05))
        assert (sure > unsure).all()

    def test_modes_that_differ_make_a_joint_less_sure_where_they_differ(self):
        one, two = (
            told(signs(proposals(wrong_weight=weight)))[0] - told(signs(proposals()))[0]
            for weight in (0.0, 0.4)
        )
        assert (one[:, 0, 0] < 0.0).all()
        assert (two[:, 0, 0] > 0.0).all()
        assert np.abs(two[:, 1, 1]).max() < 1e-3 * two[:, 0, 0].min()

    def test_a_body_apart_from_what_is_proposed_is_less_sure(self):
        near, far = (told(signs(proposals(off_m=off_m)))[1] for off_m in (0.0, 0.1))
        assert (near > far).all()

    def test_depth_is_told_along_the_ray(self):
        """Scales across and along: the longest axis points to the camera."""
        modes = proposals(wrong_weight=0.0)
        scales = np.broadcast_to([0.01, 0.01, 0.2], (1, 2, J, 3)).copy()
        covariances, _ = told(signs(replace(modes, scales_m=scales)))
        longest = np.linalg.eigh(covariances)[1][..., -1]
        rays = JOINTS / np.linalg.norm(JOINTS, axis=-1, keepdims=True)
        assert (np.abs((longest * rays).sum(-1)) > 0.99).all()

    def test_behind_another_person_it_is_less_sure(self):
        """Whose surface is near then."""
        beside = replace(proposals(0.05), to_cover_m=np.full((1, 2, J), 0.05))
        free, behind = (
            told(signs(proposed, state))[1]
            for proposed, state in (
                (proposals(0.05), JointState.VISIBLE),
                (beside, JointState.OCCLUDED_BY_PERSON),
            )
        )
        assert (free > behind).all()

    def test_joints_that_are_left_out_are_told_as_without_proposals(self):
        named = [name for name in JOINT_NAMES if name != "left_knee"]
        kept = [JOINT_NAMES.index(name) for name in named]
        whole = proposals()
        some = replace(
            whole,
            positions_camera=whole.positions_camera[:, :, kept],
            scales_m=whole.scales_m[:, :, kept],
            joint_names=tuple(named),
        )
        of_some, of_all, of_none = (signs(own).terms() for own in (some, whole, None))
        np.testing.assert_array_equal(of_some[:, KNEE], of_none[:, KNEE])
        np.testing.assert_array_equal(of_some[:, kept], of_all[:, kept])


class TestNotProposed:
    def test_hands_are_less_sure_than_the_trunk(self):
        confidences = told(signs(None))[1]
        assert confidences[HAND] < confidences[NECK]

    def test_what_nothing_confirms_is_less_sure(self):
        by_share = [told(signs(None, confirmed=share))[1] for share in (1.0, 0.5, 0.0)]
        assert (np.diff(by_share, axis=0) < 0.0).all()

    @pytest.mark.parametrize("state", [JointState.OCCLUDED_BY_OBJECT, JointState.OUT_OF_VIEW])
    def test_a_hidden_joint_fades(self, state):
        over_time = [told(signs(None, state, 0.0, t))[1] for t in (0.0, 0.5, 1.0, 5.0)]
        assert (np.diff(over_time, axis=0) < 0.0).all()


def test_what_proposals_state_is_bounded_along_each_axis():
    matrix = np.diag([1e-4, 0.05, 100.0])
    turn = rotations_from_vectors(np.array([0.3, -0.5, 0.2]))
    less = bounded(turn @ matrix @ turn.T, 0.05)
    assert np.array_equal(less, less.T)
    assert turn.T @ less @ turn == pytest.approx(np.diag([1e-4, 0.025, 0.05]), rel=0.01, abs=1e-9)
