"""Plants, shelves and doors are nobody, and whoever sits, is small, far or half hidden somebody."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from people_scenes import Ball, box, frame, limb, plane, render, standing_person, with_noise

from topview.camera.pyramid import Pyramid
from topview.detect.cloud import Cloud
from topview.people.finder import PeopleFinder
from topview.people.floor import FloorPlane
from topview.people.newcomers import DOUBTED_S
from topview.people.scene import Scene, SceneSettings
from topview.people.stillness import FIRST_LOOKS, MOVED_LOOKS, Stillness
from topview.people.validation import is_torn_out
from topview.records import KINECT1_NOISE
from topview_lab.sim import SimulatedRecording, scene_by_name

GROUND_Y = 1.1
WALL_M = 4.9
UP = np.array([0.0, -1.0, 0.0])
FLOOR = plane(UP, GROUND_Y)
ROOM = [FLOOR, np.full_like(FLOOR, WALL_M)]
FAR_M = 4.5
LOOK_S = 0.1
FIRST, MOVED = round(FIRST_LOOKS + 0.5), round(MOVED_LOOKS + 0.5)


def plant(x: float, z: float, height_m: float) -> list[Ball]:
    pot = limb((x, GROUND_Y - 0.17, z), (x, GROUND_Y - 0.1, z), 0.17)
    return pot + limb((x, GROUND_Y - 0.4, z), (x, GROUND_Y - height_m + 0.12, z), 0.12)


def watch(stillness: Stillness, depth_m: NDArray[np.float32], looks: range) -> None:
    """Look at the same image several times; the first image of all was taken at 0."""
    for k in looks:
        assert stillness.is_due(k * LOOK_S)
        stillness.look(depth_m, k * LOOK_S)


def users_in(depths: list[NDArray[np.float32]]) -> list[int]:
    """How many users each frame has; every frame has its own noise."""
    finder = PeopleFinder()
    return [
        len(finder.update(Pyramid(frame(with_noise(depth, index), index))))
        for index, depth in enumerate(depths)
    ]


@pytest.mark.parametrize("height_m", [0.75, 1.0, 1.2])
@pytest.mark.parametrize("z", [3.0, FAR_M])
def test_a_plant_is_nobody_and_never_will_be(height_m: float, z: float) -> None:
    depth = render(plant(0.7, z, height_m), ROOM)
    assert set(users_in([depth] * int(30 * (DOUBTED_S + 0.5)))) == {0}


def test_a_plant_that_walks_is_no_plant() -> None:
    depths = [render(plant(0.7 - 0.03 * index, 3.0, 1.2), ROOM) for index in range(15)]
    assert users_in(depths)[-1] == 1


@pytest.mark.parametrize("size_m", [(0.9, 1.5), (0.9, 2.0), (0.3, 1.6), (0.25, 1.0)])
def test_a_shelf_a_door_or_a_board_behind_somebody_is_nobody(size_m: tuple[float, float]) -> None:
    breadth_m, height_m = size_m
    board = box((-0.1, GROUND_Y - height_m, 4.4), (breadth_m - 0.1, GROUND_Y, 4.7))
    person = standing_person(0.15, 2.6, GROUND_Y)
    assert set(users_in([render(person, [*ROOM, board])] * 15)) == {1}
    assert set(users_in([render([], [*ROOM, board])] * 15)) == {0}


@pytest.mark.parametrize(
    ("name", "balls", "furniture"),
    [
        ("stands far away", standing_person(0.2, FAR_M, GROUND_Y, 1.7), []),
        ("is a child", standing_person(0.2, 3.0, GROUND_Y, 1.15), []),
        ("sits or kneels", standing_person(0.2, 3.0, GROUND_Y + 0.55, 1.75), []),
        (
            "stands behind a table",
            standing_person(0.2, 3.2, GROUND_Y, 1.75),
            [box((-0.6, GROUND_Y - 0.78, 2.2), (1.0, GROUND_Y, 2.9))],
        ),
    ],
)
def test_somebody_is_found_at_once(
    name: str, balls: list[Ball], furniture: list[NDArray[np.float32]]
) -> None:
    assert users_in([render(balls, [*ROOM, *furniture])] * 3) == [1, 1, 1], name


@pytest.mark.parametrize(("scene", "seed"), [("pointing", 4), ("sitting", 1), ("four_users", 2)])
def test_in_furnished_rooms_there_are_people_only(scene: str, seed: int) -> None:
    recording = SimulatedRecording(scene_by_name(scene, seed=seed, frames=5))
    finder = PeopleFinder()
    for each in recording:
        assert len(finder.update(Pyramid(each))) == len(recording.scene.actors)


def test_an_arm_that_is_swung_is_nobody() -> None:
    """It moves, as people do and furniture does not."""
    scene = replace(scene_by_name("throwing", seed=521, frames=40), start_s=1.0)
    finder = PeopleFinder()
    for each in SimulatedRecording(scene):
        assert len(finder.update(Pyramid(each))) == 1


@settings(max_examples=10)
@given(
    seed=st.integers(0, 2**16),
    depth_m=st.floats(2.0, 5.0),
    looks=st.sampled_from((1.0, 2.0, 6.0)),
)
def test_noise_alone_never_breaks_stillness_and_a_sway_does(
    seed: int, depth_m: float, looks: float
) -> None:
    """However many looks there would have been from one frame to the next."""
    rng = np.random.default_rng(seed)
    is_body = np.zeros((60, 80), np.bool_)
    height, width = np.array([1.0, 0.3]) * 140.0 / depth_m
    is_body[: int(height), : int(width)] = True

    def seen(ahead_m: float) -> NDArray[np.float32]:
        noise = rng.normal(size=is_body.shape) * KINECT1_NOISE.sigma_m(np.array(depth_m))
        return (depth_m - ahead_m + noise).astype(np.float32)

    stillness = Stillness(seen(0.0), is_body, 0.0, LOOK_S)
    assert not any(stillness.is_broken_in(seen(0.0), looks) for _ in range(150))
    # What is less is lost in the noise, of which more is left in the mean of fewer frames.
    sigma_m = float(KINECT1_NOISE.sigma_m(np.array(depth_m)))
    sway_m = max(0.02, 0.8 * looks**0.5 * sigma_m)
    assert any(stillness.is_broken_in(seen(sway_m), looks) for _ in range(15))


def test_what_hides_a_body_does_not_break_its_stillness_and_what_it_leaves_does() -> None:
    is_body = np.ones((30, 10), np.bool_)
    depth_m = np.full(is_body.shape, 3.0, np.float32)
    hidden_m, left_m = depth_m.copy(), depth_m.copy()
    hidden_m[:, :6] = 2.0
    left_m[:, :6] = 4.5
    stillness = Stillness(depth_m, is_body, 0.0, LOOK_S)
    assert not any(stillness.is_broken_in(hidden_m) for _ in range(30))
    assert stillness.is_broken_in(left_m)


@pytest.mark.parametrize("is_steady", [False, True])
def test_limbs_leave_pixels_free_and_an_outline_that_flickers_does_not(is_steady: bool) -> None:
    """A sixth of the pixels is left free: that of limbs, or what showed it by turns from the
    start."""
    depth_m = np.full((30, 12), 3.0, np.float32)
    left_m = depth_m.copy()
    left_m[:, :2] = 4.5
    stillness = Stillness(depth_m, np.ones(depth_m.shape, np.bool_), 0.0, LOOK_S)
    for k in range(1, FIRST):
        watch(stillness, depth_m if is_steady or k % 2 == 0 else left_m, range(k, k + 1))
    assert not stillness.has_left
    watch(stillness, left_m, range(FIRST, FIRST + MOVED))
    assert stillness.has_left == is_steady
    assert not stillness.is_broken


def test_a_board_half_hidden_at_first_is_nobody_and_somebody_there_is_once_he_moves() -> None:
    person = standing_person(-0.2, 2.6, GROUND_Y)
    board = box((0.1, GROUND_Y - 1.6, 4.4), (0.5, GROUND_Y, 4.7))
    assert set(users_in([render(person, [*ROOM, board])] * 10)) == {1}
    behind = [
        render(person + standing_person(0.3 + 0.02 * max(index - 5, 0), 4.2, GROUND_Y), ROOM)
        for index in range(40)
    ]
    assert users_in(behind)[-1] == 2


def test_what_is_uncovered_is_watched_afresh_and_frames_that_hide_it_tell_nothing() -> None:
    depth_m = np.full((60, 60), 3.0, np.float32)
    columns = np.broadcast_to(np.arange(60), depth_m.shape)
    stillness = Stillness(depth_m, columns < 20, 0.0, LOOK_S)
    assert not stillness.has_grown(columns < 25)
    assert stillness.has_grown(columns < 50)
    watch(stillness, depth_m, range(1, 10))
    told = stillness.telling_looks
    assert told > 0
    watch(stillness, np.full_like(depth_m, 2.0), range(10, 15))
    assert stillness.telling_looks == told
    assert not stillness.is_broken
    watch(stillness, np.full_like(depth_m, 4.0), range(15, 15 + MOVED))
    assert stillness.is_broken


def test_a_piece_of_what_is_known_to_be_the_rooms_is_torn_out_of_it_and_a_person_is_not() -> None:
    """A cupboard is known but for where somebody stood; a person before it is before all of it."""
    cupboard = box((-0.8, GROUND_Y - 2.0, 4.2), (0.9, GROUND_Y, 4.6))
    person = standing_person(0.1, 3.0, GROUND_Y)
    for is_there in (False, True):
        depth_m = render(person if is_there else [], [*ROOM, cupboard])
        cloud = Cloud.from_frame(frame(with_noise(depth_m, 0)))
        is_body = (render(person) > 0.0)[:: cloud.stride, :: cloud.stride]
        scene = Scene.of(cloud, FloorPlane(UP, GROUND_Y), ~is_body, SceneSettings())
        body = np.where(is_body, np.float32(0.3), np.float32(np.inf))
        assert is_torn_out(scene, body) != is_there


def test_the_piece_of_a_cupboard_that_somebody_stood_before_is_nobody() -> None:
    recording = SimulatedRecording(scene_by_name("hug", seed=731, frames=75))
    finder = PeopleFinder()
    assert {len(finder.update(Pyramid(each))) for each in recording} == {2}


def test_who_was_near_may_have_left_the_pixels_free() -> None:
    depth_m = np.full((30, 12), 3.0, np.float32)
    left_m = depth_m.copy()
    left_m[:, :2] = 4.5
    stillness = Stillness(depth_m, np.ones(depth_m.shape, np.bool_), 0.0, LOOK_S)
    stillness.is_mixed = True
    watch(stillness, depth_m, range(1, FIRST))
    watch(stillness, left_m, range(FIRST, FIRST + 2 * MOVED))
    assert not stillness.has_left
