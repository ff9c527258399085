"""The scenes that have a name: who is in the room, and what they do."""

from __future__ import annotations

from collections.abc import Callable
from math import radians
from typing import Final

import numpy as np

from topview.records import Camera, InputError
from topview.sim.actions import ActionName, Style
from topview.sim.bodies import build_body
from topview.sim.looks import CLOTHS, Sex, random_look
from topview.sim.motions import Clip, Performance
from topview.sim.paths import Path
from topview.sim.scene import MAX_PEOPLE, Actor, Box, Cylinder, Furniture, Mount, Room, Scene

KINECT_V1_HALF: Final = Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=320, height=240)
"""Nominal intrinsics (525 px at 640 x 480) at half resolution."""

TO_CAMERA: Final = radians(-90)
TO_RIGHT: Final = 0.0


def _living_room() -> tuple[Furniture, ...]:
    """A sofa, a shelf, a side table and a plant pot, out of the people's way."""
    cloth, wood, clay = (0.10, 0.14, 0.20), (0.34, 0.20, 0.10), (0.45, 0.22, 0.14)
    return (
        Box((-2.05, 4.10, 0.22), (1.30, 0.85, 0.44), cloth),
        Box((-2.05, 4.45, 0.58), (1.30, 0.20, 0.40), cloth),
        Box((2.15, 4.45, 0.70), (0.90, 0.36, 1.40), wood),
        Cylinder((1.35, 4.30, 0.0), 0.17, 0.34, clay),
    )


class Casting:
    """Draws people from a scene's random numbers, each in a shirt of another colour."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self._shirts = [CLOTHS[k] for k in rng.permutation(len(CLOTHS))]

    def actor(self, path: Path, clips: tuple[Clip, ...] = (), sex: Sex | None = None) -> Actor:
        """Somebody new who walks a path and acts."""
        look = random_look(self.rng, sex, self._shirts.pop())
        return Actor(build_body(look), Performance(path, clips, Style.drawn(self.rng)))


Cast = Callable[[Casting], list[Actor]]


def _stands(x: float, y: float, heading_rad: float = TO_CAMERA) -> Path:
    return Path(((x, y),), heading_rad, heading_rad)


def _bystander(casting: Casting, k: int) -> Actor:
    """Somebody at the back of the room, the k-th from 0."""
    x, y = ((-1.15, 3.6), (1.25, 3.7), (0.60, 4.1), (-0.60, 4.1), (-1.9, 3.4))[k]
    return casting.actor(_stands(x + casting.rng.uniform(-0.05, 0.05), y))


def _pass_by(casting: Casting) -> list[Actor]:
    """Person 1 waves and boxes; person 2 walks past in front and waves on the other side."""
    first = casting.actor(
        _stands(casting.rng.uniform(-0.05, 0.05), 3.25),
        (Clip("wave", -1.0, 1.75), Clip("box", 1.6, 1e3)),
        sex="man",
    )
    way = Path(
        ((-1.0, 2.3), (0.74, 2.3)), TO_CAMERA, TO_CAMERA, start_s=0.25, speed_mps=0.75
    )  # fmt: skip
    second = casting.actor(way, (Clip("wave", 3.0, 1e3, side="l"),), sex="woman")
    return [first, second]


def _stand_in_front(casting: Casting) -> list[Actor]:
    """Person 2 steps in front of person 1 and stays there."""
    first = casting.actor(_stands(0.0, 3.3), (Clip("raise_arms", 0.5, 1e3),))
    way = Path(
        ((-1.0, 2.3), (-0.12, 2.35)), TO_RIGHT, TO_CAMERA, start_s=0.3, speed_mps=0.9
    )  # fmt: skip
    return [first, casting.actor(way)]


def _walk(casting: Casting) -> list[Actor]:
    """One person walks a curve towards the camera and across."""
    way = Path(((-1.0, 3.8), (0.3, 3.3), (0.7, 2.6), (-0.5, 2.4)), TO_RIGHT, TO_CAMERA, 0.3, 1.1)
    return [casting.actor(way)]


def _alone(*actions: ActionName) -> Cast:
    """One person before the camera, each action for two seconds in turn."""

    def build(casting: Casting) -> list[Actor]:
        clips = tuple(
            Clip(action, 0.4 + 2.0 * k, 2.4 + 2.0 * k if k + 1 < len(actions) else 1e3)
            for k, action in enumerate(actions)
        )
        return [casting.actor(_stands(0.0, casting.rng.uniform(2.5, 2.9)), clips)]

    return build


SCENES: Final[dict[str, Cast]] = {
    "pass_by": _pass_by,
    "stand_in_front": _stand_in_front,
    "walk": _walk,
    "stand": _alone(),
    "wave": _alone("wave"),
    "box": _alone("box"),
    "raise_arms": _alone("raise_arms"),
    "reach": _alone("reach"),
    "all_actions": _alone("wave", "box", "raise_arms", "reach"),
}
"""Who is in each scene, by its name."""

DEFAULT_FRAMES: Final = 120


def scene_by_name(
    name: str,
    *,
    seed: int = 0,
    frames: int | None = None,
    people: int | None = None,
    camera: Camera = KINECT_V1_HALF,
) -> Scene:
    """A scene of `SCENES`.

    Args:
        name: one of `SCENES`.
        seed: of bodies, looks, style of motion and sensor noise.
        frames: how many, 120 if None.
        people: how many, as the scene has it if None; more stand in the background.
        camera: intrinsics, a Kinect v1 at 320 x 240 if not given.

    Raises:
        InputError: the name is unknown, or a number is out of range.
    """
    if name not in SCENES:
        raise InputError(f"scene {name!r} is not known; it must be one of {', '.join(SCENES)}")
    if seed < 0:
        raise InputError(f"seed is {seed}; it must be 0 or more")
    if people is not None and not 1 <= people <= MAX_PEOPLE:
        raise InputError(f"people is {people}; it must be 1 to {MAX_PEOPLE}")
    casting = Casting(np.random.default_rng((seed, *name.encode())))
    actors = SCENES[name](casting)
    wanted = len(actors) if people is None else people
    actors += [_bystander(casting, k) for k in range(wanted - len(actors))]
    return Scene(
        name=name,
        seed=seed,
        frames=DEFAULT_FRAMES if frames is None else frames,
        camera=camera,
        mount=Mount(),
        room=Room(),
        furniture=_living_room(),
        actors=tuple(actors[:wanted]),
    )
