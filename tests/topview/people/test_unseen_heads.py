"""Where heads are that are not seen, and what tells a head from a shoulder or an arm."""

from __future__ import annotations

import numpy as np
import pytest
from dressed_scenes import BLUE, GROUND_Y, RED, ROOM, UP, Rgb, dressed, scene_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from people_scenes import Ball, box, head_of, limb, render, standing_person

from topview.detect.head_colors import HeadColors
from topview.detect.head_template import HeadTemplate, track_head
from topview.detect.heads import HeadCandidate
from topview.people.doubts import (
    ALIKE,
    UNLIKE,
    has_come,
    is_no_head,
    is_unlike,
    likeness,
    slips,
)
from topview.people.identity import KnownUser
from topview.people.looks import colors_of_head, learn_heads
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.segmentation import body_distance
from topview.people.settings import PeopleSettings
from topview.people.unseen import FOUND, miss

SKIN, HAIR = (200, 150, 120), (50, 40, 30)
STATURE_M = 1.75
Distance = NDArray[np.float32]


def head_and_body(x: float, z: float, head: Rgb, body: Rgb) -> list[tuple[list[Ball], Rgb]]:
    """What has one colour each: the head, and all below it."""
    balls, chin_y = standing_person(x, z, GROUND_Y), GROUND_Y - 0.86 * STATURE_M
    return [
        ([ball for ball in balls if ball[0][1] < chin_y], head),
        ([ball for ball in balls if ball[0][1] >= chin_y], body),
    ]


def colored_scene(parts: list[tuple[list[Ball], Rgb]], index: int = 0) -> Scene:
    return scene_of(*dressed(parts), index)


def body_at(scene: Scene, head_camera: NDArray[np.float64]) -> Distance:
    return body_distance(scene, head_camera, STATURE_M, PeopleSettings().segmentation)


def known(scene: Scene, place: NDArray[np.float64], number: int = 1) -> KnownUser:
    user = KnownUser(
        number, HeadCandidate(place, 0.9), HeadTemplate.of(scene.cloud, place), scene.time_s
    )
    user.height.add(STATURE_M, scene.time_s)
    return user


def roll_of(scene: Scene, *users: KnownUser) -> Roll:
    """With their bodies, as they are in this scene."""
    roll = Roll(PeopleSettings(), list(users), [body_at(scene, u.head_camera) for u in users])
    roll.remember(scene, [np.isfinite(body) for body in roll.bodies])
    return roll


def colors_at(scene: Scene, place: NDArray[np.float64]) -> HeadColors:
    colors = HeadColors.of(scene.cloud, place, body_at(scene, place))
    assert colors is not None
    return colors


# What colours tell


def test_a_head_has_its_own_colours_and_the_chest_has_not() -> None:
    scene, head = colored_scene(head_and_body(0.0, 2.5, SKIN, RED)), head_of(0.0, 2.5, GROUND_Y)
    colors = colors_at(scene, head)
    for down_m, (least, most) in ((0.0, (0.9, 1.0)), (0.45, (0.0, 0.1))):
        share = colors.share_at(scene.cloud, head - down_m * UP)
        assert share is not None
        assert least <= share <= most
    wall = colors.share_at(scene.cloud, head + np.array([1.0, 0.0, 0.0]))
    assert wall == pytest.approx(0.5)  # too far behind to be a head's


def test_colours_that_head_and_clothes_share_tell_nothing() -> None:
    scene, head = colored_scene(head_and_body(0.0, 2.5, RED, RED)), head_of(0.0, 2.5, GROUND_Y)
    assert colors_at(scene, head).share_at(scene.cloud, head) == pytest.approx(0.5, abs=0.1)


def test_there_are_no_head_colours_without_colour_or_body() -> None:
    head = head_of(0.0, 2.5, GROUND_Y)
    grey = scene_of(render(standing_person(0.0, 2.5, GROUND_Y), ROOM), None, 0)
    assert HeadColors.of(grey.cloud, head, body_at(grey, head)) is None
    scene = colored_scene(head_and_body(0.0, 2.5, SKIN, RED))
    nothing = np.full(scene.cloud.depth_m.shape, np.inf, np.float32)
    assert HeadColors.of(scene.cloud, head, nothing) is None
    assert colors_at(scene, head).share_at(grey.cloud, head) is None


def test_anothers_head_of_the_same_colours_is_not_told_apart() -> None:
    scene = colored_scene(head_and_body(-0.6, 2.5, SKIN, RED) + head_and_body(0.6, 2.5, SKIN, BLUE))
    left, right = (head_of(x, 2.5, GROUND_Y) for x in (-0.6, 0.6))
    own, others = colors_at(scene, left), colors_at(scene, right)
    alone = own.share_at(scene.cloud, right)
    against = own.against([others]).share_at(scene.cloud, right)
    assert alone is not None
    assert against is not None
    assert alone > 0.9
    assert against == pytest.approx(0.5, abs=0.1)
    assert own.against([]) is own


@settings(max_examples=20)
@given(st.integers(1, 60))
def test_new_colours_are_learnt_by_and_by(times: int) -> None:
    head = head_of(0.0, 2.5, GROUND_Y)
    before = colors_at(colored_scene(head_and_body(0.0, 2.5, SKIN, RED)), head)
    now = colors_at(colored_scene(head_and_body(0.0, 2.5, HAIR, RED)), head)
    learnt = before
    for _ in range(times):
        learnt = learnt.learn(now)
    assert float(learnt.head.sum()) == pytest.approx(1.0, abs=0.05)
    off = np.abs(learnt.head - now.head).sum() / np.abs(before.head - now.head).sum()
    assert off == pytest.approx(0.8**times, abs=1e-3)


@pytest.mark.parametrize("sees_color", [False, True])
def test_of_two_that_look_alike_the_one_of_the_heads_colours_is_followed(sees_color: bool) -> None:
    """A raised ball like a head, nearer to where the head is expected than the head is."""
    z = 2.5
    place = head_of(0.0, z, GROUND_Y)
    seen = colored_scene(head_and_body(0.0, z, HAIR, RED))
    view, colors = HeadTemplate.of(seen.cloud, place), colors_at(seen, place)
    head, ball = place + np.array([0.13, 0.0, 0.0]), place - np.array([0.1, 0.0, 0.0])
    parts = [([(head, 0.11)], HAIR), ([(ball, 0.11)], RED)]
    scene = colored_scene(parts, 1)
    found = track_head(scene.cloud, view, place, UP, 1 / 30, colors if sees_color else None)
    assert found is not None
    chosen = head if sees_color else ball
    assert np.linalg.norm((found.center_camera - chosen)[:2]) < 0.07


def test_the_colours_of_a_bent_or_unsure_head_are_not_learnt() -> None:
    scene, head = colored_scene(head_and_body(0.0, 2.5, SKIN, RED)), head_of(0.0, 2.5, GROUND_Y)
    for confidence, stature_m, is_learnt in (
        (0.9, STATURE_M, True), (0.5, STATURE_M, False), (0.9, STATURE_M + 0.3, False)
    ):  # fmt: skip
        user = known(scene, head)
        user.confidence_now, user.height.height_m = confidence, stature_m
        roll = roll_of(scene, user)
        learn_heads(roll, scene)
        assert (user.head_colors is not None) == is_learnt
        assert (colors_of_head(roll, scene, user) is not None) == is_learnt


def test_a_head_is_where_the_body_has_its_colours() -> None:
    scene, head = colored_scene(head_and_body(0.0, 2.5, SKIN, RED)), head_of(0.0, 2.5, GROUND_Y)
    colors, is_body = colors_at(scene, head), np.isfinite(body_at(scene, head))
    near = head + 0.3 * np.array([0.0, 1.0, 0.0])
    found = colors.place_in(scene.cloud, is_body, near, 0.4)
    assert found is not None
    place, share = found
    assert np.linalg.norm(place - head) < 0.1
    assert 0.7 < share < 0.9  # a disc fills 0.79 of a window as broad
    assert colors.place_in(scene.cloud, np.zeros_like(is_body), near, 0.4) is None
    assert colors.place_in(scene.cloud, is_body, near + np.array([1.0, 0.0, 0.0]), 0.4) is None
    headless = colored_scene(head_and_body(0.0, 2.5, RED, RED))
    nowhere = colors.place_in(headless.cloud, is_body, near, 0.4)
    assert nowhere is not None
    assert nowhere[1] < 0.1


def test_a_hand_of_the_heads_colour_is_not_taken_for_it() -> None:
    """It is as near, but not as broad."""
    z = 2.5
    colors = colors_at(colored_scene(head_and_body(0.0, z, SKIN, RED)), head_of(0.0, z, GROUND_Y))
    chest = np.array([0.0, GROUND_Y - 1.0, z - 0.1])
    bent, hand = chest + np.array([-0.2, 0.0, -0.1]), chest + np.array([0.2, 0.0, -0.1])
    trunk = limb((0.0, GROUND_Y - 1.3, z), (0.0, GROUND_Y - 0.7, z), 0.15)
    for has_head in (False, True):
        skin = [(hand, 0.05), *([(bent, 0.1)] if has_head else [])]
        scene = colored_scene([(skin, SKIN), (trunk, RED)])
        is_body = (scene.cloud.depth_m > 0.0) & (scene.cloud.depth_m < 3.0)
        found = colors.place_in(scene.cloud, is_body, chest, 0.4)
        assert found is not None
        assert (found[1] > FOUND) == has_head
        assert (np.linalg.norm(found[0] - bent) < 0.1) == has_head


# Where a head is that is not seen


def test_a_head_that_is_not_seen_goes_where_the_trunk_goes() -> None:
    """He walks on behind somebody's arm; where he was expected there is nobody."""
    z = 3.0
    truth = head_of(0.5, z, GROUND_Y)
    arm = box((-0.4, truth[1] - 0.2, 2.0), (1.0, truth[1] + 0.15, 2.1))
    scene = scene_of(render(standing_person(0.5, z, GROUND_Y), [*ROOM, arm]), None, 1)
    user = known(scene, truth)
    roll = roll_of(scene, user)
    user.head_camera = truth - np.array([0.5, 0.0, 0.0])
    user.time_s = user.seen_s = scene.time_s - 1 / 30
    body = miss(roll, scene, user)
    assert np.isfinite(body).any()
    assert np.linalg.norm(user.head_camera - truth) < 0.2
    assert user.confidence_now == 0.0


def test_a_stretched_arm_is_no_trunk() -> None:
    """Only the arm is seen of one who stands behind a pillar: his head stays where it was."""
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    pillar = box((-0.35, GROUND_Y - 2.3, 1.8), (0.35, GROUND_Y, 2.0))
    shoulder_y = GROUND_Y - 0.8 * STATURE_M
    balls = standing_person(0.0, z, GROUND_Y)
    balls += limb((0.2, shoulder_y, z), (0.95, shoulder_y, z), 0.05)
    bare = scene_of(render(balls, ROOM), None, 0)
    scene = scene_of(render(balls, [*ROOM, pillar]), None, 1)
    user = known(bare, truth)
    roll = roll_of(bare, user)
    body = miss(roll, scene, user)
    assert np.count_nonzero(np.isfinite(body)) > 50
    assert np.linalg.norm(user.head_camera - truth) < 0.1


@pytest.mark.parametrize(
    ("is_alone", "sees_color", "off_m"),
    [(False, True, 0.2), (True, True, 0.1), (True, False, 0.2)],
)
def test_the_head_of_one_who_is_alone_is_sought_by_its_colours_or_at_the_bodys_top(
    is_alone: bool, sees_color: bool, off_m: float
) -> None:
    """He bent down while he was lost in view; somebody near by might hide the head, though."""
    z = 2.5
    place = head_of(0.0, z, GROUND_Y)
    before = colored_scene(head_and_body(0.0, z, HAIR, RED))
    user = known(before, place)
    user.head_colors = colors_at(before, place) if sees_color else None
    bent = np.array([0.0, GROUND_Y - 0.9, z - 0.3])
    trunk = limb((0.0, GROUND_Y - 0.85, z), (0.0, GROUND_Y - 1.0, z - 0.2), 0.13)
    legs = limb((0.0, GROUND_Y - 0.8, z), (0.0, GROUND_Y - 0.1, z), 0.1)
    scene = colored_scene([([(bent, 0.11)], HAIR), (trunk + legs, RED)], 10)
    other = known(scene, place + np.array([3.0 if is_alone else 1.0, 0.0, 0.0]), 2)
    roll = roll_of(scene, user, other)
    roll.bodies[0] = body_at(scene, bent)
    roll.remember(scene, [np.isfinite(body) for body in roll.bodies])
    user.head_camera = bent + np.array([0.0, -0.3, 0.1])
    miss(roll, scene, user)
    assert (np.linalg.norm(user.head_camera - bent) < off_m) == is_alone


@pytest.mark.parametrize("sees_color", [False, True])
def test_a_head_that_sinks_under_cover_is_a_shoulder_unless_it_has_the_colours(
    sees_color: bool,
) -> None:
    z = 3.0
    truth = head_of(0.0, z, GROUND_Y)
    arm = box((-0.6, truth[1] - 0.2, 2.0), (0.6, truth[1] + 0.1, 2.1))
    low = truth - 0.25 * UP
    parts = [([(low, 0.11)], HAIR), (standing_person(0.0, z, GROUND_Y), RED)]
    before = colored_scene(head_and_body(0.0, z, HAIR, RED))
    user = known(before, truth)
    if sees_color:
        user.head_colors = colors_at(before, truth)
    depth_m = render([ball for balls, _ in parts for ball in balls], [*ROOM, arm])
    color = np.full((*depth_m.shape, 3), HAIR, np.uint8)
    scene = scene_of(depth_m, color, 1)
    assert slips(scene, user, HeadCandidate(low, 0.9)) != sees_color
    assert (likeness(scene, user, HeadCandidate(low, 0.9)) > ALIKE) == sees_color


@pytest.mark.parametrize(("down_m", "is_none"), [(0.0, False), (0.45, True)])
def test_what_is_below_the_stature_and_of_the_clothes_colours_is_no_head(
    down_m: float, is_none: bool
) -> None:
    """A chest is none, even if nothing covers the head; without colour nobody knows."""
    scene, place = colored_scene(head_and_body(0.0, 2.5, SKIN, RED)), head_of(0.0, 2.5, GROUND_Y)
    user = known(scene, place)
    head = HeadCandidate(place - down_m * UP, 0.95)
    assert not is_no_head(scene, user, head)
    user.head_colors = colors_at(scene, place)
    assert is_no_head(scene, user, head) == is_none


def test_nobody_comes_back_from_behind_somebody_taller_or_with_other_colours() -> None:
    z = 3.0
    place = head_of(0.0, z, GROUND_Y)
    scene = colored_scene(head_and_body(0.0, z, SKIN, RED), 5)
    user = known(scene, place)
    user.head_colors = colors_at(scene, place)
    head, chest, fist = (HeadCandidate(place + up_m * UP, 0.9) for up_m in (0.0, -0.45, 0.2))
    assert likeness(scene, user, chest) < UNLIKE
    assert not any(is_unlike(scene, user, each) for each in (head, chest, fist))  # nothing hides it
    user.head_camera = place + np.array([0.0, 0.0, 1.0])  # what is seen there would
    assert not is_unlike(scene, user, head)
    assert is_unlike(scene, user, chest)
    assert is_unlike(scene, user, fist)


def test_who_came_across_the_floor_is_there_though_the_head_is_hidden() -> None:
    scene = scene_of(render(standing_person(0.0, 2.6, GROUND_Y), ROOM), None, 30)
    user = known(scene, head_of(0.0, 2.6, GROUND_Y))
    user.seen_s = scene.time_s - 0.2
    assert not has_come(scene, user)
    user.first_camera = user.seen_camera + 0.4 * UP  # slid down, as a shoulder may
    assert not has_come(scene, user)
    user.first_camera = user.seen_camera + np.array([0.3, 0.0, 0.0])
    assert has_come(scene, user)
    user.seen_s = scene.time_s - 1.0
    assert not has_come(scene, user)
