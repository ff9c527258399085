"""Where people walk: smooth paths through the room, with a turn before and after."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from topview.records import InputError
from topview_lab.sim.actions.style import smooth_step

TURN_S: Final = 0.7
"""How long a person takes to turn on the spot (ours)."""
SPEED_UP_S: Final = 0.7
"""How long a person takes to reach walking speed (ours)."""
COMFORTABLE_MPS: Final = 1.25
"""A comfortable walking speed (Winter 2009, Ch. 5)."""


@dataclass(frozen=True, slots=True)
class Path:
    """A walk through the room, with a turn before it and after it.

    Attributes:
        points_room: waypoints (x, y) in metres; one alone for a person who stays.
        start_s: when the person starts to walk.
        speed_mps: on the way.
        heading_before_rad, heading_after_rad: where the person looks before and afterwards.
    """

    points_room: tuple[tuple[float, float], ...]
    heading_before_rad: float
    heading_after_rad: float
    start_s: float = 0.0
    speed_mps: float = COMFORTABLE_MPS

    def __post_init__(self) -> None:
        if not self.points_room or self.speed_mps <= 0.0:
            raise InputError(
                f"a path has {len(self.points_room)} points and a speed of {self.speed_mps} m/s; "
                "it must have a point at least and a speed above 0"
            )

    def state_at(self, time_s: float) -> PathState:
        """Place, heading, distance and speed at a time."""
        if len(self.points_room) == 1:
            return PathState(
                np.array(self.points_room[0]), self.heading_before_rad, 0.0, 0.0, self.speed_mps
            )
        curve = _curve(self.points_room)
        length = float(curve.x[-1])
        speed = min(self.speed_mps, length / SPEED_UP_S)
        duration = length / speed + SPEED_UP_S
        t = min(max(time_s - self.start_s, 0.0), duration)
        distance = speed * (_ramped(t) - _ramped(t - (duration - SPEED_UP_S)))
        pace = smooth_step(t / SPEED_UP_S) - smooth_step((t - duration) / SPEED_UP_S + 1.0)
        dx, dy = curve(min(distance, length), 1)
        before = smooth_step((time_s - self.start_s) / TURN_S + 0.6)
        after = smooth_step((time_s - self.start_s - duration) / TURN_S + 0.6)
        along = np.arctan2(dy, dx)
        turns = (
            (_turn(self.heading_before_rad, along), before),
            (_turn(along, self.heading_after_rad), after),
        )
        return PathState(
            position_room=curve(min(distance, length)),
            heading_rad=self.heading_before_rad + float(sum(turn * done for turn, done in turns)),
            distance_m=distance,
            pace=float(pace),
            speed_mps=self.speed_mps,
            turn=turns[0] if after == 0.0 else turns[1],
        )


@dataclass(frozen=True, slots=True, eq=False)
class PathState:
    """A moment on a path.

    Attributes:
        position_room: [2] metres.
        heading_rad: of the front.
        distance_m: walked so far.
        pace: 0 while standing, 1 at full walking speed.
        speed_mps: at pace 1.
        turn: the present or last turn on the spot: its angle in radians, and its progress 0 to 1.
    """

    position_room: NDArray[np.float64]
    heading_rad: float
    distance_m: float
    pace: float
    speed_mps: float
    turn: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Route:
    """Several walks, one after the other, each from where the last one ended."""

    legs: tuple[Path, ...]

    def __post_init__(self) -> None:
        if not self.legs:
            raise InputError("a route has no legs; it must have one at least")

    def state_at(self, time_s: float) -> PathState:
        """As `Path.walked`, on the leg that is on or was the last."""
        begun = [leg for leg in self.legs if leg.start_s - TURN_S <= time_s]
        return (begun[-1] if begun else self.legs[0]).state_at(time_s)


@lru_cache(maxsize=64)  # each of somebody's path, of which a whole recording asks
def _curve(points_room: tuple[tuple[float, float], ...]) -> CubicSpline:
    """Smooth through the points, by the length of the straight lines between them."""
    points = np.array(points_room)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return CubicSpline(np.append(0.0, np.cumsum(steps)), points, bc_type="natural")


def _ramped(t: float) -> float:
    """Seconds at full speed that cover the same distance as t seconds with a smooth start."""
    if t <= 0.0:
        return 0.0
    if t >= SPEED_UP_S:
        return t - 0.5 * SPEED_UP_S
    x = t / SPEED_UP_S
    return SPEED_UP_S * (x**3 - 0.5 * x**4)


def _turn(from_rad: float, to_rad: float) -> float:
    """The signed angle from one heading to another, the shorter way round."""
    return (to_rad - from_rad + np.pi) % (2.0 * np.pi) - np.pi
