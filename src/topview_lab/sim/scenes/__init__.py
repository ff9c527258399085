"""The scenes that have a name: who is in the room, and what they do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from topview.records import Camera, InputError
from topview_lab.sim.appearance import Appearance
from topview_lab.sim.furniture import furnished, living_room
from topview_lab.sim.light import STEADY, Light
from topview_lab.sim.scene import MAX_PEOPLE, Actor, Mount, Room, Scene
from topview_lab.sim.scenes.alone import ALONE, MHAD
from topview_lab.sim.scenes.classic import CLASSIC
from topview_lab.sim.scenes.several import SEVERAL
from topview_lab.sim.scenes.stage import Casting, SceneKind, stands, varied_room

__all__ = ["KINECT_V1_FULL", "KINECT_V1_HALF", "SCENES", "Casting", "SceneKind", "scene_by_name"]

KINECT_V1_FULL: Final = Camera(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=640, height=480)
"""Nominal intrinsics of a Kinect v1."""
KINECT_V1_HALF: Final = Camera(fx=262.5, fy=262.5, cx=159.5, cy=119.5, width=320, height=240)
"""The same at half the resolution."""

SCENES: Final[dict[str, SceneKind]] = {**CLASSIC, **MHAD, **ALONE, **SEVERAL}
"""All scenes by name."""


def _bystander(casting: Casting, k: int) -> Actor:
    """The k-th bystander at the back of the room, counted from 0."""
    x, y = ((-1.15, 3.6), (1.25, 3.7), (0.60, 4.1), (-0.60, 4.1), (-1.9, 3.4))[k]
    return casting.actor(stands(x + casting.rng.uniform(-0.05, 0.05), y))


def scene_by_name(
    name: str,
    *,
    seed: int = 0,
    frames: int | None = None,
    people: int | None = None,
    camera: Camera = KINECT_V1_HALF,
    appearances: Sequence[Appearance] | None = None,
) -> Scene:
    """A scene of `SCENES`.

    Args:
        name: one of `SCENES`.
        seed: of bodies, looks, style of motion, room, light and sensor noise.
        frames: how many, as the scene is made for if None.
        people: how many, as the scene has it if None; more stand in the background.
        camera: intrinsics, a Kinect v1 at 320 x 240 if not given.
        looks: whose bodies the first people have.

    Raises:
        InputError: the name is unknown, or a number is out of range.
    """
    if name not in SCENES:
        raise InputError(f"scene {name!r} is not known; it must be one of {', '.join(SCENES)}")
    if seed < 0:
        raise InputError(f"seed is {seed}; it must be 0 or more")
    if people is not None and not 1 <= people <= MAX_PEOPLE:
        raise InputError(f"people is {people}; it must be 1 to {MAX_PEOPLE}")
    kind = SCENES[name]
    rng = np.random.default_rng((seed, *name.encode()))
    casting = Casting(rng, appearances or ())
    staging = kind.cast(casting)
    actors = list(staging.actors)
    wanted = len(actors) if people is None else people
    actors += [_bystander(casting, k) for k in range(wanted - len(actors))]
    if appearances is not None and len(appearances) > wanted:
        raise InputError(
            f"scene {name}: appearances are {len(appearances)}; people are only {wanted}"
        )
    room, mount, furniture, light = Room(), Mount(), living_room(), STEADY
    if kind.has_varied_room:
        of_room = rng.spawn(1)[0]
        room, mount = varied_room(of_room)
        furniture = furnished(of_room, room)
        light = Light.sample(of_room)
    return Scene(
        name=name,
        seed=seed,
        frames=kind.frames if frames is None else frames,
        camera=camera,
        mount=mount,
        room=room,
        furniture=(*furniture, *staging.furniture),
        actors=tuple(actors[:wanted]),
        light=light,
    )
