"""Noise-free images of a scene: depth, who, which part, what material, normals, colour.

The room is drawn once per scene, people are drawn into a copy of it frame by frame, each piece of
flesh only within its own window of the image.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays
from topview.records import Camera, read_only
from topview.sim.bodies import Body
from topview.sim.primitives import RayCaster, RoundCones, surface_normals
from topview.sim.scene import Box, Cylinder, Furniture, Mount, Room, Scene
from topview.sim.skeleton import segment_poses

ROOM: Final = 0
FURNITURE: Final = 255
NO_PART: Final = 255
NO_MATERIAL: Final = 255


@dataclass(frozen=True, slots=True, eq=False)
class Rendering:
    """What an ideal camera sees.

    Attributes:
        depth_m: [H, W] float32 along the optical axis, inf where there is nothing.
        instance: [H, W] uint8, 0 room, k = person k, 255 furniture.
        part: [H, W] uint8 index into `bodies.PART_NAMES`, 255 off the people.
        material: [H, W] uint8 index into `bodies.MATERIALS`, 255 off the people.
        normals: [H, W, 3] float32 outward units in the camera frame.
        albedo: [H, W, 3] float32 linear colour in 0..1.
    """

    depth_m: NDArray[np.float32]
    instance: NDArray[np.uint8]
    part: NDArray[np.uint8]
    material: NDArray[np.uint8]
    normals: NDArray[np.float32]
    albedo: NDArray[np.float32]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            read_only(getattr(self, name))


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


# --- the room ---------------------------------------------------------------------------------


def render_room(
    room: Room, furniture: tuple[Furniture, ...], camera: Camera, mount: Mount
) -> Rendering:
    """The room without people."""
    T_room_camera = np.linalg.inv(mount.T_camera_room()).astype(np.float64)
    R_camera_room = T_room_camera[:3, :3].T
    origin: NDArray[np.float64] = T_room_camera[:3, 3]
    rays = pixel_rays(camera).astype(np.float64) @ T_room_camera[:3, :3].T

    low = np.array([-room.width_m / 2, room.near_wall_m, 0.0])
    high = np.array([room.width_m / 2, room.far_wall_m, room.height_m])
    depth, normals = _leave_box(origin, rays, low, high)
    points = origin + rays * depth[..., None]
    albedo = _room_colors(room, points, normals)
    instance = np.full(depth.shape, ROOM, np.uint8)
    for piece in furniture:
        t, n = _enter(piece, origin, rays)
        is_nearer = t < depth
        depth[is_nearer] = t[is_nearer]
        normals[is_nearer] = n[is_nearer]
        instance[is_nearer] = FURNITURE
        albedo[is_nearer] = piece.color
    return Rendering(
        depth_m=depth.astype(np.float32),
        instance=instance,
        part=np.full(depth.shape, NO_PART, np.uint8),
        material=np.full(depth.shape, NO_MATERIAL, np.uint8),
        normals=(normals @ R_camera_room.T).astype(np.float32),
        albedo=albedo.astype(np.float32),
    )


Hits = tuple[NDArray[np.float64], NDArray[np.float64]]
"""[H, W] ray parameters, inf where missed, and [H, W, 3] unit normals."""


def _slabs(
    origin: NDArray[np.float64],
    rays: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[H, W, 3] parameters at which rays enter and leave the slab of each axis."""
    safe = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
    to_low, to_high = (low - origin) / safe, (high - origin) / safe
    return np.minimum(to_low, to_high), np.maximum(to_low, to_high)


def _axis_normals(axis: NDArray[np.intp], rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """[H, W, 3] units along an axis, against the rays."""
    normals = np.eye(3)[axis]
    return -normals * np.sign((normals * rays).sum(-1, keepdims=True))


def _leave_box(
    origin: NDArray[np.float64],
    rays: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> Hits:
    """The inside of a box around the origin."""
    _, leaves = _slabs(origin, rays, low, high)
    return leaves.min(-1), _axis_normals(leaves.argmin(-1), rays)


def _enter(piece: Furniture, origin: NDArray[np.float64], rays: NDArray[np.float64]) -> Hits:
    """The outside of a piece of furniture."""
    if isinstance(piece, Cylinder):
        return _enter_cylinder(piece, origin, rays)
    return _enter_box(piece, origin, rays)


def _enter_box(box: Box, origin: NDArray[np.float64], rays: NDArray[np.float64]) -> Hits:
    c, s = np.cos(box.heading_rad), np.sin(box.heading_rad)
    R_room_box = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    local_origin = (origin - box.center_room) @ R_room_box
    local_rays = rays @ R_room_box
    half = np.array(box.size_m) / 2
    enters, leaves = _slabs(local_origin, local_rays, -half, half)
    t = enters.max(-1)
    t = np.where((t > 0.0) & (t < leaves.min(-1)), t, np.inf)
    return t, _axis_normals(enters.argmax(-1), local_rays) @ R_room_box.T


def _enter_cylinder(
    cylinder: Cylinder, origin: NDArray[np.float64], rays: NDArray[np.float64]
) -> Hits:
    start = origin - cylinder.base_room
    a = (rays[..., :2] ** 2).sum(-1)
    b = (rays[..., :2] * start[:2]).sum(-1)
    c = float((start[:2] ** 2).sum()) - cylinder.radius_m**2
    with np.errstate(invalid="ignore", divide="ignore"):
        side = (-b - np.sqrt(b * b - a * c)) / a
        height = start[2] + side * rays[..., 2]
        side = np.where((side > 0.0) & (height > 0.0) & (height < cylinder.height_m), side, np.inf)
        top = (cylinder.height_m - start[2]) / rays[..., 2]
        across = start[:2] + top[..., None] * rays[..., :2]
        on_top = (top > 0.0) & ((across**2).sum(-1) < cylinder.radius_m**2)
    t = np.minimum(side, np.where(on_top, top, np.inf))
    normals = np.zeros(rays.shape)
    normals[..., 2] = 1.0
    is_side = np.isfinite(side) & (side <= t)
    points = start + np.where(is_side, side, 0.0)[..., None] * rays
    normals[is_side] = points[is_side] * (1.0, 1.0, 0.0) / cylinder.radius_m
    return t, normals


PLANK_M: Final = (0.18, 1.3)
SKIRTING_M: Final = 0.09


def _room_colors(
    room: Room, points: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[H, W, 3] floor boards, plain walls with a skirting board, a plain ceiling."""
    is_floor, is_ceiling = normals[..., 2] > 0.5, normals[..., 2] < -0.5
    row = np.floor(points[..., 0] / PLANK_M[0])
    board = np.floor(points[..., 1] / PLANK_M[1] + 0.37 * row)
    shade = 0.88 + 0.24 * np.modf(np.abs(np.sin(12.9898 * row + 78.233 * board) * 43758.5453))[0]
    colors = np.where(is_floor[..., None], np.array(room.floor) * shade[..., None], room.walls)
    colors[is_ceiling] = room.ceiling
    colors[~is_floor & (points[..., 2] < SKIRTING_M)] = (0.75, 0.74, 0.70)
    return colors
