"""Whoever is hidden takes nobody's head; clothes tell who is who after two people met."""

from __future__ import annotations

import numpy as np
import pytest
from dressed_scenes import BLUE, GROUND_Y, RED, ROOM, Rgb, dressed, scene_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from people_scenes import box, head_of, render, standing_person

from topview.detect.head_template import HeadTemplate
from topview.detect.heads import HeadCandidate
from topview.people.association import find_again
from topview.people.identity import KnownUser
from topview.people.looks import CLEARLY, colors_under, tell_apart, unlikeness
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.settings import PeopleSettings


def known(number: int, scene: Scene, place: NDArray[np.float64]) -> KnownUser:
    view = HeadTemplate.of(scene.cloud, place)
    return KnownUser(number, HeadCandidate(place, 0.9), view, scene.time_s)


def two_beside(left: Rgb, right: Rgb, gap_m: float, index: int = 0) -> Scene:
    people = [(standing_person(side * gap_m / 2, 2.6, GROUND_Y), rgb)
              for side, rgb in ((-1, left), (1, right))]  # fmt: skip
    return scene_of(*dressed(people), index)


def heads_beside(gap_m: float) -> list[NDArray[np.float64]]:
    return [head_of(side * gap_m / 2, 2.6, GROUND_Y) for side in (-1, 1)]


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_unlikeness_is_that_of_a_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = (rng.dirichlet(np.ones(12)).astype(np.float32) for _ in range(2))
    assert unlikeness(one, one) == pytest.approx(0.0, abs=1e-5)
    assert unlikeness(one, other) == pytest.approx(unlikeness(other, one), abs=1e-6)
    assert -1e-5 <= unlikeness(one, other) <= 1.0
    apart = np.roll(np.eye(12, dtype=np.float32)[0], 3)
    assert unlikeness(np.eye(12, dtype=np.float32)[0], apart) == 1.0


def test_the_colours_under_a_head_are_its_own() -> None:
    scene = two_beside(RED, BLUE, 0.5)
    left, right = heads_beside(0.5)
    reds, blues = colors_under(scene, left, [right]), colors_under(scene, right, [left])
    assert reds is not None
    assert blues is not None
    assert unlikeness(reds, blues) > 0.95
    again = colors_under(two_beside(RED, RED, 0.5), right, [left])
    assert again is not None
    assert unlikeness(reds, again) < 0.1
    assert colors_under(scene, np.array([0.0, -3.0, 2.6]), []) is None
    assert colors_under(scene_of(render([], ROOM), None, 0), left, []) is None


@pytest.mark.parametrize("are_exchanged", [False, True])
@pytest.mark.parametrize("sees_color", [False, True])
def test_two_who_met_are_who_wears_their_clothes(are_exchanged: bool, sees_color: bool) -> None:
    apart, near = 1.6, 0.4
    scene = two_beside(RED, BLUE, apart)
    one, other = (known(k + 1, scene, place) for k, place in enumerate(heads_beside(apart)))
    tell_apart(scene, [one, other], sees_color)
    assert (one.colors is not None) == sees_color
    # They meet, one is hidden for a while, and both are seen again.
    for user, place in zip((one, other), heads_beside(near), strict=True):
        user.head_camera = place
    other.confidence_now = 0.0
    tell_apart(two_beside(RED, BLUE, near, 1), [one, other], sees_color)
    scene = two_beside(*((BLUE, RED) if are_exchanged else (RED, BLUE)), near, 2)
    for user, place in zip((one, other), heads_beside(near), strict=True):
        user.see(HeadCandidate(place, 0.9), user.view, scene.time_s)
    tell_apart(scene, [one, other], sees_color)
    expected = (2, 1) if are_exchanged and sees_color else (1, 2)
    assert (one.id, other.id) == expected
    assert bool(one.company) != sees_color  # settled, or not to be told


def test_who_wears_the_same_is_left_as_he_is() -> None:
    scene = two_beside(RED, RED, 1.6)
    one, other = (known(k + 1, scene, place) for k, place in enumerate(heads_beside(1.6)))
    tell_apart(scene, [one, other], True)
    assert one.colors is not None
    assert other.colors is not None
    assert unlikeness(one.colors, other.colors) < CLEARLY / 2
    one.company, other.company = {other}, {one}
    tell_apart(scene, [one, other], True)
    assert (one.id, other.id) == (1, 2)


def test_who_is_hidden_takes_nobodys_head() -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 1)
    seen = known(1, scene, place + np.array([0.08, 0.0, 0.0]))
    hidden = known(2, scene, place.copy())  # nearer to where the head is now
    hidden.confidence_now = 0.0
    for user in (seen, hidden):
        user.time_s = user.seen_s = scene.time_s - 1 / 30
    roll = Roll(PeopleSettings(), [hidden, seen], [])
    assert find_again(roll, scene, [HeadCandidate(place, 0.95)]) == []
    assert seen.seen_s == scene.time_s
    assert np.linalg.norm(seen.head_camera - place) < 0.03
    assert hidden.seen_s < scene.time_s
    assert len(roll.bodies) == 2


def test_who_was_hidden_for_long_takes_nobodys_head_who_was_seen_a_moment_ago() -> None:
    """Of one whose shoulder was followed the head comes into view, and nobody else's."""
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 200)
    here = known(1, scene, place + np.array([-0.1, 0.2, 0.05]))
    here.view = HeadTemplate.of(scene.cloud, np.array([1.5, 0.0, 5.4]))  # looks like nothing near
    away = known(2, scene, place + np.array([-0.8, 0.0, 0.0]))
    for user, unseen_s in ((here, 0.1), (away, 4.0)):
        user.confidence_now = 0.0
        user.seen_s = scene.time_s - unseen_s
        user.time_s = scene.time_s - 1 / 30
    head = HeadCandidate(place, 0.95)
    bodies = [np.full_like(scene.cloud.depth_m, np.inf)] * 2
    assert find_again(Roll(PeopleSettings(), [away, here], bodies), scene, [head]) == [head]
    here.seen_s = scene.time_s - 2.0
    assert find_again(Roll(PeopleSettings(), [away, here], bodies), scene, [head]) == []
    assert away.seen_s == scene.time_s


def test_of_whom_nothing_is_seen_stands_behind_what_hides_him() -> None:
    pillar = box((-0.35, GROUND_Y - 2.0, 1.8), (0.35, GROUND_Y, 2.0))
    scene = scene_of(render([], [*ROOM, pillar]), None, 0)
    half = head_of(0.55, 3.2, GROUND_Y)  # half of the body would be seen beside it
    way = scene.way_to_cover(half)
    assert way[0] < -0.1
    assert abs((half + way)[0]) < 0.45
    middle = head_of(0.0, 3.2, GROUND_Y)
    assert np.linalg.norm(scene.way_to_cover(middle)) == 0.0


def test_who_walks_goes_on_behind_what_is_before_him() -> None:
    pillar = box((-0.25, GROUND_Y - 2.0, 1.8), (0.25, GROUND_Y, 2.0))
    scene = scene_of(render([], [*ROOM, pillar]), None, 0)
    beside = head_of(0.6, 3.2, GROUND_Y)
    way = scene.way_to_hidden(beside, np.array([-1.0, 0.0, 0.0]))
    assert way is not None
    assert scene.is_hidden_at(beside + way)
    assert scene.way_to_hidden(beside, np.array([1.0, 0.0, 0.0])) is None
    assert scene.way_to_hidden(beside, np.array([-0.1, 0.0, 0.0])) is None
