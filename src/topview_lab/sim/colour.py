"""Colour images: Lambert shading with soft shadows under the feet, and a camera's noise.

The room is shaded once; people and their shadows are shaded in every frame.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import pixel_rays
from topview.records import Camera
from topview_lab.sim.images import FURNITURE, ROOM, Rendering
from topview_lab.sim.light import Levels
from topview_lab.sim.noise import NoiseField
from topview_lab.sim.primitives import Window

LAMP_ROOM: Final = (-0.45, -0.62, 0.64)
"""Direction towards the lamp in the room frame: above, to the left, behind the camera (ours)."""
COLOR_NOISE_LEVELS: Final = 2.2
"""Standard deviation of the colour camera's noise in grey levels of 255 (ours)."""
BLUR_PX: Final = 0.45
"""Blur of the colour camera's lens and mosaic (ours)."""
EXPOSURE: Final = 1.25
"""Brightness of a white surface that faces the lamp (ours)."""
SOFT_SHARE: Final = 1.3 / 240
"""Blur of the people's normals as a share of the image's height (ours)."""
SHADOW_M: Final = 0.17
"""Size of the shadow under a foot (ours)."""
SHADOW_DEPTH: Final = 0.7
"""Share of the light that is missing right under a foot (ours)."""
NO_FLOOR_M: Final = 1e3
"""Depth of pixels that show no floor, out of any shadow."""
COLOR_BASELINE_M: Final = 0.025
"""From the Kinect v1's depth camera to its colour camera, to its right (nominal)."""
GHOST_M: Final = 0.15
"""Least difference in depth by which a surface hides another from the colour camera (ours)."""
NOISE_KEY: Final = (1 << 31) + 1
"""Key of the generator for noise that all frames share, above any frame number."""


class ColorCamera:
    """The colour camera of one scene, its images registered to the depth image.

    Registration looks up each depth pixel's colour without testing whether the colour camera sees
    it. Beside a person, background therefore shows the person's colour: a ghost of a few pixels.

    Args:
        background: the empty room.
        camera: intrinsics.
        R_camera_room: [3, 3].
        seed: of the noise.
        baseline_m: to the depth camera, 0 for perfect registration.
    """

    def __init__(
        self,
        background: Rendering,
        camera: Camera,
        R_camera_room: NDArray[np.float64],
        seed: int,
        baseline_m: float = COLOR_BASELINE_M,
    ) -> None:
        lamp = (R_camera_room @ LAMP_ROOM).astype(np.float32)
        self._lamp = lamp / np.linalg.norm(lamp)
        self._up = R_camera_room[:, 2].astype(np.float32)
        self._disparity_px_m = camera.fx * baseline_m
        self._camera = camera
        is_floor = (background.instance == ROOM) & (background.normals @ self._up > 0.9)
        # [3, H, W] far away where there is no floor
        floor = np.moveaxis(pixel_rays(camera) * background.depth_m[..., None], -1, 0)
        self._floor = np.where(is_floor, floor, np.float32(NO_FLOOR_M))
        self._room = self._shares(background.normals, background.albedo)
        shape = camera.height, camera.width, 3
        self._noise = NoiseField(shape, 1, np.random.default_rng((seed, NOISE_KEY)))

    def picture(
        self,
        rendering: Rendering,
        feet_camera: NDArray[np.float64],
        levels: Levels,
        rng: np.random.Generator,
    ) -> NDArray[np.uint8]:
        """[H, W, 3] uint8 RGB.

        Args:
            rendering: the ideal images.
            feet_camera: [N, 3] the middles of the feet, metres.
            levels: of the light.
            rng: of the noise.
        """
        linear = _lit(self._room, levels)
        self._cast_shadows(linear, feet_camera)
        is_person = (rendering.instance > ROOM) & (rendering.instance < FURNITURE)
        window = _window_of(is_person)
        shown = is_person[window]
        if shown.size:
            normals = _soft(rendering.normals[window], shown, SOFT_SHARE * self._camera.height)
            people = _lit(self._shares(normals, rendering.albedo[window]), levels)
            np.copyto(linear[window], people, where=shown[..., None])
        gray = np.sqrt(np.minimum(linear, np.float32(1.0)))  # gamma 2, about sRGB's
        gray = np.asarray(255.0 * gray, np.float32)
        if shown.size and self._disparity_px_m:
            self._add_ghosts(gray, rendering.depth_m, window)
        gray = cv2.GaussianBlur(gray, (3, 3), BLUR_PX)
        noise = self._noise.draw(rng)
        return cv2.scaleAdd(noise, COLOR_NOISE_LEVELS, gray).clip(0.0, 255.0).astype(np.uint8)

    def _shares(
        self, normals: NDArray[np.float32], albedo: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """[..., 3] the share of the ambient light and of the lamp's light that surfaces reflect."""
        sky = np.float32(0.8 * EXPOSURE) + np.float32(0.2 * EXPOSURE) * (normals @ self._up)
        direct = np.float32(EXPOSURE) * np.maximum(normals @ self._lamp, 0.0)
        return (
            np.asarray(albedo * sky[..., None], np.float32),
            np.asarray(albedo * direct[..., None], np.float32),
        )

    def _cast_shadows(self, linear: NDArray[np.float32], feet_camera: NDArray[np.float64]) -> None:
        """Darken the floor beside the feet."""
        camera, reach = self._camera, 2.5 * SHADOW_M
        for foot in feet_camera[feet_camera[:, 2] > reach].astype(np.float32):
            low, high = (foot[:2] / (foot[2] + side * reach) for side in (1.0, -1.0))
            half = reach / (foot[2] - reach)
            u0, v0 = np.minimum(low, high) - half
            u1, v1 = np.maximum(low, high) + half
            rows = slice(*_clipped(v0, v1, camera.fy, camera.cy, camera.height))
            columns = slice(*_clipped(u0, u1, camera.fx, camera.cx, camera.width))
            x, y, z = self._floor[:, rows, columns] - foot[:, None, None]
            share = np.exp(np.float32(-0.5 / SHADOW_M**2) * (x * x + y * y + z * z))
            linear[rows, columns] *= (1.0 - np.float32(SHADOW_DEPTH) * share)[..., None]

    def _add_ghosts(
        self, gray: NDArray[np.float32], depth_m: NDArray[np.float32], window: Window
    ) -> None:
        """Give background the colour of the person who hides it from the colour camera."""
        rows, columns = window
        nearest = float(depth_m[window].min())
        reach = int(np.ceil(self._disparity_px_m / nearest))
        columns = slice(max(columns.start - reach, 0), columns.stop)
        z = depth_m[rows, columns]
        ahead = cv2.erode(z, np.ones((1, reach + 1), np.uint8), anchor=(0, 0))
        shift = np.rint(self._disparity_px_m * (1.0 / ahead - 1.0 / z)).astype(np.intp)
        v, u = np.nonzero((z > ahead + GHOST_M) & (shift > 0))
        source = np.minimum(u + shift[v, u], z.shape[1] - 1)
        hides = z[v, source] < ahead[v, u] + GHOST_M
        v, u, source = v[hides], u[hides], source[hides]
        part = gray[rows, columns]
        part[v, u] = part[v, source]


def _lit(
    shares: tuple[NDArray[np.float32], NDArray[np.float32]], levels: Levels
) -> NDArray[np.float32]:
    ambient, direct = shares
    lit = cv2.addWeighted(ambient, levels.ambient, direct, levels.lamp, 0.0)
    return np.asarray(lit, np.float32)


def _window_of(mask: NDArray[np.bool_]) -> Window:
    """The smallest window that holds all of a mask, empty if there is none."""
    rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    if rows.size == 0:
        return slice(0, 0), slice(0, 0)
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _clipped(low: float, high: float, focal: float, centre: float, side: int) -> tuple[int, int]:
    """Pixels between two directions, within the image."""
    first, last = np.clip([low * focal + centre, high * focal + centre + 1.0], 0, side)
    return int(first), int(last)


def _soft(
    normals: NDArray[np.float32], inside: NDArray[np.bool_], blur_px: float
) -> NDArray[np.float32]:
    """[h, w, 3] normals averaged over neighbours inside of a mask, so that skin and cloth look
    smooth where two pieces of flesh meet."""
    blurred = cv2.GaussianBlur(normals * inside[..., None], (0, 0), blur_px)
    length = np.sqrt(np.einsum("hwi,hwi->hw", blurred, blurred))
    return np.where(inside[..., None], blurred / np.maximum(length, 1e-6)[..., None], normals)
