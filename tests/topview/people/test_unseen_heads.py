"""Where heads are that are not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from dressed_scenes import GROUND_Y, ROOM, UP, person_with, scene_of, track_at
from people_scenes import box, head_of, limb, render, standing_person
from topview.body.parts import JOINTS
from topview.people.bodies import body_of
from topview.people.motion import Motion
from topview.people.segmentation import SegmentationSettings, body_distance
from topview.people.settings import PeopleSettings
from topview.people.told import NOTHING_TOLD, Told
from topview.people.told_head import ToldHead
from topview.people.track import Track
from topview.people.unseen_heads import over_body
from topview.records import Person
from topview.room.scene import Scene

STATURE_M = 1.75
Distance = NDArray[np.float32]


def body_at(scene: Scene, head_camera: NDArray[np.float64]) -> Distance:
    return body_distance(scene, head_camera, STATURE_M, PeopleSettings().segmentation)


def missed(
    track: Track,
    before: Scene,
    scene: Scene,
    told_camera: NDArray[np.float64] | None = None,
    told: Told = NOTHING_TOLD,
) -> Track:
    """After a frame in which no head was its own, and the network told one or none."""
    now = track.coasted(scene)
    body_m = body_of(scene, now, SegmentationSettings(), before)
    elapsed_s = scene.time_s - before.time_s
    track = replace(now, body_m=body_m)
    return over_body(scene, track, [], told, told_camera, PeopleSettings(), elapsed_s)


def test_a_head_that_is_not_seen_goes_where_the_trunk_goes() -> None:
    """He walks on behind somebody's arm; where he was expected there is nobody."""
    z = 3.0
    truth = head_of(0.5, z, GROUND_Y)
    arm = box((-0.4, truth[1] - 0.2, 2.0), (1.0, truth[1] + 0.15, 2.1))
    depth_m = render(standing_person(0.5, z, GROUND_Y), [*ROOM, arm])
    before = scene_of(depth_m, None, 0)
    expected = truth - np.array([0.3, 0.0, 0.0])
    track = replace(track_at(before, truth), motion=Motion.starting_at(expected))
    for index in range(1, 11):
        scene = scene_of(depth_m, None, index)
        track, before = missed(track, before, scene), scene
    assert track.body_m2 > 0.1
    assert np.linalg.norm(track.place_camera - truth) < 0.2
    assert track.confidence == 0.0
    assert track.presence > 0.9


def test_a_hidden_head_sinks_as_surely_as_the_network_tells_it() -> None:
    """Half of him is behind a board, with his head, and the network tells that it has gone down."""
    board = box((-0.6, GROUND_Y - 2.3, 2.0), (0.1, GROUND_Y, 2.1))
    sunk_m = [sunk_after(6, sigma_m, [*ROOM, board]) for sigma_m in (0.02, 0.08, 0.16)]
    assert sunk_m == sorted(sunk_m, reverse=True)
    assert sunk_m[0] == pytest.approx(0.3, abs=0.03)
    assert sunk_m[-1] < 0.75 * sunk_m[0]
    for things in (ROOM, [*ROOM, board]):
        assert sunk_after(10, 0.02, things) == pytest.approx(0.3, abs=0.08)


def sunk_after(frames: int, sigma_m: float, things: Sequence[NDArray[np.float32]]) -> float:
    """By how much a head has sunk that the network tells 30 cm below where it was."""
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    low = truth + np.array([0.05, 0.3, 0.0])
    shown = scene_of(render(standing_person(0.0, z, GROUND_Y), ROOM), None, 0)
    depth_m = render(standing_person(0.0, z, GROUND_Y), list(things))
    track, before = replace(track_at(shown, truth), body_m=body_at(shown, truth)), shown
    told = Told((), {1: ToldHead(0.99, low, sigma_m)}, True)
    for index in range(1, frames + 1):
        scene = scene_of(depth_m, None, index)
        track, before = missed(track, before, scene, low, told), scene
    assert track.body_m2 > 0.08
    return float(track.place_camera[1] - truth[1])


@pytest.mark.parametrize("is_rough", [True, False])
def test_a_head_that_the_network_knows_roughly_draws_the_place_more_than_the_height(
    is_rough: bool,
) -> None:
    """A leg is seen below a board; he was expected 30 cm beside his place: where he went is not
    known, but that he did not bend so soon."""
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    board = box((-2.0, truth[1] - 0.5, 2.5), (2.0, GROUND_Y - 0.5, 2.6))
    depth_m = render(standing_person(0.0, z, GROUND_Y), [*ROOM, board])
    before = scene_of(depth_m, None, 0)
    expected = truth - np.array([0.3, 0.0, 0.0])
    low = truth + np.array([0.0, 0.3, 0.0])
    told = Told((), {1: ToldHead(0.9, low, 0.2 if is_rough else np.inf)}, True)
    track = replace(track_at(before, expected), body_m=body_at(before, truth))
    for index in range(1, 16):
        scene = scene_of(depth_m, None, index)
        track, before = missed(track, before, scene, told=told), scene
    assert track.body_m2 > 0.03
    assert (abs(track.place_camera[0] - truth[0]) < 0.15) == is_rough
    assert track.place_camera[1] == pytest.approx(truth[1], abs=0.1)


def test_whose_head_is_lost_beside_anothers_keeps_what_the_fitted_bodies_leave_to_him() -> None:
    """Two hug: over the surface all of both is nearer to the head that is seen."""
    places = {1: head_of(-0.2, 3.0, GROUND_Y), 2: head_of(0.2, 3.0, GROUND_Y)}
    balls = standing_person(-0.2, 3.0, GROUND_Y) + standing_person(0.2, 3.0, GROUND_Y)
    before, scene = (scene_of(render(balls, ROOM), None, index) for index in (0, 1))
    seen = replace(track_at(scene, places[2]), key=2, id=2, body_m=body_at(scene, places[2]))
    assert seen.body_m is not None
    lost = replace(track_at(before, places[1]).coasted(scene), body_m=seen.body_m + 0.1)
    fitted = Told([upright_at(own, place) for own, place in places.items()])
    shown_m2 = [
        over_body(scene, lost, [seen], told, None, PeopleSettings(), 1 / 30).body_m2
        for told in (fitted, NOTHING_TOLD)
    ]
    assert shown_m2[0] > 0.2
    assert shown_m2[1] == 0.0


def test_a_wall_is_not_the_body_of_one_who_is_hidden() -> None:
    """What is larger than anybody, seen from one side, says nothing of where the lost one is."""
    place = head_of(0.0, 3.0, GROUND_Y)
    wall = box((-2.0, GROUND_Y - 1.8, 3.0), (2.0, GROUND_Y, 3.1))
    before, scene = (scene_of(render([], [*ROOM, wall]), None, index) for index in (0, 1))
    rays = (np.arange(scene.cloud.depth_m.shape[1]) - scene.cloud.camera.cx) / scene.cloud.camera.fx
    for wide_m, is_shown in ((0.4, True), (1.5, False)):
        is_own = (np.abs(3.0 * rays) < wide_m / 2) & (scene.heights_m > 0.1)
        body_m = np.where(is_own, 0.0, np.inf).astype(np.float32)
        lost = replace(track_at(before, place).coasted(scene), body_m=body_m)
        told = Told((), {1: ToldHead(0.99, place + 0.2, 0.001)}, True)
        after = over_body(scene, lost, [], told, place + 0.2, PeopleSettings(), 1 / 30)
        assert (after.body_m2 > 0.0) == is_shown
        there = place + 0.2 if is_shown else lost.place_camera
        assert np.allclose(after.place_camera, there, atol=0.01)


def upright_at(id: int, head_camera: NDArray[np.float64]) -> Person:
    """Somebody whose joints hang below the head."""
    joints_camera = np.tile(head_camera, (len(JOINTS), 1))
    joints_camera[:, 1] = np.linspace(head_camera[1], GROUND_Y, len(JOINTS))
    return person_with(joints_camera, 1.0, id, STATURE_M)


def test_a_stretched_arm_is_no_trunk() -> None:
    """Only the arm is seen of one who stands behind a pillar: his head stays where it was."""
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    pillar = box((-0.35, GROUND_Y - 2.3, 1.8), (0.35, GROUND_Y, 2.0))
    shoulder_y = GROUND_Y - 0.8 * STATURE_M
    balls = standing_person(0.0, z, GROUND_Y)
    balls += limb((0.2, shoulder_y, z), (0.95, shoulder_y, z), 0.05)
    before = scene_of(render(balls, ROOM), None, 0)
    track = track_at(before, truth)
    for index in range(1, 6):
        scene = scene_of(render(balls, [*ROOM, pillar]), None, index)
        track, before = missed(track, before, scene), scene
    assert track.body_m is not None
    assert np.count_nonzero(np.isfinite(track.body_m)) > 50
    assert np.linalg.norm(track.place_camera - truth) < 0.1


def test_who_is_not_seen_goes_on_as_high_as_he_was() -> None:
    """Though the head seemed to sink as something came before it."""
    screen = box((-1.5, -1.4, 2.0), (1.5, GROUND_Y, 2.1))
    scenes = [scene_of(render([], [*ROOM, screen]), None, index) for index in range(20)]
    place = head_of(0.0, 3.0, GROUND_Y)
    track, motion = track_at(scenes[0], place), Motion.starting_at(place)
    for step in range(1, 6):
        walked = place + step * np.array([0.03, 0.03, 0.0])
        motion = motion.predicted(1 / 30).updated(walked)
    track = replace(track, motion=motion, seen_s=5 / 30, time_s=5 / 30, motion_s=5 / 30)
    low_m = float(motion.position_camera @ UP)
    for scene in scenes[6:]:
        track = track.coasted(scene)
    assert track.place_camera[0] > 0.2
    assert low_m - float(track.place_camera @ UP) < 0.05
