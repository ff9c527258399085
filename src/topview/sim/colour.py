"""Colour images: Lambert shading with soft shadows under the feet, and a camera's noise."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.sim.render import Rendering

AMBIENT: Final = 0.42
"""Share of the light that comes from everywhere (ours)."""
LAMP_ROOM: Final = (-0.45, -0.62, 0.64)
"""Direction towards the lamp in the room frame: above, to the left, behind the camera (ours)."""
NOISE_LEVELS: Final = 2.2
"""Standard deviation of the colour camera's noise in grey levels of 255 (ours)."""
BLUR_PX: Final = 0.45
"""Blur of the colour camera's lens and mosaic (ours)."""
GAMMA: Final = 1.0 / 2.2
SHADOW_M: Final = 0.16
"""Size of the shadow under a foot (ours)."""


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
        feet_camera: [N, 3] the points that stand on the floor, metres.
        rng: of the noise.
    """
    lamp = (R_camera_room @ LAMP_ROOM).astype(np.float32)
    up = R_camera_room[:, 2].astype(np.float32)
    direct = np.maximum(rendering.normals @ (lamp / np.linalg.norm(lamp)), 0.0)
    sky = 0.8 + 0.2 * (rendering.normals @ up)
    light = AMBIENT * sky + (1.0 - AMBIENT) * direct
    light *= _foot_shadows(rendering, rays, up, feet_camera)
    linear = np.clip(1.25 * rendering.albedo * light[..., None], 0.0, 1.0)
    levels = cv2.GaussianBlur(255.0 * linear**GAMMA, (0, 0), BLUR_PX)
    levels += NOISE_LEVELS * rng.standard_normal(levels.shape, np.float32)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def _foot_shadows(
    rendering: Rendering,
    rays: NDArray[np.float32],
    up: NDArray[np.float32],
    feet_camera: NDArray[np.float64],
) -> NDArray[np.float32]:
    """[H, W] share of the light that reaches the floor beside the feet, 1 elsewhere."""
    light = np.ones(rendering.depth_m.shape, np.float32)
    rows, columns = np.nonzero((rendering.normals @ up > 0.9) & (rendering.instance == 0))
    floor = rays[rows, columns] * rendering.depth_m[rows, columns, None]
    for foot in feet_camera.astype(np.float32):
        distance2 = ((floor - foot) ** 2).sum(-1)
        light[rows, columns] *= 1.0 - 0.6 * np.exp(-0.5 * distance2 / SHADOW_M**2)
    return light
