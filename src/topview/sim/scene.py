"""Scenes: a room with furniture, a camera in it, and people who do something.

The room frame is x to the camera's right, y away from it, z up, with its origin on the floor below
the camera.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, radians, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, InputError
from topview.sim.bodies import Body, Rgb, Sex, build_body, random_look
from topview.sim.motions import ActionName, Clip, Path, Performance, Style

KINECT_V1_HALF: Final = Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=320, height=240)
"""Nominal intrinsics (525 px at 640 x 480) at half resolution."""

TO_CAMERA: Final = radians(-90)
TO_RIGHT: Final = 0.0


@dataclass(frozen=True, slots=True)
class Mount:
    """Where the camera hangs: metres above the floor, and how far it looks down, radians."""

    height_m: float = 1.2
    tilt_rad: float = radians(7)

    def T_camera_room(self) -> NDArray[np.float64]:
        """[4, 4] room into camera frame."""
        c, s = cos(self.tilt_rad), sin(self.tilt_rad)
        T = np.eye(4)
        T[:3, :3] = [[1, 0, 0], [0, -s, -c], [0, c, -s]]
        T[:3, 3] = T[:3, :3] @ (0.0, 0.0, -self.height_m)
        return T


@dataclass(frozen=True, slots=True)
class Room:
    """Floor and four walls around the camera; sizes in metres, linear colours in 0..1."""

    width_m: float = 5.6
    far_wall_m: float = 4.7
    near_wall_m: float = -1.5
    height_m: float = 2.7
    floor: Rgb = (0.30, 0.22, 0.16)
    walls: Rgb = (0.56, 0.56, 0.52)
    ceiling: Rgb = (0.70, 0.70, 0.70)


@dataclass(frozen=True, slots=True)
class Box:
    """A piece of furniture: its centre and full size in metres, turned about the vertical."""

    center_room: tuple[float, float, float]
    size_m: tuple[float, float, float]
    color: Rgb
    heading_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder: the middle of its base, radius and height in metres."""

    base_room: tuple[float, float, float]
    radius_m: float
    height_m: float
    color: Rgb


Furniture = Box | Cylinder


@dataclass(frozen=True, slots=True, eq=False)
class Actor:
    """A body and what it does."""

    body: Body
    performance: Performance


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything that the simulator needs to make a recording.

    Attributes:
        name: of the recording.
        seed: of all that varies; with the frame's number, it is the key of the sensor's noise.
        frames: how many.
        fps: frames per second.
        camera, mount: the camera and where it hangs.
        room, furniture: what stands still.
        actors: the people; person k is the k-th, counted from 1.
    """

    name: str
    seed: int
    frames: int
    camera: Camera
    mount: Mount
    room: Room
    furniture: tuple[Furniture, ...]
    actors: tuple[Actor, ...]
    fps: float = 30.0

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f"scene {self.name}: frames is {self.frames}; it must be 1 or more")
        if len(self.actors) > MAX_PEOPLE:
            raise InputError(
                f"scene {self.name}: people is {len(self.actors)}; it must be 0 to {MAX_PEOPLE}"
            )


MAX_PEOPLE: Final = 6


def _living_room() -> tuple[Furniture, ...]:
    """A sofa, a shelf, a side table and a plant pot, out of the people's way."""
    cloth, wood, clay = (0.10, 0.14, 0.20), (0.34, 0.20, 0.10), (0.45, 0.22, 0.14)
    return (
        Box((-2.05, 4.10, 0.22), (1.30, 0.85, 0.44), cloth),
        Box((-2.05, 4.45, 0.58), (1.30, 0.20, 0.40), cloth),
        Box((2.15, 4.45, 0.70), (0.90, 0.36, 1.40), wood),
        Cylinder((1.35, 4.30, 0.0), 0.17, 0.34, clay),
    )


def _actor(
    rng: np.random.Generator, path: Path, clips: tuple[Clip, ...] = (), sex: Sex | None = None
) -> Actor:
    return Actor(
        body=build_body(random_look(rng, sex)),
        performance=Performance(path=path, clips=clips, style=Style.drawn(rng)),
    )


def _stands(x: float, y: float, heading_rad: float = TO_CAMERA) -> Path:
    return Path(((x, y),), heading_rad, heading_rad)


def _bystander(rng: np.random.Generator, k: int) -> Actor:
    """Somebody at the back of the room, the k-th from 0."""
    x, y = ((-1.15, 3.6), (1.25, 3.7), (0.60, 4.1), (-0.60, 4.1), (-1.9, 3.4))[k]
    return _actor(rng, _stands(x + rng.uniform(-0.05, 0.05), y))


def _pass_by(rng: np.random.Generator) -> list[Actor]:
    """Person 1 waves and boxes; person 2 walks past in front and waves on the other side."""
    first = _actor(
        rng,
        _stands(rng.uniform(-0.05, 0.05), 3.1),
        (Clip("wave", -1.0, 1.75), Clip("box", 1.6, 1e3)),
        sex="man",
    )
    way = Path(
        ((-1.05, 2.35), (1.02, 2.35)), TO_CAMERA, TO_CAMERA, start_s=0.35, speed_mps=0.95
    )  # fmt: skip
    second = _actor(rng, way, (Clip("wave", 3.05, 1e3, side="l"),), sex="woman")
    return [first, second]


def _stand_in_front(rng: np.random.Generator) -> list[Actor]:
    """Person 2 steps in front of person 1 and stays there."""
    first = _actor(rng, _stands(0.0, 3.3), (Clip("raise_arms", 0.5, 1e3),))
    way = Path(
        ((-1.0, 2.3), (-0.12, 2.35)), TO_RIGHT, TO_CAMERA, start_s=0.3, speed_mps=0.9
    )  # fmt: skip
    return [first, _actor(rng, way)]


def _walk(rng: np.random.Generator) -> list[Actor]:
    """One person walks a curve towards the camera and across."""
    way = Path(((-1.0, 3.8), (0.3, 3.3), (0.7, 2.6), (-0.5, 2.4)), TO_RIGHT, TO_CAMERA, 0.3, 1.1)
    return [_actor(rng, way)]


def _alone(*actions: ActionName) -> Callable[[np.random.Generator], list[Actor]]:
    """One person before the camera, each action for two seconds in turn."""

    def build(rng: np.random.Generator) -> list[Actor]:
        clips = tuple(
            Clip(action, 0.4 + 2.0 * k, 2.4 + 2.0 * k if k + 1 < len(actions) else 1e3)
            for k, action in enumerate(actions)
        )
        return [_actor(rng, _stands(0.0, rng.uniform(2.5, 2.9)), clips)]

    return build


SCENES: Final[dict[str, Callable[[np.random.Generator], list[Actor]]]] = {
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
    rng = np.random.default_rng((seed, *name.encode()))
    actors = SCENES[name](rng)
    wanted = len(actors) if people is None else people
    actors += [_bystander(rng, k) for k in range(wanted - len(actors))]
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
