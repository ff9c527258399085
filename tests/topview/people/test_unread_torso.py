"""People whose torso has no reading, and what only looks like them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from people_scenes import (
    Ball,
    box,
    floor_normal,
    frame,
    head_of,
    limb,
    plane,
    render,
    standing_person,
    with_noise,
)
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder

GROUND_Y = 1.1
FLOOR = plane(floor_normal(0.0), GROUND_Y)
WALL = np.full_like(FLOOR, 5.5)
HEIGHT_M, Z = 1.75, 3.0


def is_torso(balls: list[Ball]) -> NDArray[np.bool_]:
    """[H, W] what a body shows between chin and hips."""
    rows = np.arange(240)[:, None]
    top, bottom = (int((GROUND_Y - share * HEIGHT_M) / Z * 285.0 + 119.5) for share in (0.85, 0.52))
    return (render(balls) > 0.0) & (top < rows) & (rows < bottom)


def in_black(balls: list[Ball], surfaces: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    depth = with_noise(render(balls, surfaces), 0)
    depth[is_torso(balls)] = 0.0
    return depth


@pytest.mark.parametrize("surfaces", [[], [FLOOR], [FLOOR, WALL]])
def test_a_person_whose_torso_has_no_reading_is_found_and_kept(
    surfaces: list[NDArray[np.float32]],
) -> None:
    finder = PeopleFinder()
    for index in range(6):
        x = 0.2 + 0.03 * index
        balls = standing_person(x, Z, GROUND_Y, HEIGHT_M)
        depth = in_black(balls, surfaces)
        (user,) = finder.update(Pyramid(frame(depth, index)))
        assert user.id == 1
        assert user.head_is_seen
        assert np.linalg.norm(user.head_camera - head_of(x, Z, GROUND_Y, HEIGHT_M)) < 0.08
        assert user.height_m == pytest.approx(HEIGHT_M, abs=0.06)
        is_legs = (render(balls) > 0.0) & (np.abs(render(balls) - depth) < 0.1)
        is_legs &= (np.arange(240) > 150)[:, None]
        mask = np.zeros((240, 320), np.bool_)
        mask.ravel()[user.pixels] = True
        assert (mask & is_legs).sum() > 0.9 * is_legs.sum()


def test_a_head_over_legs_with_a_wall_seen_between_them_is_nobody() -> None:
    balls = standing_person(0.2, Z, GROUND_Y, HEIGHT_M)
    depth = with_noise(render(balls, [FLOOR, WALL]), 0)
    depth[is_torso(balls)] = 5.5
    assert PeopleFinder().update(Pyramid(frame(depth))) == []


LAMP: list[Ball] = [(np.array([0.0, GROUND_Y - 1.6, Z]), 0.11)]
BENCH = box((-0.6, GROUND_Y - 0.45, Z - 0.2), (0.6, GROUND_Y, Z + 0.2))
CUPBOARD = box((-0.22, GROUND_Y - 0.9, Z - 0.2), (0.22, GROUND_Y, Z + 0.2))
TABLE = [
    box((-0.5, GROUND_Y - 0.75, Z - 0.3), (0.5, GROUND_Y - 0.7, Z + 0.3)),
    *(box((x, GROUND_Y - 0.7, Z - 0.02), (x + 0.05, GROUND_Y, Z + 0.02)) for x in (-0.45, 0.4)),
]
POLE = limb((0.0, GROUND_Y - 0.85, Z), (0.0, GROUND_Y, Z), 0.02)


@pytest.mark.parametrize("surfaces", [[], [FLOOR]])
@pytest.mark.parametrize(
    ("balls", "furniture"),
    [(LAMP, []), (LAMP, [BENCH]), (LAMP, [CUPBOARD]), (LAMP, TABLE), (LAMP + POLE, [])],
    ids=["alone", "bench", "cupboard", "table", "pole"],
)
def test_a_lamp_or_plant_is_nobody(
    balls: list[Ball],
    furniture: list[NDArray[np.float32]],
    surfaces: list[NDArray[np.float32]],
) -> None:
    finder = PeopleFinder()
    for index in range(6):
        depth = with_noise(render(balls, [*surfaces, *furniture]), index)
        assert finder.update(Pyramid(frame(depth, index))) == []
