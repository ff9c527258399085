"""Of two tracks on one body, which keeps it."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, scene_of, track_at
from people_scenes import head_of, render, standing_person
from topview.detect.heads import HeadCandidate
from topview.people.existence import NEW_TRACK_S, Existence
from topview.people.features import FEATURE_NAMES, SHAPE
from topview.people.likelihood import Evidence
from topview.people.settings import PeopleSettings
from topview.people.spawning import rejoined
from topview.people.step import Step
from topview.people.told import NOTHING_TOLD, Told
from topview.people.told_head import ToldHead
from topview.people.track import Track
from topview.room.scene import Scene

HEAD = head_of(0.0, 2.2, GROUND_Y)
SHOULDER = HEAD + np.array([0.2, 0.25, 0.0])
ANOTHERS = FEATURE_NAMES.index("somebody else's")
GOOD, BAD = np.zeros(len(SHAPE)), np.full(len(SHAPE), 1.0)


def scene_at(time_s: float = 0.0) -> Scene:
    return scene_of(render(standing_person(0.0, 2.2, GROUND_Y), ROOM), None, round(30 * time_s))


def track_of(
    scene: Scene, place: NDArray[np.float64], key: int, shape: NDArray[np.float64], id: int
) -> Track:
    """With features [S] of a person or of none."""
    evidence = Evidence.starting_with(shape, scene.time_s)
    return replace(track_at(scene, place, key), id=id, evidence=evidence)


class GoodAtTheHead(Step):
    """Of which the shape is a person's at the head alone."""

    def features_under(
        self, head: HeadCandidate, nearest: NDArray[np.float32]
    ) -> NDArray[np.float64]:
        return GOOD if np.linalg.norm(head.center_camera - HEAD) < 0.1 else BAD


def step_in(scene: Scene, told: Told = NOTHING_TOLD) -> Step:
    return GoodAtTheHead(scene, None, told, PeopleSettings())


def rejoin(tracks: list[Track], scene: Scene) -> list[Track]:
    after, left = rejoined(tracks, step_in(scene), [], Existence())
    assert not left
    return after


def rejoin_for_long(*tracks: Track) -> list[Track]:
    return rejoin(rejoin(list(tracks), scene_at()), scene_at(2 * NEW_TRACK_S))


def test_a_person_goes_back_to_the_head_which_a_track_that_is_no_person_yet_has():
    scene = scene_at()
    person = replace(track_of(scene, SHOULDER, 1, GOOD, id=7), confidence=0.2)
    doubtful = replace(track_of(scene, HEAD, 2, GOOD, id=0), confidence=0.9)
    waits = rejoin([person, doubtful], scene)
    assert [track.id for track in waits] == [7, 0]
    (moved,) = rejoin(waits, scene_at(2 * NEW_TRACK_S))
    assert moved.id == 7
    np.testing.assert_allclose(moved.place_camera, HEAD, atol=0.02)


def test_a_thing_that_is_probably_no_person_keeps_its_head_from_nobody():
    scene = scene_at()
    person = replace(track_of(scene, SHOULDER, 1, GOOD, id=7), confidence=0.2)
    thing = replace(track_of(scene, HEAD, 2, BAD, id=0), confidence=0.9)
    after = rejoin_for_long(person, thing)
    assert [track.id for track in after] == [7, 0]
    np.testing.assert_allclose(after[0].place_camera, SHOULDER, atol=0.02)


def test_a_person_with_a_sure_head_leaves_somebody_elses_to_that_one():
    scene = scene_at()
    person = replace(track_of(scene, SHOULDER, 1, GOOD, id=7), confidence=0.8)
    newcomer = replace(track_of(scene, HEAD, 2, GOOD, id=0), confidence=1.0)
    after = rejoin_for_long(person, newcomer)
    assert [track.id for track in after] == [7, 0]


def test_a_head_that_is_nearer_to_somebody_else_is_not_taken():
    scene = scene_at()
    person = replace(track_of(scene, SHOULDER, 1, GOOD, id=7), confidence=0.2)
    other = replace(
        track_of(scene, HEAD + np.array([0.0, -0.22, 0.0]), 3, GOOD, id=8), confidence=0.2
    )
    doubtful = replace(track_of(scene, HEAD, 2, GOOD, id=0), confidence=0.9)
    after = rejoin_for_long(person, other, doubtful)
    np.testing.assert_allclose(after[0].place_camera, SHOULDER, atol=0.02)


def test_a_head_whose_shape_is_good_now_is_kept_whatever_it_was():
    scene = scene_at()
    track = replace(track_of(scene, HEAD, 1, BAD, id=0), confidence=0.75)
    raised = HeadCandidate(HEAD + np.array([0.2, -0.1, 0.0]), 0.7)
    (kept,), left = rejoined([track], step_in(scene), [raised], Existence())
    np.testing.assert_allclose(kept.place_camera, HEAD, atol=0.02)
    assert left == [raised]


@pytest.mark.parametrize("is_there", [True, False])
def test_a_person_is_where_the_network_sees_the_head_whatever_else_looks_like_one(is_there):
    scene = scene_at()
    hidden = replace(track_of(scene, SHOULDER, 1, GOOD, id=7), confidence=0.0)
    sees = ToldHead(0.99, HEAD if is_there else SHOULDER, sigma_m=0.03)
    first = step_in(scene, Told(heads={7: sees}, has_network=True))
    then = step_in(scene_at(2 * NEW_TRACK_S), first.told)
    heads = [HeadCandidate(HEAD, 0.9)]
    waits, _ = rejoined([hidden], first, heads, Existence())
    (after,), _ = rejoined(waits, then, heads, Existence())
    np.testing.assert_allclose(after.place_camera, HEAD if is_there else SHOULDER, atol=0.02)


def test_of_who_is_no_person_yet_a_likelier_head_is_taken_at_once():
    scene = scene_at()
    track = replace(track_of(scene, SHOULDER, 1, BAD, id=0), confidence=0.75)
    head = HeadCandidate(HEAD, 0.7)
    (moved,), left = rejoined([track], step_in(scene), [head], Existence())
    np.testing.assert_allclose(moved.place_camera, HEAD, atol=0.02)
    assert not left
    assert moved.evidence.shape_s == 0.0  # the shape until now was the shoulder's


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_likelier_of_two_that_are_not_confirmed_keeps_its_body(order):
    scene = scene_at()
    head, shoulder = (
        track_of(scene, place, key, shape, id=0)
        for key, (place, shape) in enumerate([(HEAD, GOOD), (SHOULDER, 0.1 * BAD)], start=1)
    )
    step = Step(scene, None, NOTHING_TOLD, PeopleSettings())
    tracks = [(head, shoulder)[index] for index in order]
    after = {track.key: track for track in step.with_evidence(tracks, set())}
    alone = step.with_evidence([head], set())[0]
    odds = {
        key: step.likelihood.log_odds_of_shape(track.evidence.shape)
        for key, track in {**after, 0: alone}.items()
    }
    assert odds[1] >= odds[0] - 1e-9
    assert after[2].evidence.features[ANOTHERS] > after[1].evidence.features[ANOTHERS]
