"""Colour images: Lambert shading with soft shadows under the feet, and a camera's noise."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.sim.images import FURNITURE, ROOM, Rendering

AMBIENT: Final = 0.36
"""Share of the light that comes from everywhere (ours)."""
LAMP_ROOM: Final = (-0.45, -0.62, 0.64)
"""Direction towards the lamp in the room frame: above, to the left, behind the camera (ours)."""
NOISE_LEVELS: Final = 2.2
"""Standard deviation of the colour camera's noise in grey levels of 255 (ours)."""
BLUR_PX: Final = 0.45
"""Blur of the colour camera's lens and mosaic (ours)."""
SOFT_SHARE: Final = 1.3 / 240
"""Blur of the people's normals as a share of the image's height (ours)."""
SHADOW_M: Final = 0.17
"""Size of the shadow under a foot (ours)."""
SHADOW_DEPTH: Final = 0.7
"""Share of the light that is missing right under a foot (ours)."""


def shade(
    rendering: Rendering,
    rays: NDArray[np.float32],
    R_camera_room: NDArray[np.float64],
    feet_camera: NDArray[np.float64],
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    """[H, W, 3] uint8 RGB.

    Args:
        rendering: the ideal images.
        rays: [H, W, 3] the pixels' rays, z = 1.
        R_camera_room: [3, 3].
        feet_camera: [N, 3] the middles of the feet, metres.
        rng: of the noise.
    """
    lamp = (R_camera_room @ LAMP_ROOM).astype(np.float32)
    up = R_camera_room[:, 2].astype(np.float32)
    normals = _soft_normals(rendering)
    direct = np.maximum(normals @ (lamp / np.linalg.norm(lamp)), 0.0)
    sky = 0.8 + 0.2 * (normals @ up)
    light = AMBIENT * sky + (1.0 - AMBIENT) * direct
    light *= _foot_shadows(rendering, rays, up, feet_camera)
    linear = np.clip(1.25 * rendering.albedo * light[..., None], 0.0, 1.0)
    levels = cv2.GaussianBlur(255.0 * np.sqrt(linear), (0, 0), BLUR_PX)  # gamma 2, about sRGB's
    levels += NOISE_LEVELS * rng.standard_normal(levels.shape, np.float32)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def _soft_normals(rendering: Rendering) -> NDArray[np.float32]:
    """[H, W, 3] normals, averaged over neighbours on the people, so that skin and cloth look
    smooth where two pieces of flesh meet."""
    is_person = (rendering.instance > ROOM) & (rendering.instance < FURNITURE)
    normals = rendering.normals.copy()
    rows, columns = np.nonzero(is_person)
    if rows.size == 0:
        return normals
    window = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    inside = is_person[window]
    blurred = cv2.GaussianBlur(
        normals[window] * inside[..., None], (0, 0), SOFT_SHARE * len(normals)
    )
    length = np.linalg.norm(blurred, axis=-1, keepdims=True)
    normals[window] = np.where(
        inside[..., None], blurred / np.maximum(length, 1e-6), normals[window]
    )
    return normals


def _foot_shadows(
    rendering: Rendering,
    rays: NDArray[np.float32],
    up: NDArray[np.float32],
    feet_camera: NDArray[np.float64],
) -> NDArray[np.float32]:
    """[H, W] share of the light that reaches the floor beside the feet, 1 elsewhere."""
    light = np.ones(rendering.depth_m.shape, np.float32)
    is_floor = (rendering.instance == ROOM) & (rendering.normals @ up > 0.9)
    floor = rays[is_floor] * rendering.depth_m[is_floor, None]
    feet = feet_camera.astype(np.float32)
    distance2 = np.einsum("ni,ni->n", floor, floor)[:, None] - 2.0 * floor @ feet.T
    distance2 += np.einsum("ni,ni->n", feet, feet)
    kept = 1.0 - SHADOW_DEPTH * np.exp(-0.5 / SHADOW_M**2 * distance2)
    light[is_floor] = np.multiply.reduce(kept.T, axis=0)
    return light
