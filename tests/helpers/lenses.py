"""Lenses as real cameras have them, by the name of their model, and depth images through them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.camera import pixel_rays
from topview.records import Camera, Distortion

LENSES = {
    "brown_conrady": Distortion("brown_conrady", (-0.28, 0.09, 0.0012, -0.0008)),
    # A Kinect v2's depth camera.
    "brown_conrady_5": Distortion("brown_conrady", (0.0905, -0.2682, 0.0011, 0.0007, 0.0951)),
    # An Azure Kinect's depth camera.
    "rational": Distortion(
        "rational", (3.1306, 2.3249, 8.1e-5, -5.1e-5, 0.1304, 3.4587, 3.3501, 0.6629)
    ),
    # About as strong as that of a RealSense D455's colour camera.
    "inverse_brown_conrady": Distortion(
        "inverse_brown_conrady", (-0.0556, 0.0652, -0.0006, 0.0006, -0.0209)
    ),
}


def camera_with(lens: Distortion | None, **other) -> Camera:
    """320 x 240, 75 degrees wide, principal point off the middle."""
    return Camera(210.0, 211.0, 157.3, 121.6, 320, 240, lens, **other)


def plane_depth(
    camera: Camera, normal: tuple[float, float, float], distance_m: float
) -> NDArray[np.float32]:
    """[H, W] depth of the plane of points p with normal @ p = distance, through the lens."""
    depth_m = distance_m / (pixel_rays(camera).astype(np.float64) @ normal)
    return np.nan_to_num(depth_m).astype(np.float32)
