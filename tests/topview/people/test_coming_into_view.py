"""Who was out of sight and comes into view is known by what is seen of the body."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, UP, person_with, scene_of, track_at
from people_scenes import box, head_of, render, standing_person
from topview.body.parts import JOINTS
from topview.people.clusters import give_what_emerges
from topview.people.settings import PeopleSettings
from topview.people.step import Step
from topview.people.told import NOTHING_TOLD, Told
from topview.people.told_head import ToldHead
from topview.people.track import Track
from topview.people.unseen_heads import over_body
from topview.room.background import Background
from topview.room.scene import Scene

Z, EDGE = 3.0, 0.45
SCREEN = box((-1.5, GROUND_Y - 2.3, 2.0), (EDGE * 2.0 / Z, GROUND_Y, 2.1))
PLACE = head_of(0.25, Z, GROUND_Y)
HIDDEN_S = 0.2


def scene_with(x: float, index: int) -> Scene:
    """Somebody at a place beside or behind a screen."""
    return scene_of(render(standing_person(x, Z, GROUND_Y), [*ROOM, SCREEN]), None, index)


def hidden_track() -> Track:
    """Of somebody who has gone behind the screen, and of whom nothing is seen."""
    before = scene_of(render(standing_person(PLACE[0], Z, GROUND_Y), ROOM), None, 0)
    track = track_at(before, PLACE)
    for index in range(1, round(30 * HIDDEN_S)):
        track = track.coasted(scene_with(-0.8, index))
    nothing = np.full(before.cloud.depth_m.shape, np.inf, np.float32)
    return replace(track, body_m=nothing)


def moved(track: Track, right_m: float) -> Track:
    """With all samples of the place elsewhere."""
    assert track.places is not None
    overview_m = track.places.overview_m + np.array([right_m, 0.0])
    return replace(track, places=replace(track.places, overview_m=overview_m))


HIDDEN, COMING = hidden_track(), scene_with(0.5, round(30 * HIDDEN_S))
IS_COMING = COMING.cloud.depth_m < scene_with(-0.8, 0).cloud.depth_m - 0.01
IS_OFF_THE_FLOOR = COMING.heights_m > 0.1


def given_to(tracks: list[Track], scene: Scene, told: Told = NOTHING_TOLD) -> NDArray[np.bool_]:
    """[N, h, w] what emerges, of nobody's bodies."""
    bodies_m = np.full((len(tracks), *scene.cloud.depth_m.shape), np.inf, np.float32)
    give_what_emerges(scene, tracks, bodies_m, told)
    return bodies_m < np.inf


def test_what_comes_out_from_behind_a_screen_is_his_who_went_there() -> None:
    [is_his] = given_to([HIDDEN], COMING)
    assert is_his[IS_COMING & IS_OFF_THE_FLOOR].mean() > 0.8
    assert not (is_his & ~IS_COMING).any()


def test_and_it_tells_where_he_is() -> None:
    truth, off_m = head_of(0.5, Z, GROUND_Y), []
    track = replace(HIDDEN, body_m=np.where(IS_COMING, 0.5, np.inf).astype(np.float32))
    for _ in range(10):
        off_m.append(np.linalg.norm(track.place_camera - truth))
        track = over_body(COMING, track, [], NOTHING_TOLD, None, PeopleSettings(), 1 / 30)
    assert off_m == sorted(off_m, reverse=True)
    assert off_m[-1] < 0.6 * off_m[0]


@pytest.mark.parametrize("p_person", [0.01, 0.3])
def test_what_the_network_takes_for_no_persons_is_not_his(p_person: float) -> None:
    """He stays where he was, as surely as before."""
    track = replace(HIDDEN, body_m=np.where(IS_COMING, 0.5, np.inf).astype(np.float32))
    told = Told((), {1: ToldHead(p_person, PLACE, np.inf)}, True)
    is_his = p_person > 0.05
    after = over_body(COMING, track, [], told, None, PeopleSettings(), 1 / 30)
    assert after.body_m is not None
    assert ((after.body_m < np.inf).any(), after.body_m2 > 0.0) == (is_his, is_his)
    assert (after.place_camera == track.place_camera).all() == (not is_his)
    assert given_to([HIDDEN], COMING, told).any() == is_his
    [looked_at] = Step(COMING, COMING, told, PeopleSettings()).with_evidence([track], {track.key})
    assert (looked_at.evidence.network != track.evidence.network) == is_his


@pytest.mark.parametrize("away_m", [1.5, 2.5])
def test_what_comes_where_he_can_hardly_be_is_somebody_new_s(away_m: float) -> None:
    away = moved(HIDDEN, away_m)
    assert not given_to([away], COMING).any()


def test_nobody_who_is_seen_or_not_confirmed_gets_more() -> None:
    seen = track_at(COMING, head_of(0.5, Z, GROUND_Y))
    for track in (seen, replace(HIDDEN, id=0), replace(HIDDEN, body_m=seen.body_m)):
        assert not given_to([track], COMING).any()


def test_what_has_stood_there_all_the_time_is_nobody_s() -> None:
    """As a chair that the person hid."""
    steady = Background(np.inf)
    for time_s in (-1.0, COMING.time_s):
        steady.update(COMING.cloud.depth_m, np.zeros(IS_COMING.shape, np.bool_), time_s)
    assert not given_to([HIDDEN], replace(COMING, steady=steady)).any()


def test_a_limb_of_who_stands_before_him_is_not_his() -> None:
    """That body is tracked, and the limb is on it."""
    joints_camera = np.tile(head_of(0.5, Z, GROUND_Y), (len(JOINTS), 1))
    joints_camera[:, 1] = np.linspace(joints_camera[0, 1], GROUND_Y, len(JOINTS))
    other = track_at(COMING, head_of(0.5, Z, GROUND_Y) + 2.0 * UP, 2, stature_m=1.75)
    told = Told([person_with(joints_camera, 1.0, other.id)])
    is_his, _ = given_to([HIDDEN, other], COMING, told)
    assert not is_his.any()


def test_of_two_who_are_hidden_it_is_the_likelier_one_s() -> None:
    other = moved(replace(HIDDEN, id=2, key=2), -0.4)
    is_others, is_his = given_to([other, HIDDEN], COMING)
    assert is_his.any()
    assert not is_others.any()
