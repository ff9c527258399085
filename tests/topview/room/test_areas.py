"""Where people are looked for."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressed_scenes import GROUND_Y, ROOM, scene_of
from people_scenes import CAMERA, frame, head_of, render, standing_person, with_noise
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder
from topview.people.settings import PeopleSettings
from topview.records import InputError
from topview.room.areas import HELP, Area, Areas, parse_areas

SCENE = scene_of(render([], ROOM), None, 0)
LEFT, RIGHT = (head_of(x, 3.0, GROUND_Y) for x in (-0.8, 0.8))
LEFT_HALF, LEFT_FLOOR = "0,0 158,0 158,239 0,239", "floor -2,1 0,4.5"
corners = st.lists(st.tuples(*[st.floats(-1e4, 1e4, allow_nan=False)] * 2), min_size=3, max_size=6)


@given(st.lists(corners, max_size=3))
def test_what_is_written_is_read(polygons: list[list[tuple[float, float]]]) -> None:
    text = ";".join(" ".join(f"{x!r},{y!r}" for x, y in polygon) for polygon in polygons)
    assert parse_areas(text, "region") == tuple(Area(tuple(polygon)) for polygon in polygons)
    boxes = ";".join(f" floor {p[0][0]!r},{p[0][1]!r}  {p[1][0]!r},{p[1][1]!r} " for p in polygons)
    assert parse_areas(boxes, "region") == tuple(Area(tuple(p[:2]), True) for p in polygons)


@pytest.mark.parametrize(
    "text",
    [
        "1,2 3,4", "1,2 3,4 5", "1,2 3,4 5,6,7", "a,b c,d e,f", "nan,0 1,1 2,0", "inf,0 1,1 2,0",
        "floor", "floor 1,2", "floor 1,2 3,4 5,6", "Floor 1,2 3,4", "0,0 1,0 1,1; 2,2",
    ],
)  # fmt: skip
@pytest.mark.parametrize("name", ["region", "ignore"])
def test_what_is_no_area_is_one_line_that_says_what_would_be(text: str, name: str) -> None:
    with pytest.raises(InputError, match="^" + re.escape(f"{name} is '{text}'; {HELP}") + "$"):
        parse_areas(text, name)


def test_a_polygon_holds_what_is_inside_of_it_in_the_image() -> None:
    areas = Areas.told(LEFT_HALF, "")
    assert areas.hold(SCENE, LEFT)
    assert not areas.hold(SCENE, RIGHT)
    is_looked_at = areas.looked_at(SCENE)
    assert is_looked_at is not None
    columns = np.arange(is_looked_at.shape[1]) * SCENE.cloud.stride
    np.testing.assert_array_equal(is_looked_at, np.tile(columns <= 158, (len(is_looked_at), 1)))
    ignored = Areas.told("", LEFT_HALF).looked_at(SCENE)
    np.testing.assert_array_equal(ignored, ~is_looked_at)
    triangle = Areas.told("0,0 319,0 0,239", "").looked_at(SCENE)
    assert triangle is not None
    assert triangle.mean() == pytest.approx(0.5, abs=0.02)


def test_a_box_on_the_floor_holds_what_is_over_it() -> None:
    areas = Areas.told(LEFT_FLOOR, "")
    assert areas.hold(SCENE, LEFT)
    assert areas.hold(SCENE, LEFT + np.array([0.0, 1.0, 0.0]))
    assert not areas.hold(SCENE, RIGHT)
    assert not areas.hold(SCENE, LEFT + np.array([0.0, 0.0, 2.0]))
    assert not areas.hold(SCENE, LEFT + np.array([-2.0, 0.0, 0.0]))
    assert Areas.told("floor 0,4.5 -2,1", "").hold(SCENE, LEFT)  # corners in any order


def test_of_many_areas_one_is_enough_and_what_is_ignored_is_in_none() -> None:
    both = Areas.told(f"{LEFT_FLOOR}; floor 0,1 2,4.5", "")
    assert both.hold(SCENE, LEFT)
    assert both.hold(SCENE, RIGHT)
    assert not Areas.told(LEFT_FLOOR, LEFT_HALF).hold(SCENE, LEFT)
    anywhere = Areas.told("", " ; ")
    assert anywhere == Areas()
    assert anywhere.hold(SCENE, LEFT)
    assert anywhere.looked_at(SCENE) is None


@pytest.mark.parametrize("area", [LEFT_HALF, LEFT_FLOOR])
def test_people_are_found_where_they_are_looked_for(area: str) -> None:
    balls = [ball for x in (-0.8, 0.8) for ball in standing_person(x, 3.0, GROUND_Y)]
    image = Pyramid(frame(with_noise(render(balls, ROOM), 0)))
    for areas, found in ((Areas.told(area, ""), LEFT), (Areas.told("", area), RIGHT)):
        (user,) = PeopleFinder(PeopleSettings(areas=areas)).update(image)
        assert np.linalg.norm(user.head_camera - found) < 0.1
        assert ((user.pixels % CAMERA.width < CAMERA.cx) == (found is LEFT)).all()
    assert len(PeopleFinder().update(image)) == 2
