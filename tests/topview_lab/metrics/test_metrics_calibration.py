"""Does a stated 10 cm hold as often as it says, and are joints hidden by what is told?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from skeleton_sequences import B, J, people_standing, predicted_of, reference_of
from topview.records import JointState
from topview_lab.metrics import (
    ALL,
    CAUSES,
    UNHIDDEN,
    Calibration,
    calibrate,
    evaluate_sequence,
    pool,
    true_states,
)
from topview_lab.metrics.calibration import CALIBRATED_SPLITS

NO_ORIENTATION = np.full((1, 1, B, 3, 3), np.nan)  # and so no offset: distances as they are


def calibration(holds: np.ndarray, confidence: np.ndarray, **other: np.ndarray) -> Calibration:
    """Of [F, J] joints that are right, or 20 cm off, and [F, J] confidences."""
    F = len(holds)
    truth = people_standing(F, 0.0)
    predicted = truth.copy()
    predicted[:, 0, :, 2] += np.where(holds, 0.0, 0.2)
    of_predicted = {
        "joint_confidence": confidence[:, None].astype(np.float32),
        "joint_state": other.pop("joint_state", np.ones((F, 1, J), np.uint8)),
    }
    evaluation = evaluate_sequence(
        predicted_of(predicted, NO_ORIENTATION, **of_predicted), reference_of(truth, **other)
    )
    return calibrate(pool(evaluation))


class TestLaws:
    @settings(max_examples=10)
    @given(st.integers(0, 2**32 - 1))
    def test_a_calibrated_predictor_has_hardly_any_error(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        confidence = rng.random((1000, J))
        result = calibration(rng.random((1000, J)) < confidence, confidence)
        assert result.expected_error < 0.03
        # The mean of p (1 - p) over uniform p: no predictor of these does better.
        assert result.brier == pytest.approx(1 / 6, abs=0.02)
        for b, row in enumerate(result.bins):
            assert row.confidence == pytest.approx((b + 0.5) / 10, abs=0.02)
            assert row.holds == pytest.approx(row.confidence, abs=0.07)
        assert sum(row.count for row in result.bins) == result.overall.count == 1000 * J

    @settings(max_examples=25)
    @given(st.integers(0, 2**32 - 1))
    def test_the_brier_score_bounds_the_expected_error(self, seed: int) -> None:
        """A bin's error is the mean of its joints' errors, and a mean's square is at most the mean
        of the squares."""
        rng = np.random.default_rng(seed)
        holds, confidence = rng.random((5, J)) < rng.random(), rng.random((5, J))
        result = calibration(holds, confidence)
        assert result.brier == pytest.approx(((holds - confidence) ** 2).mean())
        assert 0.0 < result.expected_error < np.sqrt(result.brier)

    @settings(max_examples=25)
    @given(st.integers(0, 2**32 - 1))
    def test_told_shares_sum_to_one(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        hidden = rng.random((5, 1, J))
        states = rng.integers(1, 6, (5, 1, J)).astype(np.uint8)
        result = calibration(
            np.ones((5, J)), np.ones((5, J)), joint_state=states, occluded_by_self=hidden
        )
        assert sum(result.true_states.values()) == 5 * J
        for told in result.told_states.values():
            assert sum(told.values()) == pytest.approx(1.0)


class TestEllipsoids:
    @settings(max_examples=10)
    @given(st.integers(0, 2**32 - 1), st.floats(0.3, 3.0))
    def test_ellipsoids_hold_what_a_gaussian_s_hold(self, seed: int, stated: float) -> None:
        """Errors of one covariance, and another one stated: that many times as wide."""
        rng = np.random.default_rng(seed)
        root = rng.normal(size=(3, 3)) * 0.05
        F = 600
        truth = people_standing(F, 0.0)
        errors = rng.normal(size=(F, 1, J, 3)) @ root.T
        covariance = np.broadcast_to(stated**2 * root @ root.T, (F, 1, J, 3, 3))
        predicted = predicted_of(
            truth + errors, NO_ORIENTATION, joint_covariance_m2=covariance.astype(np.float32)
        )
        splits = calibrate(pool(evaluate_sequence(predicted, reference_of(truth)))).splits
        expected = chi2.cdf(chi2.ppf(0.9, 3) * stated**2, 3)
        assert splits[ALL].inside_90 == pytest.approx(expected, abs=0.03)
        assert splits[ALL].stated.count == F * J
        assert splits[UNHIDDEN].stated.count == 0  # nobody knows what is hidden

    def test_hidden_joints_are_told_apart(self) -> None:
        hidden = np.zeros((1, 1, J))
        hidden[..., :4] = 0.4
        holds = np.arange(J)[None] >= 2
        result = calibration(holds, np.full((1, J), 0.75), occluded_by_person=hidden)
        of_hidden, of_others = result.splits[CALIBRATED_SPLITS[2]], result.splits[UNHIDDEN]
        assert (of_hidden.stated.count, of_hidden.stated.holds) == (4, 0.5)
        assert of_hidden.expected_error == pytest.approx(0.25)
        assert (of_others.stated.count, of_others.stated.holds) == (J - 4, 1.0)
        assert np.isnan(of_hidden.inside_90)  # no covariances


class TestExamples:
    def test_three_in_four_when_90_percent_are_stated(self) -> None:
        holds = np.tile([True, True, True, False], (1, J // 4))
        result = calibration(holds, np.full((1, J), 0.9))
        assert result.overall.count == J
        assert result.overall.holds == 0.75
        assert result.expected_error == pytest.approx(0.15)
        assert result.brier == pytest.approx(0.75 * 0.01 + 0.25 * 0.81)
        assert [row.count for row in result.bins] == [*[0] * 9, J]
        assert np.isnan(result.bins[0].holds)

    def test_certainty_is_in_the_last_bin(self) -> None:
        result = calibration(np.ones((1, J), bool), np.ones((1, J)))
        assert result.bins[-1].count == J
        assert (result.expected_error, result.brier) == (0.0, 0.0)

    def test_by_state(self) -> None:
        states = np.full((1, 1, J), JointState.VISIBLE, np.uint8)
        states[..., :4] = JointState.SELF_OCCLUDED
        holds = np.arange(J)[None] >= 2
        result = calibration(holds, np.where(np.arange(J) < 4, 0.3, 0.8)[None], joint_state=states)
        assert set(result.states) == {"visible", "self_occluded"}
        hidden = result.states["self_occluded"]
        assert (hidden.count, hidden.holds) == (4, 0.5)
        assert hidden.confidence == pytest.approx(0.3)
        assert result.states["visible"].holds == 1.0
        assert result.told_states == result.true_states == {}

    def test_states_are_compared_with_what_hides_the_joint(self) -> None:
        hidden = np.zeros((1, 1, J))
        hidden[..., :4] = 0.9
        states = np.full((1, 1, J), JointState.VISIBLE, np.uint8)
        states[..., 1:4] = JointState.OCCLUDED_BY_PERSON
        result = calibration(
            np.ones((1, J)), np.ones((1, J)), joint_state=states, occluded_by_person=hidden
        )
        assert result.true_states == {"visible": J - 4, "occluded_by_person": 4}
        assert result.told_states["visible"]["visible"] == 1.0
        assert result.told_states["occluded_by_person"]["occluded_by_person"] == 0.75
        assert result.told_states["occluded_by_person"]["visible"] == 0.25

    @pytest.mark.parametrize(
        ("shares", "expected"),
        [
            ((0.0, 0.0, 0.0, 0.0), JointState.VISIBLE),
            ((0.4, 0.0, 0.0, 0.0), JointState.VISIBLE),
            ((0.6, 0.0, 0.0, 0.0), JointState.OCCLUDED_BY_PERSON),
            ((0.1, 0.8, 0.0, 0.0), JointState.SELF_OCCLUDED),
            ((0.2, 0.2, 0.5, 0.0), JointState.OCCLUDED_BY_OBJECT),
            ((np.nan, np.nan, np.nan, 0.7), JointState.OUT_OF_VIEW),
            ((np.nan, np.nan, np.nan, np.nan), JointState.ABSENT),
        ],
    )
    def test_true_states(self, shares: tuple[float, ...], expected: JointState) -> None:
        assert len(shares) == len(CAUSES)
        assert true_states(np.array(shares)) == expected

    def test_nobody_found(self) -> None:
        truth = people_standing(2, 0.0)
        nobody = predicted_of(np.full_like(truth, np.nan))
        result = calibrate(pool(evaluate_sequence(nobody, reference_of(truth))))
        assert result.overall.count == 0
        assert np.isnan([result.expected_error, result.brier]).all()
