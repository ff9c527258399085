from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from people_scenes import floor_normal, frame, plane, render, standing_person, with_noise
from topview.detect.cloud import Cloud
from topview.room.floor import FloorSettings, FloorTracker, find_floor


@settings(max_examples=25)
@given(
    tilt_deg=st.floats(2, 30),
    roll_deg=st.floats(-5, 5),
    height_m=st.floats(0.6, 3.0),
    seed=st.integers(0, 1000),
)
def test_a_rendered_floor_is_recovered(
    tilt_deg: float, roll_deg: float, height_m: float, seed: int
) -> None:
    half_view_rad = np.arctan(120 / 285)
    assume(height_m / np.tan(np.radians(tilt_deg) + half_view_rad) < 3.5)  # else it is far away
    normal = floor_normal(np.radians(tilt_deg), np.radians(roll_deg))
    depth = with_noise(render([], [plane(normal, height_m)]), seed)
    floor = find_floor(Cloud.from_frame(frame(depth)), FloorSettings())
    assert floor is not None
    assert np.degrees(np.arccos(min(floor.normal_camera @ normal, 1.0))) < 1.5
    assert floor.distance_m == pytest.approx(height_m, abs=0.05)


def test_points_of_the_floor_have_height_zero() -> None:
    normal = floor_normal(np.radians(15))
    cloud = Cloud.from_frame(frame(render([], [plane(normal, 1.4)])))
    floor = find_floor(cloud, FloorSettings())
    assert floor is not None
    # The floor's far end is a depth edge, which the cloud's median filter moves.
    points = cloud.points_camera[cloud.depth_m > 0.0]
    points = points[points[:, 2] < 5.0]
    assert np.abs(floor.height_of(points)).max() < 0.02


def test_a_wall_a_person_and_nothing_have_no_floor() -> None:
    wall = np.full((240, 320), 3.0, np.float32)
    person = render(standing_person(0.0, 2.5, 0.9))
    for depth in (wall, person, np.zeros((240, 320), np.float32)):
        assert find_floor(Cloud.from_frame(frame(with_noise(depth, 1))), FloorSettings()) is None


def test_the_floor_is_kept_while_it_is_out_of_sight() -> None:
    tracker = FloorTracker()
    depth = render([], [plane(floor_normal(np.radians(10)), 1.2)])
    seen = tracker.update(Cloud.from_frame(frame(depth)))
    hidden = tracker.update(Cloud.from_frame(frame(np.full((240, 320), 0.8, np.float32), 1)))
    assert seen is not None
    assert hidden is seen


def test_a_large_table_is_no_floor_as_something_lies_below_it() -> None:
    up = floor_normal(np.radians(15))
    table, ground = plane(up, 0.85), plane(up, 1.6)
    beside_the_table = np.arange(320) < 100
    depth = with_noise(render([], [np.where(beside_the_table, ground, table)]), 2)
    floor = find_floor(Cloud.from_frame(frame(depth)), FloorSettings())
    assert floor is not None
    assert floor.distance_m == pytest.approx(1.6, abs=0.05)


def test_a_floor_that_is_measured_anew_is_followed_slowly() -> None:
    """So that one noisy frame moves nobody."""
    tracker = FloorTracker()
    up = floor_normal(np.radians(10))
    heights_m = [1.2] + [1.23] * 60
    found = []
    for index, height_m in enumerate(heights_m):
        depth = with_noise(render([], [plane(up, height_m)]), index)
        floor = tracker.update(Cloud.from_frame(frame(depth, index)))
        assert floor is not None
        found.append(floor.distance_m)
    assert found[1] == pytest.approx(found[0], abs=0.006)
    assert found[-1] == pytest.approx(1.23, abs=0.006)


def test_a_floor_that_is_out_of_sight_for_seconds_is_forgotten() -> None:
    """The camera may have been moved."""
    tracker = FloorTracker()
    depth = render([], [plane(floor_normal(np.radians(10)), 1.2)])
    wall = np.full((240, 320), 0.8, np.float32)
    found = [
        tracker.update(Cloud.from_frame(frame(seen, index)))
        for index, seen in enumerate([depth] + [wall] * 120)
    ]
    assert found[30] is found[0]
    assert found[-1] is None
