"""Rendering of what stands still: floor, walls, ceiling, boxes and cylinders."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays
from topview.records import Camera
from topview_lab.sim.images import FURNITURE, NO_MATERIAL, NO_PART, ROOM, Rendering
from topview_lab.sim.scene import Box, Cylinder, Furniture, Mount, Room


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
