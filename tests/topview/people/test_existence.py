"""Who is confirmed, who ends, and who is told of."""

from __future__ import annotations

from math import log
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.people.bodies import SHOWN_M2
from topview.people.existence import (
    CONFIRMED,
    ENDED,
    NEW_TRACK_S,
    REFUSED,
    ROOM_S,
    TOLD,
    UNSEEN_S,
    Existence,
    is_too_near,
)
from topview.people.features import FEATURE_NAMES, SHAPE
from topview.people.likelihood import Evidence, Likelihood, probability
from topview.people.places import Places
from topview.people.settings import PeopleSettings
from topview.people.step import ShapeOdds, Step
from topview.people.told import NOTHING_TOLD
from topview.people.track import Track
from topview.room.background import Background

FRAME_S = 1 / 30
HEAD = head_of(0.0, 2.6, GROUND_Y)
SCENES = [
    scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, index) for index in (0, 1, 30)
]
FIRST, SOON, LATER = SCENES
IS_UNDER_HEAD = np.hypot(*(LATER.overview_m - LATER.overview_of(HEAD)).transpose(2, 0, 1)) < 0.3
BODY_M = np.where(IS_UNDER_HEAD, np.float32(0.0), np.float32(np.inf))
LIKE_A_PERSON = Likelihood("made up", 0.0, dict.fromkeys(FEATURE_NAMES, 0.0), 0.0, 0.0, 1.0, 0.0)
"""Whose log-odds are those of the network."""
log_odds = st.floats(-4.9, 4.9)


def track_with(odds: float, key: int = 1, asked_s: float = 1e-9, **changes: Any) -> Track:
    """Of nobody yet, born in the first scene; the network has looked for a moment."""
    evidence = replace(BORN.evidence, network=odds, asked_s=asked_s)
    return replace(BORN, **{"key": key, "evidence": evidence, **changes})


BORN = replace(track_at(FIRST, HEAD), id=0)


def side_by_side(*tracks: Track) -> list[Track]:
    """The same, each in a place of its own by its key."""
    return [
        replace(track, place_camera=HEAD + np.array([float(track.key), 0.0, 0.0]))
        for track in tracks
    ]


def steady_for(seconds: float) -> Background:
    """What has seen the later scene for so long."""
    steady = Background(np.inf)
    for time_s in (0.0, seconds):
        steady.update(LATER.cloud.depth_m, np.zeros(LATER.heights_m.shape, np.bool_), time_s)
    return steady


def log_odds_of(share: float) -> float:
    return log(share / (1.0 - share))


def confirmed(existence: Existence, *tracks: Track, has_network: bool = False) -> list[int]:
    """The ids that they get in the later scene, where all may be somebody."""
    free = {track.key for track in tracks if not track.id}
    return [track.id for track in existence.confirmed(tracks, LATER, free, has_network)]


@given(log_odds, st.floats(1e-9, 10.0))
def test_who_is_probably_a_person_is_confirmed_however_long_that_took(
    odds: float, asked_s: float
) -> None:
    is_person = probability(odds) > CONFIRMED
    track = track_with(odds, asked_s=asked_s)
    assert confirmed(Existence(None, LIKE_A_PERSON), track) == [int(is_person)]


@given(odds=log_odds, is_confirmed=st.booleans())
def test_who_is_hardly_a_person_ends(odds: float, is_confirmed: bool) -> None:
    track = track_with(odds, id=int(is_confirmed), seen_s=LATER.time_s)
    track = replace(track, evidence=replace(track.evidence, still=0.5 * (not is_confirmed)))
    least = ENDED if is_confirmed else REFUSED
    assert Existence(None, LIKE_A_PERSON).has_ended(track, LATER) == (probability(odds) < least)


def test_what_the_network_has_refused_is_kept_while_it_stands_still() -> None:
    existence, refused = Existence(None, LIKE_A_PERSON), track_with(-4.0, seen_s=LATER.time_s)
    assert not existence.has_ended(refused, LATER)
    unasked = replace(BORN, seen_s=LATER.time_s)
    assert Existence(None, replace_bias(-4.0)).has_ended(unasked, LATER)


@given(st.lists(log_odds, min_size=1, max_size=6), st.integers(1, 4), st.integers(0, 3))
def test_there_are_no_more_people_than_the_user_says_and_the_likeliest(
    odds: list[float], most: int, known: int
) -> None:
    people = [track_with(4.0, key=100 + k, id=10 + k) for k in range(min(known, most))]
    tracks = [track_with(each, key) for key, each in enumerate(odds, 1)]
    ids = confirmed(Existence(most, LIKE_A_PERSON), *side_by_side(*people, *tracks))
    likely = sorted((each for each in odds if probability(each) > CONFIRMED), reverse=True)
    told = [each for each, own in zip(odds, ids[len(people) :], strict=True) if own]
    assert sorted(told, reverse=True) == likely[: most - len(people)]
    assert ids[: len(people)] == [track.id for track in people]
    assert len(set(filter(None, ids))) == len(people) + len(told)


def test_an_id_is_given_once_and_kept() -> None:
    existence = Existence(None, LIKE_A_PERSON)
    first = side_by_side(track_with(4.0, 1), track_with(4.5, 2))
    assert confirmed(existence, *first) == [2, 1]
    then = side_by_side(track_with(4.0, 1, id=2), track_with(4.0, 3))
    assert confirmed(existence, *then) == [2, 3]


def test_of_two_at_one_head_only_the_likelier_is_a_person() -> None:
    existence = Existence(None, LIKE_A_PERSON)
    assert confirmed(existence, track_with(4.0, 1), track_with(4.5, 2)) == [0, 1]


def test_after_the_first_frame_a_head_is_seen_twice_and_by_the_network_if_there_is_one() -> None:
    existence = Existence(None, LIKE_A_PERSON)
    sure, born_s = log_odds_of(0.99), LATER.time_s - 0.5 * NEW_TRACK_S
    unasked = Evidence.starting_with(np.zeros(len(SHAPE)), 0.0)
    shape = Existence(None, replace_bias(sure))
    for each in (existence, shape):
        each.confirmed([], FIRST, set(), False)
    assert confirmed(existence, track_with(sure, born_s=born_s)) == [0]
    assert confirmed(existence, track_with(sure)) == [1]
    assert confirmed(shape, track_with(0.0, evidence=unasked), has_network=True) == [0]
    assert confirmed(shape, track_with(0.0, evidence=unasked)) == [1]


@pytest.mark.parametrize("is_first", [True, False])
def test_who_is_confirmed_before_the_network_is_asked_has_to_be_confirmed_by_it(
    is_first: bool,
) -> None:
    existence = Existence(None, replace_bias(4.0))
    if not is_first:
        existence.confirmed([], FIRST, set(), True)
    unasked = track_with(0.0, evidence=Evidence.starting_with(np.zeros(len(SHAPE)), 0.0))
    existence.confirmed([unasked], FIRST, {unasked.key}, True)
    sure, unsure = (
        track_with(log_odds_of(share) - 4.0, id=1, seen_s=SOON.time_s) for share in (0.95, 0.8)
    )
    assert not existence.has_ended(sure, SOON)
    assert existence.has_ended(unsure, SOON) == is_first


def replace_bias(bias: float) -> Likelihood:
    return Likelihood("made up", bias, LIKE_A_PERSON.weights, 0.0, 1.0, 1.0, 0.0)


def test_what_may_be_a_part_of_somebody_is_not_confirmed() -> None:
    (track,) = Existence(None, LIKE_A_PERSON).confirmed([track_with(4.0)], LATER, set(), False)
    assert track.id == 0


@pytest.mark.parametrize(
    ("changes", "ends"),
    [
        ({"id": 1}, False),
        ({}, False),
        ({"seen_s": LATER.time_s - 2.0 * UNSEEN_S}, True),
        ({"id": 1, "seen_s": LATER.time_s - 2.0 * UNSEEN_S}, False),
    ],
)
def test_what_is_lost_before_it_was_somebody_ends(changes: dict[str, Any], ends: bool) -> None:
    track = track_with(4.0, **{"seen_s": LATER.time_s, **changes})
    assert Existence(None, LIKE_A_PERSON).has_ended(track, LATER) == ends


def test_who_has_gone_ends() -> None:
    places = Places.around(LATER, BORN.motion, 1)
    for presence, ends in ((1.0, False), (0.01, True)):
        track = track_with(4.0, id=1, places=replace(places, presence=presence))
        assert Existence(None, LIKE_A_PERSON).has_ended(track, LATER) == ends


@given(log_odds, st.floats(0.0, 1.0), st.floats(0.0, 0.2), st.floats(0.0, 1.0), st.booleans())
@example(odds=6.0, certainty=1.0, body_m2=0.0, outside=0.3, is_above=False)  # has left by the side
@example(odds=6.0, certainty=1.0, body_m2=0.0, outside=0.3, is_above=True)
def test_who_is_not_seen_is_put_out_while_likelier_there_than_not(
    odds: float, certainty: float, body_m2: float, outside: float, is_above: bool
) -> None:
    """While enough of the body is seen and it is not surely outside of the picture, or while the
    place is known to be there; who reaches out of it above is not outside."""
    places = replace(Places.around(LATER, BORN.motion, 1), outside=outside)
    place_camera = np.array([0.0, -LATER.cloud.camera.height, 2.0]) if is_above else HEAD
    hidden = track_with(
        odds,
        id=1,
        places=places,
        certainty=certainty,
        body_m2=body_m2,
        place_camera=place_camera,
    )
    existence, there = Existence(None, LIKE_A_PERSON), hidden.existence(LIKE_A_PERSON)
    outside = 0.0 if is_above else outside
    is_known = there * certainty * (1.0 - outside) > TOLD
    is_shown = there > 0.5 and body_m2 > SHOWN_M2
    is_told = outside <= TOLD if is_shown else is_known
    assert existence.is_put_out(hidden, LATER) == is_told
    assert existence.is_put_out(replace(hidden, places=None), LATER)
    assert not existence.is_put_out(replace(hidden, id=0, places=None), LATER)


def test_what_is_long_no_person_is_the_rooms() -> None:
    existence = Existence(None, LIKE_A_PERSON)
    old_s = LATER.time_s - ROOM_S - FRAME_S
    assert existence.is_room(track_with(-1.0, born_s=old_s), LATER)
    assert not existence.is_room(track_with(1.0, born_s=old_s), LATER)
    assert not existence.is_room(track_with(-1.0), LATER)


@pytest.mark.parametrize(("still", "ends"), [(0.5, True), (0.0, False)])
def test_who_has_not_moved_is_believed_no_longer_than_likely(still: float, ends: bool) -> None:
    """The network has looked, and finds it less likely than not."""
    track = track_with(-0.5, id=1, seen_s=LATER.time_s)
    track = replace(track, evidence=replace(track.evidence, still=still))
    assert Existence(None, LIKE_A_PERSON).has_ended(track, LATER) == ends


def test_what_was_refused_is_taken_up_and_is_nobody_hidden_where_nothing_has_changed() -> None:
    since_s = FIRST.time_s + 10 * FRAME_S
    refused = track_with(-4.0, key=7, seen_s=since_s, time_s=since_s, body_m=BODY_M)
    refused = replace(refused, evidence=replace(refused.evidence, still=0.5))
    born = replace(track_at(LATER, HEAD), key=9, id=0, body_m=BODY_M)
    for steady_s, key in ((2.0, 7), (0.1, 9)):
        existence = Existence(None, LIKE_A_PERSON)
        assert existence.going_on([refused], LATER) == []
        scene = replace(LATER, steady=steady_for(steady_s))
        assert existence.taken_up(born, scene).key == key
        odds = ShapeOdds(Step(scene, FIRST, NOTHING_TOLD, PeopleSettings()), existence)
        assert (odds(born.head) == -4.0) == (key == 7)
    assert existence.taken_up(born, LATER).key == 9  # it is not known what has changed
    elsewhere = replace(born, place_camera=HEAD + np.array([1.0, 0.0, 0.0]))
    assert existence.taken_up(elsewhere, replace(LATER, steady=steady_for(2.0))).key == 9


@pytest.mark.parametrize(("still", "key"), [(1.0, 7), (0.9, 9)])
def test_a_thing_is_known_again_by_a_head_that_is_told_lower(still: float, key: int) -> None:
    """As a lamp is; who has moved at all may have bent down."""
    since_s = FIRST.time_s + 10 * FRAME_S
    doubted = track_with(-4.0, key=7, id=1, seen_s=since_s, time_s=since_s, body_m=BODY_M)
    doubted = replace(doubted, evidence=replace(doubted.evidence, still=still))
    existence = Existence(None, LIKE_A_PERSON)
    assert existence.going_on([doubted], LATER) == []
    lower = replace(track_at(LATER, HEAD + np.array([0.0, 0.5, 0.0])), key=9, id=0, body_m=BODY_M)
    assert existence.taken_up(lower, replace(LATER, steady=steady_for(2.0))).key == key


@pytest.mark.parametrize("is_elsewhere", [False, True])
def test_who_was_put_out_for_a_while_has_the_same_identity(is_elsewhere: bool) -> None:
    """At the same place, unless that person is seen elsewhere by now; somebody new besides has the
    next one."""
    existence = Existence(None, LIKE_A_PERSON)
    (person,) = existence.confirmed([track_with(4.0, key=7)], FIRST, {7}, True)
    evidence = replace(person.evidence, network=-4.0, still=0.5)
    since_s = FIRST.time_s + 10 * FRAME_S
    doubted = replace(person, seen_s=since_s, time_s=since_s, body_m=BODY_M, evidence=evidence)
    assert existence.going_on([doubted], LATER) == []
    born = replace(track_at(LATER, HEAD), key=9, id=0, body_m=BODY_M)
    again = existence.taken_up(born, replace(LATER, steady=steady_for(2.0)))
    assert (again.key, again.id) == (7, 0)
    again = replace(again, evidence=replace(again.evidence, network=4.0))
    other = replace(person if is_elsewhere else again, key=11)
    after = existence.confirmed(side_by_side(other, again), LATER, {7, 11}, True)
    ids = {track.key: track.id for track in after}
    first, second = (11, 7) if is_elsewhere else (7, 11)
    assert ids == {first: person.id, second: person.id + 1}


@pytest.mark.parametrize(
    ("away_m", "gone_s", "is_there", "is_same"),
    [
        (0.8, 0.5, False, True),
        (2.0, 0.5, False, False),  # too far
        (0.8, 1.2, False, False),  # too long ago
        (0.8, 0.5, True, False),  # and is known to be elsewhere
    ],
)
def test_who_falls_is_the_same_though_put_out_for_a_moment(
    away_m: float, gone_s: float, is_there: bool, is_same: bool
) -> None:
    """Another track begins where nothing is as it was."""
    existence = Existence(None, LIKE_A_PERSON)
    (person,) = existence.confirmed([track_with(4.0, key=7)], FIRST, {7}, True)
    evidence = replace(person.evidence, network=-9.0, still=0.0)
    since_s = LATER.time_s - gone_s
    doubted = replace(person, seen_s=since_s, time_s=since_s, body_m=BODY_M, evidence=evidence)
    assert existence.going_on([doubted], LATER) == []
    place_camera = HEAD + np.array([away_m, 0.0, 0.0])
    seen = replace(BORN.evidence, network=4.0, asked_s=0.1)
    fallen = replace(track_at(LATER, place_camera), key=9, id=0, evidence=seen, born_s=since_s)
    tracks = [fallen, replace(person, key=8)] if is_there else [fallen]
    after = {t.key: t.id for t in existence.confirmed(tracks, LATER, {9}, True)}
    assert after[9] == (person.id if is_same else person.id + 1)


def test_a_refusal_names_what_speaks_most_against_a_person() -> None:
    worst = "too low"
    likelihood = Likelihood(
        "made up", 0.0, {n: float(n == worst) for n in FEATURE_NAMES}, 0.0, 1.0, 1.0, 0.0
    )
    shape = np.ones(len(SHAPE))
    track = replace(BORN, evidence=Evidence.starting_with(shape, 0.0))
    assert Existence(None, likelihood).refusal_of(track).reason == worst


def test_a_shoulder_is_too_near_to_its_head_to_be_another() -> None:
    aside, below = np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.6, 0.0])
    assert is_too_near(HEAD + aside + below, [BORN], LATER)
    assert not is_too_near(HEAD + 3.0 * aside, [BORN], LATER)
    assert not is_too_near(HEAD, [], LATER)
