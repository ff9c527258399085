"""What was seen of a track, weighed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from msgspec.structs import replace

from topview.people.features import FEATURE_NAMES, MOST, SHAPE
from topview.people.likelihood import (
    LONG_S,
    MOST_LOG_ODDS,
    MOVES,
    RESTLESS_S,
    SEEMS_TO_MOVE,
    Evidence,
    probability,
    shipped_likelihood,
)

LIKELIHOOD = shipped_likelihood()
shapes = arrays(np.float64, len(SHAPE), elements=st.floats(0.0, MOST))


def watched(shape: np.ndarray, moved: float, seconds: float, fps: int = 10) -> Evidence:
    """The same shape for so long; a share of it moves at once."""
    evidence = Evidence.starting_with(shape, 0.0)
    for k in range(1, round(fps * seconds) + 1):
        evidence = evidence.with_shape(shape, moved, k / fps)
    return evidence


def test_the_shipped_file_weighs_all_features_and_no_others() -> None:
    assert tuple(LIKELIHOOD.weights) == FEATURE_NAMES
    assert len(FEATURE_NAMES) + 5 <= 30
    assert LIKELIHOOD.source


@given(st.floats(-100.0, 100.0), st.floats(-100.0, 100.0))
def test_a_probability_grows_with_the_log_odds(one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert 0.0 <= probability(low) <= probability(high) <= 1.0
    assert probability(low) + probability(-low) == pytest.approx(1.0)


@given(shape=shapes, index=st.integers(0, len(SHAPE) - 1), more=st.floats(0.0, MOST))
def test_a_worse_feature_never_raises_the_odds(shape: np.ndarray, index: int, more: float) -> None:
    worse = shape.copy()
    worse[index] += more
    odds, lower = (watched(each, 0.0, 0.2).log_odds(LIKELIHOOD) for each in (shape, worse))
    assert lower <= odds + 1e-9
    by_shape, by_worse = (LIKELIHOOD.log_odds_of_shape(each) for each in (shape, worse))
    assert by_worse <= by_shape + 1e-9


@given(shape=shapes, log_odds=st.floats(-10.0, 10.0), times=st.lists(st.floats(0.01, 2.0)))
def test_the_mean_of_what_stays_the_same_is_the_same(
    shape: np.ndarray, log_odds: float, times: list[float]
) -> None:
    evidence = Evidence.starting_with(shape, 0.0).with_network(log_odds, 0.0, 0.0)
    time_s = 0.0
    for elapsed_s in times:
        time_s += elapsed_s
        evidence = evidence.with_shape(shape, 0.0, time_s).with_network(log_odds, elapsed_s, time_s)
    np.testing.assert_allclose(evidence.features[: len(SHAPE)], shape)
    assert evidence.network == pytest.approx(np.clip(log_odds, -MOST_LOG_ODDS, MOST_LOG_ODDS))


def test_the_mean_forgets_and_does_not_depend_on_the_rate_of_frames() -> None:
    bad, good = np.full(len(SHAPE), 2.0), np.zeros(len(SHAPE))
    means = []
    for fps in (10, 60):
        evidence = watched(bad, 0.0, 2.0, fps)
        for k in range(1, 8 * fps + 1):
            evidence = evidence.with_shape(good, 0.0, 2.0 + k / fps)
        means.append(evidence.features[0])
    assert means[0] == pytest.approx(means[1], abs=0.1)
    assert max(means) < 0.2


@given(moved=st.floats(0.0, 1.0), seconds=st.floats(0.1, 20.0))
def test_what_has_not_moved_is_furniture_by_and_by(moved: float, seconds: float) -> None:
    evidence = watched(np.zeros(len(SHAPE)), moved, seconds, fps=2)
    longest = np.log1p(min(evidence.seen_s, LONG_S) / RESTLESS_S)
    if moved <= SEEMS_TO_MOVE:
        assert evidence.features[-1] == pytest.approx(longest)
    if moved >= SEEMS_TO_MOVE + MOVES:
        assert evidence.features[-1] == 0.0
    assert 0.0 <= evidence.features[-1] <= longest + 1e-9


def test_of_who_lies_stillness_tells_no_more_after_the_first_second() -> None:
    odds = []
    for seconds in (RESTLESS_S, 10.0 * RESTLESS_S):
        evidence = watched(np.zeros(len(SHAPE)), 0.0, seconds).with_network(
            MOST_LOG_ODDS, 1.0, seconds
        )
        lies = replace(evidence, by_body=True)
        odds.append([each.log_odds(LIKELIHOOD) for each in (evidence, lies)])
    (upright, lies), (longer, lies_longer) = odds
    assert longer < upright
    assert lies_longer == pytest.approx(lies)


def test_who_moves_is_likelier_a_person_than_who_has_just_come_or_who_stands() -> None:
    shape = np.zeros(len(SHAPE))
    moves, stands = (watched(shape, moved, 1.0) for moved in (1.0, 0.0))
    just_come = Evidence.starting_with(shape, 0.0)
    odds = [each.log_odds(LIKELIHOOD) for each in (moves, just_come, stands)]
    assert odds[0] > odds[1] > odds[2]
    assert LIKELIHOOD.log_odds_of_shape(shape) == odds[1]


def test_who_has_moved_once_may_stand_still() -> None:
    shape = np.zeros(len(SHAPE))
    there = watched(shape, 0.9, 1.0).with_shape(shape, 0.0, 1.1)
    assert there.still == 0.0


def test_the_network_is_believed_against_the_shape() -> None:
    """Of what looks like a person, and of what does not quite."""
    clear, doubtful = np.zeros(len(SHAPE)), np.full(len(SHAPE), 0.4)
    person = Evidence.starting_with(doubtful, 0.0).with_network(MOST_LOG_ODDS, 0.1, 0.1)
    nobody = Evidence.starting_with(clear, 0.0).with_network(-9.0, 0.1, 0.1)
    assert person.log_odds(LIKELIHOOD) > Evidence.starting_with(doubtful, 0.0).log_odds(LIKELIHOOD)
    assert nobody.log_odds(LIKELIHOOD) < Evidence.starting_with(clear, 0.0).log_odds(LIKELIHOOD)


def test_who_has_just_come_is_asked_about_in_each_frame_and_later_when_it_is_news() -> None:
    """What the network says of a frame is known with the next."""
    frame_s, asked = 1.0 / 30.0, []
    evidence = Evidence.starting_with(np.zeros(len(SHAPE)), 0.0)
    for frame in range(150):
        asked.append(evidence.is_to_be_asked(frame * frame_s))
        if asked[-1]:
            evidence = evidence.with_network(1.0, frame_s, frame * frame_s)
    assert all(asked[:4])
    assert 0.04 < np.mean(asked[-60:]) < 0.1


def test_the_worst_feature_is_the_one_that_weighs_most() -> None:
    for index, name in enumerate(SHAPE):
        if LIKELIHOOD.weights[name] > 0.0:
            assert LIKELIHOOD.worst_of(np.eye(len(FEATURE_NAMES))[index]) == name


def test_at_another_head_the_shape_is_looked_at_anew_and_the_time_without_moving_goes_on() -> None:
    bad, good = np.full(len(SHAPE), 1.0), np.zeros(len(SHAPE))
    before = watched(bad, 0.0, 2.0)
    after = before.of_another_head().with_shape(good, 0.0, 2.1)
    assert np.abs(after.shape).max() < 1e-9
    assert after.features[-1] >= before.features[-1]
    kept = before.with_shape(good, 0.0, 2.1)
    assert kept.shape.min() > 0.6
