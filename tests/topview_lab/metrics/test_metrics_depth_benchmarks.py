"""Joints within 10 cm as the benchmarks of depth images count them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skeleton_sequences import B, J, people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES
from topview_lab.metrics import (
    BODY_HALVES,
    WithinLimit,
    average_precision,
    benchmark,
    evaluate_sequence,
    pool,
)

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=25)
HAND = JOINT_NAMES.index("left_hand")


def measured(predicted: np.ndarray, truth: np.ndarray, **other: np.ndarray) -> dict:
    evaluation = evaluate_sequence(predicted_of(predicted, **other), reference_of(truth))
    return benchmark(pool(evaluation))


class TestAveragePrecision:
    def test_worked_example(self) -> None:
        """Right, wrong, right, with one of three never found: 1/3 x 1 + 1/3 x 2/3."""
        ap = average_precision(np.array([True, False, True]), np.array([0.9, 0.8, 0.7]), 3)
        assert ap == pytest.approx(1 / 3 + 2 / 9)

    def test_equals_enter_together(self) -> None:
        """Two thirds of the three are right, whatever their order."""
        for right in ([True, False, True], [False, True, True]):
            assert average_precision(np.array(right), np.full(3, 0.5), 2) == pytest.approx(2 / 3)

    def test_nothing(self) -> None:
        nothing = np.zeros(0)
        assert np.isnan(average_precision(nothing.astype(bool), nothing, 0))
        assert average_precision(nothing.astype(bool), nothing, 4) == 0.0

    @few
    @given(seeds)
    def test_right_before_wrong_is_best(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        is_right, confidence = rng.random(30) < 0.6, rng.random(30)
        count = int(is_right.sum()) + 3
        ap = average_precision(is_right, confidence, count)
        best = average_precision(is_right, is_right + confidence, count)
        worst = average_precision(is_right, confidence - is_right, count)
        assert 0.0 <= worst <= ap <= best
        assert best == pytest.approx(is_right.sum() / count)

    @few
    @given(seeds)
    def test_only_the_order_of_confidences_matters(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        is_right, confidence = rng.random(30) < 0.6, rng.random(30)
        of = rng.permutation(30)
        expected = average_precision(is_right, confidence, 30)
        assert average_precision(is_right[of], confidence[of] ** 3, 30) == pytest.approx(expected)


class TestBenchmark:
    def test_a_perfect_prediction(self) -> None:
        truth = people_standing(3, 0.0, 2.0)
        rows = measured(truth, truth)
        assert set(rows) == {*JOINT_NAMES, *BODY_HALVES, "all"}
        assert rows["head"] == WithinLimit(6, 1.0, 1.0, 1.0, 1.0)
        assert rows["all"] == WithinLimit(6 * J, 1.0, 1.0, 1.0, 1.0)

    def test_a_missed_person_is_wrong(self) -> None:
        truth = people_standing(4, 0.0, 2.0)
        predicted = truth.copy()
        predicted[0, 1] = np.nan
        rows = measured(predicted, truth)
        assert rows["left_hand"] == WithinLimit(8, *[7 / 8] * 4)
        assert rows["all"].raw == pytest.approx(7 / 8)

    def test_nobody_found(self) -> None:
        truth = people_standing(2, 0.0)
        assert measured(np.full_like(truth, np.nan), truth)["all"] == WithinLimit(2 * J, *[0.0] * 4)

    def test_a_false_person_spoils_the_ranking_alone(self) -> None:
        """Of each two predictions one is right, all equally sure."""
        truth = people_standing(4, 0.0)
        rows = measured(people_standing(4, 0.0, 3.0), truth)
        assert (rows["all"].raw, rows["all"].ranked) == pytest.approx((1.0, 0.5))

    def test_a_false_person_who_is_less_sure_does_not(self) -> None:
        truth = people_standing(4, 0.0)
        confidence = np.tile(np.array([0.9, 0.2], np.float32)[None, :, None], (4, 1, J))
        rows = measured(people_standing(4, 0.0, 3.0), truth, joint_confidence=confidence)
        assert rows["all"].ranked == pytest.approx(1.0)

    def test_halves_are_means_of_their_joints(self) -> None:
        """One of 8 upper joints 12 cm off in one of two frames; offset 6 cm, both right then."""
        truth = people_standing(2, 0.0)
        predicted = truth.copy()
        predicted[0, 0, HAND, 0] += 0.12
        rows = measured(predicted, truth)
        assert rows["left_hand"].raw == 0.5
        assert rows["left_hand"].offset_out == 1.0
        assert rows["upper body"].raw == pytest.approx(1.0 - 0.5 / 8)
        assert rows["lower body"].raw == 1.0
        assert rows["all"].raw == pytest.approx(1.0 - 0.5 / J)
        assert rows["upper body"].count == 2 * 8

    def test_the_halves_are_those_of_itop(self) -> None:
        """Haque et al. 2016, front view: their means of halves follow from their joints."""
        published = {"head": 98.1, "neck": 97.5, "shoulder": 96.5, "elbow": 73.3, "hand": 68.7}
        published |= {"hip": 72.0, "knee": 69.0, "ankle": 60.8}
        for half, expected in {"upper body": 84.0, "lower body": 67.3}.items():
            values = [published[joint.rsplit("_", 1)[-1]] for joint in BODY_HALVES[half]]
            assert np.mean(values) == pytest.approx(expected, abs=0.1)

    def test_joints_that_the_reference_does_not_know_do_not_count(self) -> None:
        truth = people_standing(2, 0.0)
        truth[1, 0, HAND] = np.nan
        truth[:, 0, 0] = np.nan
        present = np.ones((2, 1), bool)
        evaluation = evaluate_sequence(
            predicted_of(people_standing(2, 0.0)), reference_of(truth, present=present)
        )
        rows = benchmark(pool(evaluation))
        assert rows["left_hand"] == WithinLimit(1, *[1.0] * 4)
        assert rows["head"].count == 0
        assert rows["all"].count == 2 * J - 3
        assert rows["all"].ranked == pytest.approx(1.0)

    def test_without_orientations_there_is_no_offset(self) -> None:
        truth = people_standing(2, 0.0)
        predicted = predicted_of(truth, np.full((2, 1, B, 3, 3), np.nan))
        rows = benchmark(pool(evaluate_sequence(predicted, reference_of(truth))))
        assert rows["all"].raw == 1.0
        assert np.isnan(rows["all"].offset_out)

    def test_of_chosen_person_frames(self) -> None:
        truth = people_standing(4, 0.0)
        predicted = truth.copy()
        predicted[2:, 0, HAND, 1] += 0.3
        of = pool(evaluate_sequence(predicted_of(predicted), reference_of(truth)))
        assert benchmark(of, of.samples.frame < 2)["left_hand"].raw == 1.0
        assert benchmark(of, of.samples.frame >= 2)["left_hand"].raw == 0.0
