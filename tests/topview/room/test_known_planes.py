"""The room that was not seen yet: a wall goes on where somebody stood."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.room.background import KNOWN_S, Background

SHAPE = 60, 80
BEFORE_WALL_M = 0.3

Depth = NDArray[np.float32]


def wall(slant: float = 0.002, tilt: float = -0.001) -> Depth:
    """A plane: inverse depth is linear in the image."""
    rows, columns = np.indices(SHAPE)
    return (1.0 / (0.25 + slant * columns / 10.0 + tilt * rows / 10.0)).astype(np.float32)


def where_somebody_stood() -> NDArray[np.bool_]:
    stood = np.zeros(SHAPE, np.bool_)
    stood[15:, 30:50] = True
    return stood


def learnt(depth_m: Depth) -> Background:
    """The room round somebody."""
    background, stood = Background(), where_somebody_stood()
    with_person = np.where(stood, depth_m - 1.5, depth_m).astype(np.float32)
    for time_s in np.arange(0.0, 2.0 * KNOWN_S, 0.1):
        background.update(with_person, stood, time_s)
    return background


def test_a_wall_goes_on_behind_whoever_leaves() -> None:
    depth_m = wall()
    assert learnt(depth_m).is_seen_in(depth_m).all()


def test_what_stands_before_the_wall_is_not_the_wall() -> None:
    depth_m = wall()
    background, stood = learnt(depth_m), where_somebody_stood()
    seen = background.is_seen_in(np.where(stood, depth_m - BEFORE_WALL_M, depth_m))
    np.testing.assert_array_equal(seen, ~stood)
    nothing_read = background.is_seen_in(np.where(stood, np.float32(0.0), depth_m))
    np.testing.assert_array_equal(nothing_read, ~stood)


def test_who_stands_on_a_plane_keeps_their_feet() -> None:
    floor_m = wall()
    background, stood = learnt(floor_m), where_somebody_stood()
    on_floor_m = np.where(stood, floor_m - 0.02, floor_m).astype(np.float32)
    background.update(on_floor_m, stood, 2.0 * KNOWN_S + 0.1)
    np.testing.assert_array_equal(background.is_seen_in(on_floor_m), ~stood)
    background.update(on_floor_m, np.zeros_like(stood), 2.0 * KNOWN_S + 0.2)
    assert background.is_seen_in(on_floor_m).all()


def test_what_is_not_flat_does_not_go_on() -> None:
    rows, columns = np.indices(SHAPE)
    heap_m = (4.0 - 0.3 * np.cos(columns / 4.0) - 0.3 * np.cos(rows / 4.0)).astype(np.float32)
    flat_m = np.where(where_somebody_stood(), np.float32(4.0), heap_m)
    seen = learnt(heap_m).is_seen_in(flat_m)
    assert seen[where_somebody_stood()].mean() < 0.35


def test_two_planes_go_on_to_where_they_meet() -> None:
    corner_m = np.minimum(wall(0.02, 0.0), wall(-0.015, 0.0)[:, ::-1])
    assert learnt(corner_m).is_seen_in(corner_m).all()
