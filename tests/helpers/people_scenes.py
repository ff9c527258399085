"""A renderer of people made of balls, on a floor, for the tests of finding people."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays
from topview.records import Camera, Frame

CAMERA = Camera(285.0, 285.0, 159.5, 119.5, 320, 240)
Ball = tuple[NDArray[np.float64], float]


def floor_normal(tilt_rad: float, roll_rad: float = 0.0) -> NDArray[np.float64]:
    """[3] up, in the camera's frame, of a camera that looks down by `tilt_rad`."""
    up = np.array([np.sin(roll_rad), -np.cos(roll_rad) * np.cos(tilt_rad), 0.0])
    up[2] = -np.sqrt(1.0 - up[0] ** 2 - up[1] ** 2) * np.sign(tilt_rad)
    return up


def limb(start: Iterable[float], end: Iterable[float], radius_m: float) -> list[Ball]:
    a, b = np.array(list(start)), np.array(list(end))
    count = int(np.linalg.norm(b - a) / (0.5 * radius_m)) + 2
    return [(a + share * (b - a), radius_m) for share in np.linspace(0.0, 1.0, count)]


def standing_person(
    x: float, z: float, ground_y: float, height_m: float = 1.75, *, right_hand_up: bool = False
) -> list[Ball]:
    """Balls in the camera's frame (y down) of one who faces the camera, arms down."""
    h = height_m

    def at(right: float, up: float, ahead: float = 0.0) -> tuple[float, float, float]:
        return (x + right * h, ground_y - up * h, z - ahead * h)

    head_radius = 0.065 * h
    balls = limb(at(0, 0.915), at(0, 1.0 - 0.065), 0.052 * h)
    balls += [(np.array(at(0, 1.0 - 0.065)), head_radius)]
    balls += limb(at(0, 0.82), at(0, 0.88), 0.035 * h)
    for side in (-1, 1):
        balls += limb(at(side * 0.06, 0.55), at(side * 0.06, 0.76), 0.065 * h)
        balls += limb(at(side * 0.05, 0.5), at(side * 0.06, 0.06), 0.045 * h)
        balls += limb(at(side * 0.06, 0.022), at(side * 0.06, 0.022, 0.08), 0.022 * h)
        shoulder, elbow = at(side * 0.12, 0.79), at(side * 0.15, 0.62)
        hand = at(side * 0.16, 0.44)
        if right_hand_up and side == 1:
            elbow, hand = at(0.17, 0.92), at(0.13, 1.1)
        balls += limb(shoulder, elbow, 0.028 * h) + limb(elbow, hand, 0.025 * h)
    return balls


def head_of(x: float, z: float, ground_y: float, height_m: float = 1.75) -> NDArray[np.float64]:
    return np.array([x, ground_y - 0.93 * height_m, z])


def box(
    low: tuple[float, float, float], high: tuple[float, float, float], camera: Camera = CAMERA
) -> NDArray[np.float32]:
    """[H, W] depth of an upright box, infinity beside it."""
    rays = pixel_rays(camera).astype(np.float64)
    with np.errstate(divide="ignore"):
        to_low, to_high = np.array(low) / rays, np.array(high) / rays
    enter = np.minimum(to_low, to_high).max(-1)
    leave = np.maximum(to_low, to_high).min(-1)
    return np.where((enter < leave) & (enter > 0.1), enter, np.inf).astype(np.float32)


def plane(
    normal: NDArray[np.float64], distance_m: float, camera: Camera = CAMERA
) -> NDArray[np.float32]:
    """[H, W] depth of the plane normal @ p + distance_m == 0, infinity where it is not seen."""
    along = pixel_rays(camera).astype(np.float64) @ normal
    depth = np.full(along.shape, np.inf)
    is_seen = along < -1e-6
    depth[is_seen] = -distance_m / along[is_seen]
    return depth.astype(np.float32)


def render(
    balls: Iterable[Ball],
    surfaces: Iterable[NDArray[np.float32]] = (),
    camera: Camera = CAMERA,
    max_depth_m: float = 7.0,
) -> NDArray[np.float32]:
    """[H, W] depth of balls and ready-made surfaces; 0 where there is nothing near enough."""
    depth = np.full((camera.height, camera.width), np.inf, np.float32)
    for surface in surfaces:
        np.minimum(depth, surface, out=depth)
    rays = pixel_rays(camera)
    for center, radius in balls:
        reach = radius / (center[2] - radius) * 1.2
        u, v = (center[:2] / center[2] * camera.fx) + (camera.cx, camera.cy)
        left, right = (int(u + side * reach * camera.fx) for side in (-1, 1))
        top, bottom = (int(v + side * reach * camera.fx) for side in (-1, 1))
        window = (slice(max(top, 0), max(bottom + 2, 0)), slice(max(left, 0), max(right + 2, 0)))
        ray = rays[window].astype(np.float64)
        a, b = (ray**2).sum(-1), ray @ center
        root = b * b - a * (center @ center - radius * radius)
        hit = np.where(root >= 0.0, (b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf)
        np.minimum(depth[window], hit.astype(np.float32), out=depth[window])
    depth[depth > max_depth_m] = 0.0
    return depth


def with_noise(depth_m: NDArray[np.float32], seed: int) -> NDArray[np.float32]:
    """A Kinect's: 1.5 mm at 1 m, growing with the square of the depth."""
    noise = np.random.default_rng(seed).normal(size=depth_m.shape) * 0.0015 * depth_m**2
    return (depth_m + noise).astype(np.float32)


def frame(depth_m: NDArray[np.float32], index: int = 0, camera: Camera = CAMERA) -> Frame:
    return Frame(index, index / 30.0, depth_m.copy(), camera)
