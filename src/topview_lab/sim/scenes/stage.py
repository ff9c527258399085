"""Building blocks of scenes: people drawn from a seed, places, chairs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import atan2, cos, radians, sin
from typing import Final

import numpy as np

from topview_lab.sim.actions import Style
from topview_lab.sim.actions.sitting_kneeling import SEAT_BACK, SEAT_FLESH
from topview_lab.sim.appearance import CLOTHS, Appearance, Rgb, Sex, random_appearance
from topview_lab.sim.bodies import Body, build_body
from topview_lab.sim.furniture import WOODS, chair
from topview_lab.sim.motions import Clip, Performance
from topview_lab.sim.paths import Path, Route
from topview_lab.sim.scene import Actor, Furniture, Mount, Room
from topview_lab.sim.skeleton import Pose

TO_CAMERA: Final = radians(-90)
TO_RIGHT: Final = 0.0
TO_LEFT: Final = radians(180)
TO_WALL: Final = radians(90)
FOREVER_S: Final = 1e4
EASY_RAMP_S: Final = 0.8
"""Duration of fading actions in and out in the longer scenes (ours)."""
SETTLE_S: Final = 0.5
"""Time that people stand before they act, as in Berkeley MHAD."""


@dataclass(frozen=True, slots=True)
class Staging:
    """The people of a scene, and the furniture that they use."""

    actors: list[Actor]
    furniture: tuple[Furniture, ...] = ()


class Casting:
    """Draws people from a scene's random numbers, each in a shirt of another colour.

    Looks that are given are taken first, in their order.
    """

    def __init__(self, rng: np.random.Generator, appearances: Sequence[Appearance] = ()) -> None:
        self.rng = rng
        self._looks = list(appearances)
        self._shirts = [CLOTHS[k] for k in rng.permutation(len(CLOTHS))]

    def actor(
        self, path: Path | Route, clips: tuple[Clip, ...] = (), sex: Sex | None = None
    ) -> Actor:
        """A new person who walks a path and acts."""
        appearance = random_appearance(self.rng, sex, self._shirts.pop())
        if self._looks:
            appearance = self._looks.pop(0)
        return Actor(build_body(appearance), Performance(path, clips, Style.sample(self.rng)))


Cast = Callable[[Casting], Staging]


@dataclass(frozen=True, slots=True)
class SceneKind:
    """A scene that has a name.

    Attributes:
        about: one line that says what happens.
        cast: who is in it.
        frames: its default length.
        group: under which it is listed.
        has_varied_room: whether furniture, walls and camera differ with the seed.
    """

    about: str
    cast: Cast
    frames: int = 120
    group: str = "one person"
    has_varied_room: bool = True


def stands(x: float, y: float, heading_rad: float = TO_CAMERA) -> Path:
    """Stays there."""
    return Path(((x, y),), heading_rad, heading_rad)


def clip(action: str, start_s: float, end_s: float = FOREVER_S, **more: object) -> Clip:
    """A clip with slow fading that lasts as long as the recording by default."""
    return replace(Clip(action, start_s, end_s, ramp_s=EASY_RAMP_S), **more)


def chair_of(actor: Actor, seat_m: float, color: Rgb = WOODS[0]) -> tuple[Furniture, ...]:
    """The chair behind somebody who is going to sit down."""
    place = actor.performance.path.state_at(0.0)
    x, y = place.position_room
    back = SEAT_BACK * actor.body.appearance.stature_m
    h = place.heading_rad
    return chair((float(x) - back * cos(h), float(y) - back * sin(h)), h, seat_m, color)


def seat_under(body: Body, pose: Pose) -> float:
    """How high the seat is that somebody sits on who is in this pose, metres."""
    return float(pose.root_room[2]) - SEAT_FLESH * body.appearance.stature_m


def varied_room(rng: np.random.Generator) -> tuple[Room, Mount]:
    """A room and a camera in it that sees people who stand about 3 m away."""
    height_m = rng.uniform(0.9, 1.6)
    tilt_rad = atan2(height_m - CAMERA_AIM_M[1], CAMERA_AIM_M[0]) + radians(rng.uniform(-1.0, 1.0))
    tone = rng.uniform(0.85, 1.15)
    room = Room(
        far_wall_m=rng.uniform(4.6, 5.3),
        walls=(0.56 * tone, 0.56 * tone, 0.52 * rng.uniform(0.85, 1.15)),
    )
    return room, Mount(height_m, tilt_rad)


CAMERA_AIM_M: Final = (3.0, 1.0)
"""The camera looks at a point so far away and so high (ours)."""
