"""What of a new track's body is held for the room, until it moves."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.detect.heads import HeadCandidate
from topview.people.settings import PeopleSettings
from topview.people.spawning import SPREAD_FEATURES, room_left_of, under_higher
from topview.people.step import Step
from topview.people.told import Told
from topview.people.track import Track
from topview.room.scene import Scene

HEAD = head_of(0.0, 2.2, GROUND_Y)
SHOULDER = HEAD + np.array([0.2, 0.25, 0.0])


def step_in(scene: Scene, *, has_network: bool = False) -> Step:
    return Step(scene, None, Told(has_network=has_network), PeopleSettings())


def of_shoulder() -> tuple[Scene, Track, NDArray[np.float32]]:
    """Somebody, whose shoulder is followed as a head that has too much above it."""
    scene = scene_of(render(standing_person(0.0, 2.2, GROUND_Y), ROOM), None, 0)
    track = replace(track_at(scene, SHOULDER, 1), id=0)
    features = track.evidence.features.copy()
    features[SPREAD_FEATURES[0]] = 0.5
    body = track_at(scene, HEAD, 2).body_m
    assert body is not None
    return scene, replace(track, evidence=replace(track.evidence, features=features)), body


def test_what_is_not_under_the_head_is_the_rooms():
    scene, track, body = of_shoulder()
    is_left = room_left_of(step_in(scene), track, body, [])
    assert is_left.any()
    assert not (is_left & scene.is_under(SHOULDER, 0.2)).any()


def test_the_trunk_under_a_higher_head_is_not():
    scene, track, body = of_shoulder()
    shoulder, head = HeadCandidate(SHOULDER, 0.9), HeadCandidate(HEAD, 0.6)
    is_rest = room_left_of(step_in(scene), track, body, [])
    is_room = is_rest & ~under_higher(scene, shoulder, [shoulder, head])
    assert not (is_room & scene.is_under(HEAD, 0.2)).any()
    assert is_room.sum() < 0.5 * is_rest.sum()


def test_under_lower_heads_and_its_own_is_nothing_that_is_kept():
    scene, _, _ = of_shoulder()
    head = HeadCandidate(HEAD, 0.6)
    assert not under_higher(scene, head, [HeadCandidate(SHOULDER, 0.9), head]).any()


def test_of_what_looks_like_a_person_nothing_is_left():
    scene, track, body = of_shoulder()
    person = replace(track, evidence=replace(track.evidence, features=np.zeros(18)))
    assert not room_left_of(step_in(scene), person, body, []).any()


def test_where_a_network_is_asked_what_is_no_longer_than_a_person_is_not_the_rooms():
    """Who goes on all fours has too much aside of the head, too."""
    scene, track, body = of_shoulder()
    asked = step_in(scene, has_network=True)
    assert not room_left_of(asked, track, body, []).any()
    is_wide = np.abs(scene.plan_m[0]) < 1.5
    wall = np.where(is_wide & (scene.cloud.depth_m > 0.0), 1.0, np.inf).astype(np.float32)
    assert room_left_of(asked, track, wall, []).any()
