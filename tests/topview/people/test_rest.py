"""What was refused and stands still is left as it was, until it changes or is due."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.people.features import FEATURE_NAMES
from topview.people.likelihood import EVIDENCE_MEMORY_S, NEWS, Likelihood
from topview.people.rest import is_at_rest, left_as_they_were
from topview.people.track import Track
from topview.room.background import Background
from topview.room.scene import Scene

BY_NETWORK = Likelihood("made up", 0.0, dict.fromkeys(FEATURE_NAMES, 0.0), 0.0, 0.0, 1.0, 0.0)
"""Whose log-odds are those of the network."""
FIRST, SECOND = (
    scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, index) for index in (0, 1)
)
HIDDEN = scene_of(
    render([*standing_person(0.0, 2.6, GROUND_Y), *standing_person(0.3, 2.0, GROUND_Y)], ROOM),
    None,
    1,
)
HEAD = head_of(0.0, 2.6, GROUND_Y)
IS_BODY = (FIRST.aside_of(HEAD) < 0.3) & (FIRST.heights_m > 0.1)
BODY_M = np.where(IS_BODY, np.float32(0.5), np.float32(np.inf))


def refused(**changes: Any) -> Track:
    """A thing that the network took for none a while ago; with `changes` of what is known of it."""
    track = replace(track_at(FIRST, HEAD), id=0, body_m=BODY_M)
    known = {"network": -4.0, "asked_s": 0.5, "answered_s": 0.0, "looked_s": 0.0, "still": 1.0}
    evidence = replace(track.evidence, **(known | changes))
    return replace(track, evidence=evidence)


def seen_for(scene: Scene, seconds: float) -> Scene:
    """The scene as one that has been the same for so long."""
    steady = Background(np.inf)
    for time_s in (scene.time_s - seconds, scene.time_s):
        steady.update(scene.cloud.depth_m, np.zeros(IS_BODY.shape, np.bool_), time_s)
    return replace(scene, steady=steady)


def test_what_was_refused_and_stands_still_is_at_rest() -> None:
    assert is_at_rest(refused(), seen_for(SECOND, 0.5), BY_NETWORK)


@pytest.mark.parametrize(
    "track",
    [
        replace(refused(), id=3),
        replace(refused(), time_s=0.1),  # its head is not seen
        replace(refused(), body_m=None),
        refused(still=0.9),
        refused(asked_s=0.0),
        refused(network=-1.0),
    ],
    ids=["a person", "not seen", "without a body", "has moved", "not asked about", "in doubt"],
)
def test_nothing_else_is(track: Track) -> None:
    assert not is_at_rest(track, seen_for(SECOND, 0.5), BY_NETWORK)


def test_nor_is_what_has_changed_since_it_was_looked_at() -> None:
    assert not is_at_rest(refused(looked_s=-1.0), seen_for(SECOND, 0.5), BY_NETWORK)


def test_it_is_where_it_was_but_for_what_something_hides() -> None:
    [track] = left_as_they_were([refused()], HIDDEN, FIRST)
    assert track.is_seen
    assert track.time_s == HIDDEN.time_s
    np.testing.assert_array_equal(track.place_camera, refused().place_camera)
    assert track.body_m is not None
    is_hidden = FIRST.cloud.depth_m - HIDDEN.cloud.depth_m > 0.3
    is_left = track.body_m < np.inf
    assert (IS_BODY & is_hidden).sum() > 50
    assert not (is_left & is_hidden).any()
    assert is_left[IS_BODY & ~is_hidden].all()


def test_the_network_is_asked_about_it_when_what_it_said_is_forgotten() -> None:
    evidence = refused().evidence
    for is_there, holds_s in ((False, NEWS * evidence.asked_s), (True, EVIDENCE_MEMORY_S)):
        assert not evidence.is_to_be_asked(holds_s - 0.01, is_there)
        assert evidence.is_to_be_asked(holds_s + 0.01, is_there)
