from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skeleton_sequences import people_standing, predicted_of, reference_of
from topview_lab.metrics import (
    PERSON_GATE_M,
    PeopleCounts,
    evaluate_sequence,
    match_people,
    people_distances,
)


def counts(predicted: np.ndarray, reference: np.ndarray) -> PeopleCounts:
    (sequence,) = evaluate_sequence(predicted_of(predicted), reference_of(reference)).sequences
    return sequence.people


def exchanged(joints: np.ndarray, frames: slice) -> np.ndarray:
    """The first two predicted people exchange their ids in these frames."""
    swapped = joints.copy()
    swapped[frames, 0], swapped[frames, 1] = joints[frames, 1], joints[frames, 0]
    return swapped


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(0, 4))
def test_matches_are_one_to_one_and_within_the_gate(seed: int, R: int, P: int) -> None:
    rng = np.random.default_rng(seed)
    reference = rng.uniform(-0.6, 0.6, (5, R, 1, 3))
    predicted = rng.uniform(-0.6, 0.6, (5, P, 1, 3))
    distances_m = people_distances(reference, predicted)
    matches = match_people(distances_m)
    for f, distances in enumerate(distances_m):
        matched = matches[f][matches[f] >= 0]
        assert len(set(matched.tolist())) == len(matched)
        assert all(distances[r, p] <= PERSON_GATE_M for r, p in enumerate(matches[f]) if p >= 0)
        # Nobody is left over who could still be matched.
        left = distances[np.ix_(matches[f] < 0, np.setdiff1d(np.arange(P), matched))]
        assert (left > PERSON_GATE_M).all()


def test_mean_distance_leaves_out_joints_that_only_one_has() -> None:
    reference = np.array([[[[0.0, 0, 0], [1.0, 0, 0]]]])
    predicted = np.array([[[[0.3, 0, 0], [np.nan, 0, 0]], [[np.nan] * 3, [np.nan] * 3]]])
    assert people_distances(reference, predicted).tolist() == [[[pytest.approx(0.3), np.inf]]]


def test_two_who_exchange_ids_count_two_swaps() -> None:
    joints = people_standing(10, 0.0, 1.5)
    assert counts(joints, joints).id_swaps == 0
    assert counts(exchanged(joints, slice(5, None)), joints).id_swaps == 2
    assert counts(exchanged(joints, slice(5, 7)), joints).id_swaps == 4


def test_an_exchange_while_nobody_is_found_counts_too() -> None:
    joints = people_standing(10, 0.0, 1.5)
    predicted = exchanged(joints, slice(6, None))
    predicted[4:6] = np.nan
    result = counts(predicted, joints)
    assert (result.id_swaps, result.missed, result.frames_lost) == (2, 4, 2)


def test_a_new_id_after_a_loss_is_a_swap_and_no_false_person() -> None:
    truth = people_standing(6, 0.0)
    predicted = people_standing(6, 0.0, 0.0)
    predicted[3:, 0] = np.nan
    predicted[:3, 1] = np.nan
    result = counts(predicted, truth)
    assert (result.id_swaps, result.false_people, result.missed) == (1, 0, 0)


def test_an_id_handed_to_a_newcomer_is_a_swap() -> None:
    truth = people_standing(6, 0.0, 1.5)
    truth[3:, 0] = np.nan
    truth[:3, 1] = np.nan
    predicted = np.where(np.arange(6)[:, None, None, None] < 3, truth[:, :1], truth[:, 1:])
    assert counts(predicted, truth).id_swaps == 1


def test_a_match_is_kept_while_it_is_valid() -> None:
    truth = people_standing(3, 0.0)
    predicted = people_standing(3, 0.1, 3.0)
    predicted[1:, 0, :, 0] += 0.3  # 0.4 m off, still within the gate
    predicted[1:, 1, :, 0] -= 3.0  # right on the person
    result = counts(predicted, truth)
    assert result.id_swaps == 0
    assert result.false_person_frames == 3
    predicted[1:, 0, :, 0] += 0.3  # 0.7 m off
    assert counts(predicted, truth).id_swaps == 1


def test_beyond_the_gate_one_is_missed_and_one_is_false() -> None:
    result = counts(people_standing(4, 0.6), people_standing(4, 0.0))
    assert result == PeopleCounts(
        frames=4,
        person_frames=4,
        missed=4,
        false_person_frames=4,
        false_people=1,
        frames_lost=4,
    )
    assert (result.recall, result.precision) == (0.0, 0.0)


def test_one_of_two_is_missed() -> None:
    truth = people_standing(4, 0.0, 1.5)
    result = counts(truth[:, :1], truth)
    assert (result.missed, result.frames_lost, result.recall) == (4, 0, 0.5)


def test_a_person_out_of_view_is_not_missed() -> None:
    truth = people_standing(4, 0.0)
    truth[2:] = np.nan
    result = counts(truth, truth)
    assert (result.person_frames, result.missed, result.frames_lost) == (2, 0, 0)


def test_nobody_there_and_nobody_found() -> None:
    nobody = np.full((3, 1, 16, 3), np.nan)
    result = counts(nobody, nobody)
    assert result == PeopleCounts(frames=3)
    assert np.isnan([result.recall, result.precision]).all()


def test_as_many_as_possible_are_matched() -> None:
    """The nearest pair alone (0.05 m) would leave the other two (0.7 m) unmatched."""
    distances_m = people_distances(people_standing(1, 0.0, 0.25), people_standing(1, 0.3, 0.7))
    assert match_people(distances_m).tolist() == [[0, 1]]
