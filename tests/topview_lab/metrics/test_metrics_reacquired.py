"""Joints that come back into view from behind another person."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from skeleton_sequences import J, people_standing, predicted_of, reference_of
from topview.body import JOINT_NAMES
from topview_lab.metrics import (
    Evaluation,
    Held,
    comebacks,
    evaluate_sequence,
    pool,
    reacquired,
    summarise,
)

FRAMES = 90  # at 30 a second
HAND = JOINT_NAMES.index("left_hand")
HIDDEN = slice(10, 30)  # for 0.63 s
BACK, LOOKED_AT = 30, 33
CAUSES = ("occluded_by_person", "occluded_by_self", "occluded_by_object", "outside")


def shares_of(**hidden: float) -> dict[str, NDArray[np.float64]]:
    """The hand is hidden by these causes while `HIDDEN`, and nothing else ever is."""
    shares = {cause: np.zeros((FRAMES, 1, J)) for cause in CAUSES}
    for cause, share in hidden.items():
        shares[cause][HIDDEN, 0, HAND] = share
    return shares


def run(
    shares: dict[str, NDArray[np.float64]],
    wrong: Sequence[int] = (),
    lost: Sequence[int] = (),
) -> Evaluation:
    """The hand is 40 cm off in some frames, and nobody is found in others."""
    truth = people_standing(FRAMES, 0.0)
    found = truth.copy()
    found[list(wrong), 0, HAND, 0] += 0.4
    found[list(lost)] = np.nan
    copied = {name: share.copy() for name, share in shares.items()}
    return evaluate_sequence(predicted_of(found), reference_of(truth, **copied))


BY_PERSON = {"occluded_by_person": 0.8}


def test_it_is_looked_at_a_tenth_of_a_second_after_it_is_back() -> None:
    pooled = pool(run(shares_of(**BY_PERSON)))
    rows, joints = comebacks(pooled)
    assert (pooled.samples.frame[rows].tolist(), joints.tolist()) == ([LOOKED_AT], [HAND])
    for wrong, share in (([LOOKED_AT], 0.0), (range(BACK, LOOKED_AT), 1.0), (range(34, 40), 1.0)):
        assert reacquired(pool(run(shares_of(**BY_PERSON), wrong))) == Held(1, share)


def test_whoever_is_not_found_then_has_not_been_found_again() -> None:
    assert summarise(run(shares_of(**BY_PERSON), lost=[LOOKED_AT])).reacquired == Held(1, 0.0)


@pytest.mark.parametrize(
    ("hidden", "count"),
    [
        ({"occluded_by_person": 0.6}, 1),
        ({"occluded_by_person": 0.59}, 0),
        ({"occluded_by_self": 0.9}, 0),
        ({"occluded_by_object": 0.9}, 0),
        ({"outside": 0.9}, 0),
    ],
)
def test_only_another_person_counts(hidden: dict[str, float], count: int) -> None:
    assert reacquired(pool(run(shares_of(**hidden)))).count == count


@given(st.integers(1, 30))
def test_it_must_be_hidden_for_half_a_second(frames: int) -> None:
    shares = shares_of()
    shares["occluded_by_person"][10 : 10 + frames, 0, HAND] = 0.7
    assert reacquired(pool(run(shares))).count == (frames > 15)  # 16 frames last 15 steps


def test_two_short_times_are_no_long_one() -> None:
    shares = shares_of(**BY_PERSON)
    shares["occluded_by_person"][20, 0, HAND] = 0.5
    assert reacquired(pool(run(shares))).count == 0


@pytest.mark.parametrize("cause", CAUSES)
def test_it_is_back_once_nothing_hides_it(cause: str) -> None:
    shares = shares_of(**BY_PERSON)
    shares[cause][BACK : BACK + 10, 0, HAND] = 0.4
    pooled = pool(run(shares))
    assert pooled.samples.frame[comebacks(pooled)[0]].tolist() == [LOOKED_AT + 10]


@pytest.mark.parametrize("cause", CAUSES)
def test_it_must_stay_in_view_until_then(cause: str) -> None:
    shares = shares_of(**BY_PERSON)
    shares[cause][LOOKED_AT, 0, HAND] = 0.3
    assert reacquired(pool(run(shares))).count == 0
    shares[cause][LOOKED_AT, 0, HAND] = 0.29
    assert reacquired(pool(run(shares))).count == 1


def test_it_counts_each_time_and_in_each_recording() -> None:
    shares = shares_of(**BY_PERSON)
    shares["occluded_by_person"][50:70, 0, HAND] = 1.0
    once = run(shares, wrong=[73])
    assert reacquired(pool(once)) == Held(2, 0.5)
    assert reacquired(pool(Evaluation.pooled([once, once, run(shares)]))) == Held(6, 4 / 6)


def test_whoever_was_away_meanwhile_was_not_hidden() -> None:
    shares = shares_of(**BY_PERSON)
    shares["occluded_by_person"][10:80, 0, HAND] = 0.9
    evaluation = run(shares)
    assert reacquired(pool(evaluation)).count == 1
    truth = people_standing(FRAMES, 0.0)
    truth[22:78] = np.nan  # hidden for less than half a second on each side
    away = evaluate_sequence(predicted_of(truth), reference_of(truth, **shares))
    assert reacquired(pool(away)).count == 0


def test_what_hides_is_unknown_without_shares() -> None:
    truth = people_standing(FRAMES, 0.0)
    assert reacquired(pool(evaluate_sequence(predicted_of(truth), reference_of(truth)))).count == 0


def test_joints_that_are_never_told_do_not_count() -> None:
    truth = people_standing(FRAMES, 0.0)
    found = truth.copy()
    found[:, :, HAND] = np.nan
    reference = reference_of(truth, **shares_of(**BY_PERSON))
    assert reacquired(pool(evaluate_sequence(predicted_of(found), reference))).count == 0
