"""Projection and its inverse, through the camera's lens (camera frame: x right, y down, z
forward)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.camera.lens import distort, undistort
from topview.records import Camera


def pixel_rays(camera: Camera) -> NDArray[np.float32]:
    """[H, W, 3] direction of each pixel's ray, scaled to z = 1 (not to unit length); NaN where the
    lens's model says nothing."""
    rays = np.empty((camera.height, camera.width, 3), np.float32)
    rays[..., 0] = (np.arange(camera.width) - camera.cx) / camera.fx
    rays[..., 1] = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    if not camera.is_pinhole:
        rays[..., :2] = undistort(rays[..., :2], camera.distortion)
    rays[..., 2] = 1.0
    return rays


def unproject_depth(depth_m: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
    """[H, W] depth in metres to [H, W, 3] points_camera; pixels without a reading, or without a ray
    by the lens's model, become zeros."""
    points = pixel_rays(camera) * depth_m[..., None]
    return points if camera.is_pinhole else np.nan_to_num(points, copy=False)


def project(points_camera: NDArray[np.floating], camera: Camera) -> NDArray[np.float64]:
    """[..., 3] points in metres to [..., 2] pixels (u right, v down); points behind the camera
    (z <= 0) become NaN."""
    x, y, z = np.moveaxis(np.asarray(points_camera, np.float64), -1, 0)
    z = np.where(z > 0.0, z, np.nan)
    if not camera.is_pinhole:
        seen = distort(np.stack([x / z, y / z], axis=-1), camera.distortion)
        return seen * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    return np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=-1)
