from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from people_scenes import (
    box,
    floor_normal,
    frame,
    head_of,
    plane,
    render,
    standing_person,
    with_noise,
)
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder
from topview.people.users import User

GROUND_Y = 1.1
FLOOR = plane(np.array([0.0, -1.0, 0.0]), GROUND_Y)
ROOM = [FLOOR, np.full_like(FLOOR, 5.5)]


def mask_of(user: User) -> NDArray[np.bool_]:
    mask = np.zeros((240, 320), np.bool_)
    mask.ravel()[user.pixels] = True
    return mask


def test_an_empty_image_holds_nobody() -> None:
    finder = PeopleFinder()
    for index in range(5):
        assert finder.update(Pyramid(frame(np.zeros((240, 320), np.float32), index))) == []


def test_a_room_with_box_table_and_chair_holds_nobody() -> None:
    chair = [
        box((0.5, 0.65, 2.4), (0.95, 0.70, 2.85)),
        box((0.5, 0.2, 2.80), (0.95, 0.65, 2.85)),
        *(
            box((x, 0.7, z), (x + 0.04, GROUND_Y, z + 0.04))
            for x in (0.5, 0.91)
            for z in (2.4, 2.81)
        ),
    ]
    furniture = [
        box((-1.2, 0.1, 3.0), (-0.8, GROUND_Y, 3.4)),
        box((-0.5, 0.35, 3.5), (0.4, 0.4, 4.2)),
        *chair,
    ]
    finder = PeopleFinder()
    for index in range(12):
        depth = with_noise(render([], [*ROOM, *furniture]), index)
        assert finder.update(Pyramid(frame(depth, index))) == []


@pytest.mark.parametrize("height_m", [1.25, 1.75, 1.95])
@pytest.mark.parametrize("z", [2.2, 3.6])
def test_one_person_is_found_at_once(height_m: float, z: float) -> None:
    balls = standing_person(0.2, z, GROUND_Y, height_m)
    depth = with_noise(render(balls, ROOM), 0)
    (user,) = PeopleFinder().update(Pyramid(frame(depth)))
    assert user.head_is_seen
    assert np.linalg.norm(user.head_camera - head_of(0.2, z, GROUND_Y, height_m)) < 0.08
    assert user.height_m == pytest.approx(height_m, abs=0.06)
    truth = render(balls) > 0.0
    truth &= np.abs(render(balls) - depth) < 0.1
    mask = mask_of(user)
    assert (mask & truth).sum() > 0.93 * truth.sum()
    assert (mask & truth).sum() > 0.95 * mask.sum()


def test_height_without_a_floor_comes_from_the_body() -> None:
    depth = with_noise(render(standing_person(0.0, 2.8, 0.85, 1.62)), 0)
    (user,) = PeopleFinder().update(Pyramid(frame(depth)))
    assert user.height_m == pytest.approx(1.62, abs=0.06)


def test_a_tilted_camera_changes_nothing_but_the_frame() -> None:
    tilt = np.radians(20)
    normal = floor_normal(tilt)
    # The camera turns down: points turn the other way about its x axis.
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    balls = [(turn @ c, r) for c, r in standing_person(0.1, 3.0, 1.8, 1.7)]
    depth = with_noise(render(balls, [plane(normal, 1.8)]), 3)
    (user,) = PeopleFinder().update(Pyramid(frame(depth)))
    assert np.linalg.norm(user.head_camera - turn @ head_of(0.1, 3.0, 1.8, 1.7)) < 0.08
    assert user.height_m == pytest.approx(1.7, abs=0.06)


def test_a_raised_hand_does_not_become_the_head() -> None:
    finder = PeopleFinder()
    truth = head_of(0.0, 2.8, GROUND_Y)
    for index in range(20):
        balls = standing_person(0.0, 2.8, GROUND_Y, right_hand_up=index >= 5)
        (user,) = finder.update(Pyramid(frame(with_noise(render(balls, ROOM), index), index)))
        assert np.linalg.norm(user.head_camera - truth) < 0.1
        top_row = (render(balls) > 0.0).any(1).argmax()
        assert mask_of(user).any(1).argmax() <= top_row + 2


def test_a_hand_that_hides_its_forearm_belongs_to_the_body_and_a_cupboard_does_not() -> None:
    body = standing_person(0.0, 2.8, GROUND_Y)
    hand = (np.array([0.16, -0.02, 2.35]), 0.06)
    cupboard = box((-0.9, 0.0, 2.2), (-0.2, GROUND_Y, 2.6))
    (user,) = PeopleFinder().update(Pyramid(frame(render([*body, hand], [*ROOM, cupboard]))))
    is_hand = render([hand]) > 0.0
    is_cupboard = np.isfinite(cupboard)
    assert (mask_of(user) & is_hand).sum() > 0.8 * is_hand.sum()
    assert (mask_of(user) & is_cupboard).sum() < 0.02 * is_cupboard.sum()


def crossing(index: int) -> tuple[float, float]:
    """x of the one in front and of the one behind."""
    return -1.1 + 0.045 * index, 0.8 - 0.03 * index


def test_two_who_cross_keep_their_ids() -> None:
    finder = PeopleFinder()
    ids: dict[str, set[int]] = {"front": set(), "back": set()}
    was_hidden = False
    for index in range(50):
        front_x, back_x = crossing(index)
        balls = standing_person(front_x, 2.3, GROUND_Y, 1.85)
        balls += standing_person(back_x, 3.3, GROUND_Y, 1.65)
        users = finder.update(Pyramid(frame(with_noise(render(balls, ROOM), index), index)))
        assert len(users) == 2
        assert users[0].head_camera[2] <= users[1].head_camera[2]
        was_hidden |= not users[1].head_is_seen
        for name, x, z, height in (("front", front_x, 2.3, 1.85), ("back", back_x, 3.3, 1.65)):
            truth = head_of(x, z, GROUND_Y, height)
            nearest = min(users, key=lambda user: float(np.linalg.norm(user.head_camera - truth)))
            ids[name].add(nearest.id)
            assert np.linalg.norm(nearest.head_camera - truth) < 0.35
    assert was_hidden
    assert len(ids["front"]) == len(ids["back"]) == 1
    assert ids["front"] != ids["back"]


def test_who_shows_but_a_part_behind_another_for_long_stays_the_same() -> None:
    """Longer than anybody is waited for of whom nothing is seen."""
    finder = PeopleFinder()
    hidden_s = 8.0
    xs = (*np.linspace(-1.0, 0.05, 30), *[0.05] * int(30 * hidden_s), *np.linspace(0.05, -1.0, 30))
    depths = {
        x: render(
            standing_person(x, 2.3, GROUND_Y, 1.9) + standing_person(0.2, 3.3, GROUND_Y, 1.7), ROOM
        )
        for x in set(xs)
    }
    unseen_frames = 0
    users: list[User] = []
    for index, x in enumerate(xs):
        users = finder.update(Pyramid(frame(with_noise(depths[x], index), index)))
        assert sorted(user.id for user in users) == [1, 2]
        unseen_frames += sum(not user.head_is_seen for user in users)
    assert unseen_frames > 30 * (hidden_s - 3.0)
    assert all(user.head_is_seen for user in users)


def test_who_stands_still_never_melts_into_the_room() -> None:
    finder = PeopleFinder()
    balls = standing_person(0.1, 2.8, GROUND_Y)
    sizes = []
    for index in range(60):
        (user,) = finder.update(Pyramid(frame(with_noise(render(balls, ROOM), index), index)))
        sizes.append(len(user.pixels))
    assert min(sizes) > 0.9 * max(sizes)


def test_who_comes_too_near_for_the_head_to_be_seen_stays_the_same() -> None:
    finder = PeopleFinder()
    users: list[User] = []
    way = (*np.linspace(3.0, 1.1, 40), *[1.1] * 180, *np.linspace(1.1, 3.0, 40))
    depths = {z: render(standing_person(0.0, z, GROUND_Y), ROOM) for z in way}
    for index, z in enumerate(way):
        users = finder.update(Pyramid(frame(with_noise(depths[z], index), index)))
        assert [user.id for user in users] == [1]
        assert len(users[0].pixels) > 500
    assert users[0].head_is_seen


def test_who_leaves_the_picture_is_forgotten_and_who_comes_is_new() -> None:
    finder = PeopleFinder()
    seen: list[list[int]] = []
    for index in range(90):
        x = 0.08 * index if index < 45 else 3.6 - 0.08 * (index - 45)
        balls = standing_person(x, 2.5, GROUND_Y)
        users = finder.update(Pyramid(frame(with_noise(render(balls, ROOM), index), index)))
        seen.append([user.id for user in users])
    assert seen[0] == [1]
    assert seen[44] == []
    assert seen[-1] == [2]


def test_the_same_frames_give_the_same_users() -> None:
    frames = []
    for index in range(8):
        balls = standing_person(-0.5 + 0.05 * index, 2.6, GROUND_Y)
        balls += standing_person(0.6, 3.0, GROUND_Y)
        frames.append(frame(with_noise(render(balls, ROOM), index), index))
    first, second = PeopleFinder(), PeopleFinder()
    for each in frames:
        for a, b in zip(first.update(Pyramid(each)), second.update(Pyramid(each)), strict=True):
            assert a.id == b.id
            np.testing.assert_array_equal(a.head_camera, b.head_camera)
            np.testing.assert_array_equal(a.pixels, b.pixels)
