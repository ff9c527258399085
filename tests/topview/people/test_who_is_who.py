"""Clothes tell who is who after two people met."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import BLUE, GROUND_Y, RED, ROOM, Rgb, dressed, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.people.appearance import CLEARLY, clothes_under, unlikeness, with_appearance
from topview.people.track import Track
from topview.room.scene import Scene


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
    reds, blues = clothes_under(scene, left, [right]), clothes_under(scene, right, [left])
    assert reds is not None
    assert blues is not None
    for histogram in (reds, blues):
        assert histogram.sum() == pytest.approx(1.0)
        assert histogram.min() >= 0.0
    assert unlikeness(reds, blues) > 0.95
    again = clothes_under(two_beside(RED, RED, 0.5), right, [left])
    assert again is not None
    assert unlikeness(reds, again) < 0.1
    assert clothes_under(scene, np.array([0.0, -3.0, 2.6]), []) is None
    assert clothes_under(scene_of(render([], ROOM), None, 0), left, []) is None


def dressed_tracks(left: Rgb, right: Rgb) -> list[Track]:
    """Of two who are apart, whose clothes are known."""
    scene = two_beside(left, right, 1.6)
    heads = enumerate(heads_beside(1.6), 1)
    return with_appearance([track_at(scene, place, key) for key, place in heads], scene, True)


def together(tracks: Sequence[Track], hidden_key: int | None = None) -> list[Track]:
    """The same, near each other; of one the head may be hidden."""
    there = [
        replace(track, place_camera=place)
        for track, place in zip(tracks, heads_beside(0.4), strict=True)
    ]
    return [
        replace(track, seen_s=track.time_s - 0.1) if track.key == hidden_key else track
        for track in there
    ]


def seen_again(tracks: Sequence[Track]) -> list[Track]:
    return [replace(track, places=None, seen_s=track.time_s) for track in tracks]


@pytest.mark.parametrize("are_exchanged", [False, True])
@pytest.mark.parametrize("sees_color", [False, True])
def test_two_who_met_are_who_wears_their_clothes(are_exchanged: bool, sees_color: bool) -> None:
    tracks = dressed_tracks(RED, BLUE)
    assert all(track.clothes is not None for track in tracks)
    # They meet, one is hidden for a while, and both are seen again.
    tracks = with_appearance(together(tracks, hidden_key=2), two_beside(RED, BLUE, 0.4, 1), True)
    assert all(track.company for track in tracks)
    colors = (BLUE, RED) if are_exchanged else (RED, BLUE)
    scene = two_beside(*colors, 0.4, 2)
    if not sees_color:
        scene = scene_of(scene.cloud.frame.depth_m, None, 2)
    one, other = with_appearance(seen_again(tracks), scene, True)
    is_told = are_exchanged and sees_color
    assert (one.id, other.id) == ((2, 1) if is_told else (1, 2))
    assert (one.key, other.key) == (1, 2)  # the place and the motion are not exchanged
    assert bool(one.company) != sees_color  # settled, or not to be told
    for track, rgb in zip((one, other), colors, strict=True):
        known = {1: RED, 2: BLUE}[track.id]
        assert (known == rgb) or not sees_color


def test_two_who_wear_the_same_or_have_not_met_keep_their_identities() -> None:
    same = dressed_tracks(RED, RED)
    assert same[0].clothes is not None
    assert same[1].clothes is not None
    assert unlikeness(same[0].clothes, same[1].clothes) < CLEARLY / 2
    met = with_appearance(together(same, hidden_key=1), two_beside(RED, RED, 0.4, 1), True)
    again = with_appearance(seen_again(met), two_beside(RED, RED, 0.4, 2), True)
    assert [track.id for track in again] == [1, 2]
    strangers = together(dressed_tracks(RED, BLUE))
    after = with_appearance(strangers, two_beside(BLUE, RED, 0.4, 1), True)
    assert [track.id for track in after] == [1, 2]


def test_the_clothes_are_not_learnt_of_those_who_may_be_exchanged() -> None:
    tracks = dressed_tracks(RED, BLUE)
    near = with_appearance(together(tracks, hidden_key=2), two_beside(BLUE, RED, 0.4, 1), True)
    for before, after in zip(tracks, near, strict=True):
        np.testing.assert_array_equal(before.clothes, after.clothes)
