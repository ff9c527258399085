"""What of a new track's body is held for the room, until it moves."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.detect.heads import HeadCandidate
from topview.people.spawning import SPREAD_FEATURES, room_left_of
from topview.people.track import Track
from topview.room.scene import Scene

HEAD = head_of(0.0, 2.2, GROUND_Y)
SHOULDER = HEAD + np.array([0.2, 0.25, 0.0])


def of_shoulder() -> tuple[Scene, Track, NDArray[np.float32]]:
    """Somebody, whose shoulder is followed as a head that has too much above it."""
    scene = scene_of(render(standing_person(0.0, 2.2, GROUND_Y), ROOM), None, 0)
    track = replace(track_at(scene, SHOULDER, 1), id=0)
    features = track.evidence.features.copy()
    features[SPREAD_FEATURES[0]] = 0.5
    body = track_at(scene, HEAD, 2).body_m
    assert body is not None
    return scene, replace(track, evidence=replace(track.evidence, features=features)), body


def test_what_is_not_under_a_head_is_the_rooms():
    scene, track, body = of_shoulder()
    is_left = room_left_of(scene, track, body, [], [HeadCandidate(SHOULDER, 0.9)])
    assert is_left.any()
    assert not (is_left & scene.is_under(SHOULDER, 0.2)).any()


def test_the_trunk_under_a_higher_head_is_not():
    scene, track, body = of_shoulder()
    heads = [HeadCandidate(SHOULDER, 0.9), HeadCandidate(HEAD, 0.6)]
    without = room_left_of(scene, track, body, [], heads[:1])
    with_head = room_left_of(scene, track, body, [], heads)
    assert not (with_head & scene.is_under(HEAD, 0.2)).any()
    assert with_head.sum() < 0.5 * without.sum()


def test_a_lower_head_keeps_nothing():
    scene, track, body = of_shoulder()
    lower = HeadCandidate(HEAD + np.array([0.0, 0.6, 0.0]), 0.9)
    without = room_left_of(scene, track, body, [], [])
    np.testing.assert_array_equal(room_left_of(scene, track, body, [], [lower]), without)


def test_of_what_looks_like_a_person_nothing_is_left():
    scene, track, body = of_shoulder()
    person = replace(track, evidence=replace(track.evidence, features=np.zeros(18)))
    assert not room_left_of(scene, person, body, [], []).any()
