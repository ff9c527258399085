"""Rendering of people in a room.

The room is drawn once per scene, people are drawn into a copy of it frame by frame, each piece of
flesh only within its own window of the image.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays
from topview.records import Camera
from topview.sim.bodies import Body
from topview.sim.images import Rendering
from topview.sim.primitives import RayCaster, RoundCones, surface_normals
from topview.sim.room import render_room
from topview.sim.scene import Scene
from topview.sim.skeleton import segment_poses


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A frame before the sensor: each person's [S, 4, 4] Ts_camera_segment, and the images."""

    Ts_camera_segment: tuple[NDArray[np.float64], ...]
    rendering: Rendering


class Renderer:
    """Draws the frames of one scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._T_camera_room = scene.mount.T_camera_room()
        self.background = render_room(scene.room, scene.furniture, scene.camera, scene.mount)

    def draw(self, frame: int) -> Drawing:
        """The ideal images of a frame, people counted from 1 in the scene's order."""
        time_s = frame / self._scene.fps
        actors = self._scene.actors
        poses = tuple(
            self._T_camera_room
            @ segment_poses(actor.body.offsets_m, actor.performance.pose(actor.body, time_s))
            for actor in actors
        )
        bodies = [actor.body for actor in actors]
        return Drawing(poses, draw_people(bodies, poses, self.background, self._scene.camera))


def draw_people(
    bodies: Sequence[Body],
    Ts_camera_segment: Sequence[NDArray[np.float64]],
    background: Rendering,
    camera: Camera,
) -> Rendering:
    """Posed bodies in front of a background.

    Args:
        bodies: the people, counted from 1.
        Ts_camera_segment: each one's [S, 4, 4].
        background: the empty room.
        camera: intrinsics of all images.
    """
    if not bodies:
        return background
    flesh = [body.flesh(Ts) for body, Ts in zip(bodies, Ts_camera_segment, strict=True)]
    solids = _stacked(flesh)
    depth = background.depth_m.astype(np.float64)
    solid = np.full(depth.shape, -1, np.int32)
    caster = RayCaster(solids, camera)
    for n, window in enumerate(caster.windows):
        seen = depth[window]
        if seen.size == 0:
            continue
        t = caster.depth(n, window)
        is_nearer = t < seen
        np.copyto(seen, t, where=is_nearer)
        np.copyto(solid[window], n, where=is_nearer)

    rows, columns = np.nonzero(solid >= 0)
    hit = solid[rows, columns]
    people = np.concatenate([np.full(len(f), k + 1, np.uint8) for k, f in enumerate(flesh)])
    instance, part = background.instance.copy(), background.part.copy()
    material, normals = background.material.copy(), background.normals.copy()
    albedo = background.albedo.copy()
    instance[rows, columns] = people[hit]
    part[rows, columns] = np.concatenate([body.parts for body in bodies])[hit]
    material[rows, columns] = np.concatenate([body.materials for body in bodies])[hit]
    albedo[rows, columns] = np.concatenate([body.colors for body in bodies])[hit]
    points = pixel_rays(camera)[rows, columns] * depth[rows, columns, None]
    normals[rows, columns] = surface_normals(solids, hit, points)
    return Rendering(depth.astype(np.float32), instance, part, material, normals, albedo)


def _stacked(flesh: list[RoundCones]) -> RoundCones:
    return RoundCones(
        *(
            np.concatenate([getattr(solids, name) for solids in flesh])
            for name in RoundCones.__dataclass_fields__
        )
    )
