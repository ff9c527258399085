"""Which head is whose."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import BLUE, GROUND_Y, RED, ROOM, UP, dressed, scene_of, track_at
from people_scenes import box, head_of, render, standing_person
from topview.detect.heads import HeadCandidate
from topview.filter.assignment import assign
from topview.people.appearance import clothes_under
from topview.people.association import associate
from topview.people.motion import Motion
from topview.people.track import Track
from topview.room.scene import Scene

FRAME_S = 1 / 30
LIKE_A_PERSON, LIKE_FURNITURE = 6.0, -6.0


def best_sum(scores: NDArray[np.float64]) -> float:
    """Of all ways to make pairs, or none."""
    rows, columns = scores.shape
    return max(
        float(sum(scores[row, column] for row, column in zip(some, others, strict=True)))
        for count in range(min(rows, columns) + 1)
        for some in combinations(range(rows), count)
        for others in permutations(range(columns), count)
    )


@settings(max_examples=50)
@given(st.integers(1, 4), st.integers(0, 4), st.integers(0, 1000))
def test_an_assignment_is_one_to_one_never_forbidden_and_the_best(
    tracks: int, heads: int, seed: int
) -> None:
    scores = np.random.default_rng(seed).uniform(-0.5, 1.0, (tracks, heads))
    scores[scores <= 0.0] = -np.inf
    pairs = assign(scores)
    assert len(set(pairs.values())) == len(pairs)
    assert sum(scores[pair] for pair in pairs.items()) == pytest.approx(best_sum(scores))


def hidden(track: Track, scene: Scene, for_s: float) -> Track:
    """The same, whose head has not been seen for so long until this scene."""
    ago_s = scene.time_s - for_s
    there = track.coasted(scene)
    return replace(there, time_s=scene.time_s - FRAME_S, seen_s=ago_s, motion_s=ago_s)


def moved_by(track: Track, offset: NDArray[np.float64], scene: Scene) -> Track:
    """The same, as it was one frame ago and so far away."""
    place_camera = track.place_camera + offset
    ago_s = scene.time_s - FRAME_S
    motion = Motion.starting_at(place_camera)
    return replace(
        track, motion=motion, place_camera=place_camera, seen_s=ago_s, time_s=ago_s, motion_s=ago_s
    )


def taken(
    tracks: Sequence[Track], scene: Scene, heads: Sequence[HeadCandidate],
    log_odds: float = LIKE_A_PERSON,
) -> tuple[dict[int, HeadCandidate], list[HeadCandidate]]:  # fmt: skip
    return associate(tracks, scene, heads, lambda _: log_odds)


def test_a_head_in_plain_view_is_taken() -> None:
    balls = standing_person(0.05, 2.6, GROUND_Y)
    before, scene = (scene_of(render(balls, ROOM), None, index) for index in (0, 1))
    head = HeadCandidate(head_of(0.05, 2.6, GROUND_Y), 0.95)
    track = track_at(before, head.center_camera - np.array([0.05, 0.0, 0.0]))
    assert taken([track], scene, [head]) == ({0: head}, [])
    far = HeadCandidate(head_of(1.2, 2.6, GROUND_Y), 0.95)
    assert taken([track], scene, [far, head]) == ({0: head}, [far])


def test_the_stature_of_a_shoulder_is_forgotten_once_the_head_is_known() -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    before, scene = (
        scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, index) for index in (0, 1)
    )
    head = HeadCandidate(place, 0.95)
    shoulder = track_at(before, place - 0.3 * UP, stature_m=1.4)
    for track, is_taken in (
        (track_at(before, place, stature_m=1.4), False),
        (shoulder.restarted(before, head), True),
    ):
        assert (taken([track], scene, [head])[0] == {0: head}) == is_taken


def test_a_head_that_nobody_detects_is_followed_by_its_shape() -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    depths = [render(standing_person(x, 2.6, GROUND_Y), ROOM) for x in (0.0, 0.08)]
    before, scene = (scene_of(depth, None, index) for index, depth in enumerate(depths))
    matches, left = taken([track_at(before, place)], scene, [])
    assert np.linalg.norm(matches[0].center_camera - place - np.array([0.08, 0.0, 0.0])) < 0.05
    assert left == []


def test_a_head_that_the_network_tells_may_be_of_somebody_hidden_only() -> None:
    scene = scene_of(
        render([], [*ROOM, box((-1.4, GROUND_Y - 2.2, 1.8), (0.1, GROUND_Y, 2.0))]), None, 9
    )
    place = head_of(-0.1, 3.2, GROUND_Y)
    told = HeadCandidate(place + np.array([0.2, 0.0, 0.0]), 0.3)
    track = track_at(scene, place)
    matches, left = associate([hidden(track, scene, 0.3)], scene, [], lambda _: 5.0, [told])
    assert (matches, left) == ({0: told}, [])
    free = scene_of(render([], ROOM), None, 9)
    assert associate([moved_by(track, np.zeros(3), free)], free, [], lambda _: 5.0, [told])[0] == {}


@pytest.mark.parametrize("body_m2", [0.0, 0.1])
def test_what_is_on_the_body_of_somebody_hidden_is_no_other_head(body_m2: float) -> None:
    """An elbow is about as high as a child's head."""
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 9)
    owner = hidden(track_at(scene, head_of(0.0, 2.6, GROUND_Y), 1), scene, 1.0)
    owner = replace(owner, body_m2=body_m2)
    assert owner.body_m is not None
    row, column = max(zip(*np.nonzero(owner.body_m < np.inf), strict=True), key=lambda at: at[1])
    elbow = HeadCandidate(scene.cloud.points_camera[row, column].astype(float), 0.5)
    aside = elbow.center_camera + np.array([0.4, 0.0, 0.0])
    child = replace(hidden(track_at(scene, aside, 2), scene, 1.0), body_m=None)
    matches, left = taken([owner, child], scene, [elbow], log_odds=0.0)
    assert (1 in matches) == (body_m2 == 0.0)
    assert left == ([] if 1 in matches else [elbow])


@pytest.mark.parametrize("step_m", [-0.08, 0.0, 0.08])
def test_two_who_are_near_each_other_keep_their_own_heads(step_m: float) -> None:
    """Also when both go the same way, which brings one to where the other is expected."""
    xs = (-0.18, 0.18)
    balls = [ball for x in xs for ball in standing_person(x + step_m, 2.6, GROUND_Y)]
    scene = scene_of(render(balls, ROOM), None, 1)
    back = np.array([-step_m, 0.0, 0.0])
    tracks = [
        moved_by(track_at(scene, head_of(x + step_m, 2.6, GROUND_Y), key), back, scene)
        for key, x in enumerate(xs, 1)
    ]
    heads = [HeadCandidate(head_of(x + step_m, 2.6, GROUND_Y), 0.95) for x in xs]
    for order in (heads, heads[::-1]):
        matches, left = taken(tracks, scene, order)
        assert left == []
        for row, head in enumerate(heads):
            assert np.linalg.norm(matches[row].center_camera - head.center_camera) < 0.06


def test_two_who_cross_are_told_apart_by_their_motion() -> None:
    left, right = (Motion.starting_at(np.array([x, 0.0, 3.0])) for x in (-0.3, 0.3))
    for step in range(1, 8):
        way = np.array([0.04 * step, 0.0, 0.0])
        left = left.predicted(FRAME_S).updated(np.array([-0.3, 0.0, 3.0]) + way)
        right = right.predicted(FRAME_S).updated(np.array([0.3, 0.0, 3.0]) - way)
    # After the next step the one who came from the left is on the right.
    heads = [np.array([x, 0.0, 3.0]) for x in (0.02, -0.02)]
    scores = [[m.predicted(FRAME_S).log_density(head) for head in heads] for m in (left, right)]
    assert assign(np.array(scores)) == {0: 0, 1: 1}


def test_who_is_hidden_takes_nobodys_head() -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 1)
    seen = moved_by(track_at(scene, place, 1), np.array([0.08, 0.0, 0.0]), scene)
    behind = hidden(track_at(scene, place, 2), scene, 0.2)  # nearer to where the head is now
    head = HeadCandidate(place, 0.95)
    matches, left = taken([behind, seen], scene, [head])
    assert (matches.keys(), left) == ({1}, [])
    assert np.linalg.norm(matches[1].center_camera - place) < 0.04


@pytest.mark.parametrize(
    ("offset", "log_odds", "comes_back"),
    [
        ((0.0, 0.0, 0.0), LIKE_A_PERSON, True),
        ((0.1, 0.0, 0.0), LIKE_A_PERSON, True),
        ((0.0, 0.0, 0.0), LIKE_FURNITURE, False),
        ((0.0, 0.45, 0.0), LIKE_A_PERSON, False),  # the chest
        ((0.0, -0.25, 0.0), LIKE_A_PERSON, False),  # a fist above the head
        ((1.5, 0.0, 0.0), LIKE_A_PERSON, False),
    ],
)
def test_who_was_hidden_comes_back_where_a_person_of_that_height_may_be(
    offset: tuple[float, float, float], log_odds: float, comes_back: bool
) -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 60)
    pillar = box((-0.5, GROUND_Y - 2.2, 1.6), (0.5, GROUND_Y, 1.8))
    covered = scene_of(render([], [*ROOM, pillar]), None, 59)
    behind = hidden(track_at(scene, place, stature_m=1.75), covered, 1.0)
    head = HeadCandidate(place + np.array(offset), 0.95)
    matches, left = taken([behind], scene, [head], log_odds)
    assert (matches == {0: head}) == comes_back
    assert (left == [head]) != comes_back


@pytest.mark.parametrize("is_told", [False, True])
def test_who_comes_back_takes_no_hand_beside_a_head_that_the_network_tells(is_told: bool) -> None:
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 60)
    pillar = box((-0.5, GROUND_Y - 2.2, 1.6), (0.5, GROUND_Y, 1.8))
    covered = scene_of(render([], [*ROOM, pillar]), None, 59)
    behind = hidden(track_at(scene, place), covered, 1.0)
    beside = place + np.array([0.25, 0.0, 0.0])
    other = hidden(track_at(scene, beside, 2), covered, 1.0)
    if is_told:
        other = other.told_at(covered, beside, 0.03, 1 / 30)
    matches, _ = taken([behind, other], scene, [HeadCandidate(place, 0.95)])
    assert (0 in matches) != is_told


@pytest.mark.parametrize(
    ("log_odds", "comes_back"), [(LIKE_A_PERSON, True), (LIKE_FURNITURE, False)]
)
def test_a_track_that_is_not_confirmed_is_of_whoever_may_have_come_back_there(
    log_odds: float, comes_back: bool
) -> None:
    """Though the track was nearer to where the head is now."""
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 60)
    pillar = box((-0.5, GROUND_Y - 2.2, 1.6), (0.5, GROUND_Y, 1.8))
    covered = scene_of(render([], [*ROOM, pillar]), None, 59)
    behind = hidden(track_at(scene, place + np.array([0.2, 0.0, 0.0])), covered, 1.0)
    new = replace(moved_by(track_at(scene, place, 2), np.zeros(3), scene), id=0)
    matches, _ = taken([behind, new], scene, [HeadCandidate(place, 0.95)], log_odds)
    assert matches.keys() == {0 if comes_back else 1}


@pytest.mark.parametrize("rgb", [RED, BLUE])
def test_who_comes_back_wears_the_same_clothes(rgb: tuple[int, int, int]) -> None:
    """Of two who are hidden it is the one with these clothes, though the other was nearer."""
    place = head_of(0.0, 2.6, GROUND_Y)
    scene = scene_of(*dressed([(standing_person(0.0, 2.6, GROUND_Y), rgb)]), 60)
    covered = scene_of(render([], [*ROOM, box((-0.9, -1.1, 1.6), (0.9, 1.1, 1.8))]), None, 59)
    tracks = []
    for key, (worn, x) in enumerate(((RED, -0.12), (BLUE, 0.12)), 1):
        dress = scene_of(*dressed([(standing_person(0.0, 2.6, GROUND_Y), worn)]), 0)
        clothes = clothes_under(dress, place, [])
        track = track_at(scene, place + np.array([x, 0.0, 0.0]), key)
        tracks.append(replace(hidden(track, covered, 1.0), clothes=clothes))
    head = HeadCandidate(place, 0.95)
    assert taken(tracks, scene, [head])[0] == {(RED, BLUE).index(rgb): head}


def test_a_head_that_sinks_under_cover_is_a_shoulder() -> None:
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    arm = box((-0.6, (truth[1] - 0.2) * 2 / 3, 2.0), (0.6, (truth[1] + 0.1) * 2 / 3, 2.1))
    balls = standing_person(0.0, z, GROUND_Y)
    before = scene_of(render(balls, ROOM), None, 0)
    scene = scene_of(render(balls, [*ROOM, arm]), None, 1)
    shoulder = HeadCandidate(truth - 0.25 * UP, 0.9)
    matches, left = taken([track_at(before, truth)], scene, [shoulder])
    assert left == [shoulder]
    assert all(head is not shoulder for head in matches.values())
