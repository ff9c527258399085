"""Whoever left and comes back is known again by clothes and stature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from msgspec.structs import replace

from dressed_scenes import BLUE, GROUND_Y, RED, Rgb, dressed, scene_of, track_at
from people_scenes import CAMERA, head_of, standing_person
from topview import TrackerSettings
from topview.camera.pyramid import Pyramid
from topview.people.appearance import with_appearance
from topview.people.finder import PeopleFinder
from topview.people.places import Places
from topview.people.returning import (
    CLEARLY_BACK,
    LEAST_BY_STATURE,
    ReturningPeople,
    by_stature,
    clear_ones,
)
from topview.people.settings import PeopleSettings
from topview.records import Frame

GREEN, GREY = (40, 160, 60), (120, 120, 120)
LEFT_X, RIGHT_X = -0.6, 0.6
TALL_M, SMALL_M = 1.82, 1.62
AGAIN = PeopleSettings(reidentify=True)


def told_ids(
    back: tuple[Rgb, Rgb], how: PeopleSettings, *, sees_color: bool = True
) -> list[dict[int, str]]:
    """Where each id is in each frame. A tall one in red stands left and a small one in blue right;
    both leave, and come back in the other order, at each other's places, in colours `back`."""
    finder, time_s = PeopleFinder(how), 0.0
    told: list[dict[int, str]] = []

    def show(frames: int, step_s: float, *who: tuple[float, float, Rgb]) -> None:
        nonlocal time_s
        people = [(standing_person(x, 2.6, GROUND_Y, height_m), rgb) for x, height_m, rgb in who]
        depth_m, color = dressed(people)
        for _ in range(frames):
            seen = color if sees_color else None
            users = finder.update(Pyramid(Frame(len(told), time_s, depth_m, CAMERA, seen)))
            told.append({u.id: "left" if u.head_camera[0] < 0.0 else "right" for u in users})
            time_s += step_s

    small, tall = (LEFT_X, SMALL_M, back[1]), (RIGHT_X, TALL_M, back[0])
    show(4, 0.15, (LEFT_X, TALL_M, RED), (RIGHT_X, SMALL_M, BLUE))
    show(5, 0.4)
    show(4, 0.15, small)
    show(4, 0.15, small, tall)
    return told


def test_two_who_return_in_the_other_order_get_their_numbers_back() -> None:
    told = told_ids((RED, BLUE), AGAIN)
    assert told[3] == {1: "left", 2: "right"}
    assert told[-1] == {1: "right", 2: "left"}
    numbers = {number for numbers in told for number in numbers}
    assert numbers == {1, 2}  # nobody is told before being known again


@pytest.mark.parametrize(
    ("back", "how", "sees_color"),
    [
        ((RED, BLUE), PeopleSettings(), True),
        ((RED, BLUE), AGAIN, False),
        ((GREY, GREEN), AGAIN, True),
    ],
)
def test_a_stranger_and_whoever_cannot_or_need_not_be_known_are_new(back, how, sees_color) -> None:
    assert told_ids(back, how, sees_color=sees_color)[-1] == {3: "left", 4: "right"}


def test_whoever_is_long_out_of_the_picture_is_no_track_that_a_newcomer_takes() -> None:
    people = [(standing_person(0.0, 2.6, GROUND_Y), RED)]
    before, scene = scene_of(*dressed(people), 0), scene_of(*dressed([]), 45)
    (track,) = with_appearance([track_at(before, head_of(0.0, 2.6, GROUND_Y))], before, True)
    places = replace(Places.around(scene, track.motion, 1), outside=0.95)
    gone = replace(track, places=places, body_m2=0.0, time_s=scene.time_s)
    existence = ReturningPeople()
    assert existence.has_ended(gone, scene)
    assert not existence.has_ended(replace(gone, seen_s=scene.time_s - 0.5), scene)
    assert not existence.has_ended(replace(gone, clothes=None), scene)  # could not be known again
    assert not ReturningPeople(from_outside=False).has_ended(gone, scene)  # need not be


@pytest.mark.parametrize(("outside", "is_known_again"), [(0.0, True), (0.95, False)])
def test_whoever_was_hidden_in_the_picture_is_always_known_again(outside, is_known_again) -> None:
    """Whoever left it only where that is asked for."""
    x, z, seconds = 0.0, 2.6, 2
    people = [(standing_person(x, z, GROUND_Y), RED)]
    existence = ReturningPeople(from_outside=False)
    before = scene_of(*dressed(people), 0)
    (track,) = with_appearance([track_at(before, head_of(x, z, GROUND_Y))], before, True)
    hidden = scene_of(*dressed([]), 30 * seconds)
    places = replace(Places.around(hidden, track.motion, 1), outside=outside)
    gone = replace(track, places=places, certainty=0.5, body_m2=0.0, time_s=hidden.time_s)
    after = existence.confirmed([gone], hidden, set(), False)
    for frame in range(15):
        scene = scene_of(*dressed(people), 30 * seconds + frame + 1)
        new = replace(track_at(scene, head_of(x, z, GROUND_Y)), key=2, id=0)
        new = replace(new, body_m=track.body_m, born_s=hidden.time_s)
        after = existence.confirmed([gone, new], scene, {2}, False)
        if any(track.key == 2 and track.id for track in after):
            break
    assert [track.id for track in after if track.key == 2] == [gone.id if is_known_again else 1]


def test_a_stature_tells_a_little_and_never_much_against_somebody() -> None:
    ratios = [by_stature(off_m) for off_m in (0.0, 0.03, 0.1, 0.5)]
    assert ratios == sorted(ratios, reverse=True)
    assert 0.0 < ratios[0] < CLEARLY_BACK  # never enough alone
    assert ratios[2] < 0.0
    assert ratios[3] == by_stature(-0.9) == LEAST_BY_STATURE


@settings(max_examples=50)
@given(arrays(np.float64, (2, 3), elements=st.floats(-20, 20)))
def test_whoever_is_known_again_is_likelier_than_all_others_together(ratios) -> None:
    clear = clear_ones(ratios)
    for row, column in np.argwhere(np.isfinite(clear)):
        others = [0.0, *np.delete(ratios[row], column)]
        assert np.exp(clear[row, column]) > np.exp(CLEARLY_BACK) * np.exp(others).sum()
    assert (np.isfinite(clear).sum(1) <= 1).all()


def test_settings_say_that_people_were_known_again() -> None:
    assert "reidentify" not in TrackerSettings().as_json()
    how = TrackerSettings(reidentify=True)
    assert how.as_json()["reidentify"] is True
    assert how.finding_with(proposes=True).reidentify
