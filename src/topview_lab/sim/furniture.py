"""What stands in rooms: chairs, tables and the like, made of boxes and cylinders.

Places are (x, y) in metres on the room's floor; headings turn a piece's front from x towards y.
"""

from __future__ import annotations

from math import cos, sin
from typing import Final

import numpy as np

from topview_lab.sim.appearance import Rgb
from topview_lab.sim.scene import Box, Cylinder, Furniture, Room

Place = tuple[float, float]

WOODS: Final[tuple[Rgb, ...]] = ((0.34, 0.20, 0.10), (0.20, 0.11, 0.06), (0.52, 0.40, 0.26))
FABRICS: Final[tuple[Rgb, ...]] = ((0.10, 0.14, 0.20), (0.22, 0.08, 0.07), (0.18, 0.20, 0.13))
CLAY: Final[Rgb] = (0.45, 0.22, 0.14)
LEAVES: Final[Rgb] = (0.06, 0.16, 0.04)

SEAT_SIDE_M: Final = 0.42
SEAT_THICKNESS_M: Final = 0.04
LEG_M: Final = 0.04


def _at(place: Place, heading_rad: float, front: float, left: float) -> Place:
    """A place before and to the left of another."""
    c, s = cos(heading_rad), sin(heading_rad)
    return place[0] + c * front - s * left, place[1] + s * front + c * left


def chair(place: Place, heading_rad: float, seat_m: float, color: Rgb) -> tuple[Furniture, ...]:
    """Seat, back and four legs; the place is the middle of the seat."""
    seat = Box(
        (*place, seat_m - SEAT_THICKNESS_M / 2),
        (SEAT_SIDE_M, SEAT_SIDE_M, SEAT_THICKNESS_M),
        color,
        heading_rad,
    )
    edge = SEAT_SIDE_M / 2 - LEG_M / 2
    behind = _at(place, heading_rad, -edge - LEG_M, 0.0)
    back = Box((*behind, seat_m + 0.22), (0.03, SEAT_SIDE_M, 0.44), color, heading_rad)
    legs = (
        Box(
            (*_at(place, heading_rad, front, left), (seat_m - SEAT_THICKNESS_M) / 2),
            (LEG_M, LEG_M, seat_m - SEAT_THICKNESS_M),
            color,
            heading_rad,
        )
        for front in (-edge, edge)
        for left in (-edge, edge)
    )
    return seat, back, *legs


def table(
    place: Place, size_m: tuple[float, float], height_m: float, color: Rgb
) -> tuple[Furniture, ...]:
    """A top of that breadth (x) and depth (y) on four legs."""
    width, depth = size_m
    legs = (
        Cylinder(
            (place[0] + x * (width / 2 - 0.06), place[1] + y * (depth / 2 - 0.06), 0.0),
            0.025,
            height_m - 0.04,
            color,
        )
        for x in (-1, 1)
        for y in (-1, 1)
    )
    return Box((*place, height_m - 0.02), (width, depth, 0.04), color), *legs


def sofa(place: Place, cloth: Rgb) -> tuple[Furniture, ...]:
    """A seat and a back, facing the camera."""
    x, y = place
    return (
        Box((x, y, 0.22), (1.30, 0.85, 0.44), cloth),
        Box((x, y + 0.35, 0.58), (1.30, 0.20, 0.40), cloth),
    )


def shelf(place: Place, height_m: float, wood: Rgb) -> tuple[Furniture, ...]:
    """A closed shelf."""
    return (Box((*place, height_m / 2), (0.90, 0.36, height_m), wood),)


def plant(place: Place, height_m: float) -> tuple[Furniture, ...]:
    """A pot with a bush."""
    return (
        Cylinder((*place, 0.0), 0.17, 0.34, CLAY),
        Cylinder((*place, 0.34), 0.12, max(height_m - 0.34, 0.01), LEAVES),
    )


def door(x: float, room: Room, wood: Rgb) -> tuple[Furniture, ...]:
    """A closed door in the far wall."""
    return (Box((x, room.far_wall_m - 0.02, 1.0), (0.90, 0.04, 2.0), wood),)


def living_room() -> tuple[Furniture, ...]:
    """A sofa, a shelf and a plant pot, out of the people's way."""
    return (
        *sofa((-2.05, 4.10), FABRICS[0]),
        *shelf((2.15, 4.45), 1.40, WOODS[0]),
        Cylinder((1.35, 4.30, 0.0), 0.17, 0.34, CLAY),
    )


def furnished(rng: np.random.Generator, room: Room) -> tuple[Furniture, ...]:
    """Furniture along the far wall of a room, differently each time."""

    def pick(colors: tuple[Rgb, ...]) -> Rgb:
        return colors[rng.integers(len(colors))]

    wall, side = room.far_wall_m, float(rng.choice([-1.0, 1.0]))
    pieces = [
        *shelf((side * rng.uniform(1.7, 2.2), wall - 0.20), rng.uniform(0.8, 2.0), pick(WOODS))
    ]
    if rng.random() < 0.6:
        pieces += sofa((-side * rng.uniform(1.7, 2.0), wall - 0.55), pick(FABRICS))
    if rng.random() < 0.7:
        pieces += plant((side * rng.uniform(0.9, 1.1), wall - 0.25), rng.uniform(0.5, 1.2))
    if rng.random() < 0.6:
        pieces += door(-side * rng.uniform(0.1, 0.6), room, pick(WOODS))
    return tuple(pieces)
