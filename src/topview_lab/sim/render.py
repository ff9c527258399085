"""Rendering of people in a room.

The room is drawn once per scene, people are drawn into a copy of it frame by frame, each piece of
flesh only within its own window of the image.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera
from topview_lab.sim.bodies import Body
from topview_lab.sim.images import Rendering
from topview_lab.sim.primitives import RayCaster, RoundCones, surface_normals
from topview_lab.sim.room import render_room
from topview_lab.sim.scene import Scene
from topview_lab.sim.skeleton import segment_poses
from topview_lab.sim.surface import surface_detail

Pixels = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns."""


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
        time_s = self._scene.time_s(frame)
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
    flesh = [body.flesh(Ts) for body, Ts in zip(bodies, Ts_camera_segment, strict=True)]
    if not flesh:
        return background
    solids = _stacked(flesh)
    depth = background.depth_m.astype(np.float64)
    solid = np.full(depth.shape, -1, np.int32)
    RayCaster(solids, camera).draw(depth, solid)

    rows, columns = np.nonzero(solid >= 0)
    pixels = rows, columns
    hit = solid[pixels]
    people = np.concatenate([np.full(len(f), k, np.uint8) for k, f in enumerate(flesh)])[hit]
    rays = _rays(pixels, camera)
    points = rays * depth[pixels][:, None]
    normals = surface_normals(solids, hit, points)
    depth = depth.astype(np.float32)
    colors = np.concatenate([body.colors for body in bodies])[hit]
    first = 0
    for k, (body, Ts) in enumerate(zip(bodies, Ts_camera_segment, strict=True)):
        own = np.nonzero(people == k)[0]
        detail = surface_detail(body, Ts, hit[own] - first, points[own], normals[own])
        first += len(flesh[k])
        normals[own] = detail.normals
        colors[own] *= detail.shades[:, None]
        at = rows[own], columns[own]
        facing = np.minimum(np.einsum("mi,mi->m", normals[own], rays[own]), -LEAST_FACING)
        depth[at] = np.minimum(depth[at] + detail.displacements / facing, background.depth_m[at])

    instance, part = background.instance.copy(), background.part.copy()
    material, all_normals = background.material.copy(), background.normals.copy()
    albedo = background.albedo.copy()
    instance[pixels] = people + 1
    part[pixels] = np.concatenate([body.parts for body in bodies])[hit]
    material[pixels] = np.concatenate([body.materials for body in bodies])[hit]
    albedo[pixels] = colors
    all_normals[pixels] = normals
    return Rendering(depth, instance, part, material, all_normals, albedo)


LEAST_FACING: Final = 0.45
"""Least cosine between ray and normal that scales a displacement along the ray (ours). Below it, at
the outline, the ray would leave the surface."""


def _rays(pixels: Pixels, camera: Camera) -> NDArray[np.float64]:
    """[M, 3] rays of some pixels, z = 1."""
    x = (pixels[1] - camera.cx) / camera.fx
    y = (pixels[0] - camera.cy) / camera.fy
    return np.stack([x, y, np.ones(len(x))], -1).astype(np.float64, copy=False)


def _stacked(flesh: list[RoundCones]) -> RoundCones:
    return RoundCones(
        *(
            np.concatenate([getattr(solids, name) for solids in flesh])
            for name in RoundCones.__dataclass_fields__
        )
    )
