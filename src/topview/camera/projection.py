"""Pinhole projection and its inverse (camera frame: x right, y down, z forward)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera


def pixel_rays(camera: Camera) -> NDArray[np.float32]:
    """[H, W, 3] direction of each pixel's ray, scaled to z = 1 (not to unit length)."""
    rays = np.empty((camera.height, camera.width, 3), np.float32)
    rays[..., 0] = (np.arange(camera.width) - camera.cx) / camera.fx
    rays[..., 1] = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    rays[..., 2] = 1.0
    return rays


def unproject_depth(depth_m: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
    """[H, W] depth in metres to [H, W, 3] points_camera; pixels without a reading become zeros."""
    return pixel_rays(camera) * depth_m[..., None]


def project(points_camera: NDArray[np.floating], camera: Camera) -> NDArray[np.float64]:
    """[..., 3] points in metres to [..., 2] pixels (u right, v down); points behind the camera
    (z <= 0) become NaN."""
    x, y, z = np.moveaxis(np.asarray(points_camera, np.float64), -1, 0)
    z = np.where(z > 0.0, z, np.nan)
    return np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=-1)
