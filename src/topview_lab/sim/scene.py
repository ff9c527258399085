"""Scenes: a room with furniture, a camera in it, and people who do something.

The room frame is x to the camera's right, y away from it, z up, with its origin on the floor below
the camera.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, InputError
from topview_lab.sim.appearance import Rgb
from topview_lab.sim.bodies import Body
from topview_lab.sim.light import STEADY, Light
from topview_lab.sim.motions import Performance

MAX_PEOPLE: Final = 6
"""People in one scene (ours)."""


@dataclass(frozen=True, slots=True)
class Mount:
    """Pose of the camera in the room.

    Attributes:
        height_m: above the floor.
        tilt_rad: how far it looks down.
        heading_rad: how far it looks to the left of the room's y axis.
        position_room: (x, y) metres.
    """

    height_m: float = 1.2
    tilt_rad: float = radians(7)
    heading_rad: float = 0.0
    position_room: tuple[float, float] = (0.0, 0.0)

    def T_camera_room(self) -> NDArray[np.float64]:
        """[4, 4] room into camera frame."""
        c, s = cos(self.tilt_rad), sin(self.tilt_rad)
        ch, sh = cos(self.heading_rad), sin(self.heading_rad)
        T = np.eye(4)
        T[:3, :3] = np.array([[1, 0, 0], [0, -s, -c], [0, c, -s]]) @ [
            [ch, sh, 0],
            [-sh, ch, 0],
            [0, 0, 1],
        ]
        T[:3, 3] = T[:3, :3] @ (*(-np.array(self.position_room)), -self.height_m)
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
    """A body and its performance."""

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
        start_s: time of the first frame; the scene's events begin at 0.
        camera, mount: the camera and where it hangs.
        room, furniture: the static surroundings.
        actors: the people; person k is the k-th, counted from 1.
        light: how it changes.
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
    light: Light = STEADY
    start_s: float = 0.0

    def time_s(self, frame: int) -> float:
        """When a frame is taken."""
        return self.start_s + frame / self.fps

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f"scene {self.name}: frames is {self.frames}; it must be 1 or more")
        if len(self.actors) > MAX_PEOPLE:
            raise InputError(
                f"scene {self.name}: people is {len(self.actors)}; it must be 0 to {MAX_PEOPLE}"
            )
