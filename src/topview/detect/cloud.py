"""A frame's depth image as a small, smoothed, organized cloud: what people are sought in."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, Frame

# Ours: an arm of 8 cm at 4 m is then 3 pixels wide, the least that survives a 3 x 3 median.
TARGET_FOCAL_LENGTH_PX = 140.0
# One standard deviation of a Kinect's depth is about this times z^2 (Khoshelham & Elberink 2012).
NOISE_PER_SQUARE_M = 0.0015


def depth_noise_m(depth_m: NDArray[np.floating]) -> NDArray[np.floating]:
    """Standard deviation of a depth reading, in metres; grows with the square of the depth."""
    return NOISE_PER_SQUARE_M * depth_m * depth_m


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Every `stride`-th pixel of a frame, in both directions, as points.

    Attributes:
        frame: where it comes from.
        stride: full pixels per cloud pixel; cloud pixel (i, j) is full pixel (i, j) * stride.
        camera: intrinsics of the small image.
        depth_m: [h, w] float32 median-filtered, 0 where there is no reading.
        points_camera: [h, w, 3] float32 metres, zeros where there is no reading.
    """

    frame: Frame
    stride: int
    camera: Camera
    depth_m: NDArray[np.float32]
    points_camera: NDArray[np.float32]

    @classmethod
    def from_frame(cls, frame: Frame) -> Cloud:
        stride = max(1, round(frame.camera.fx / TARGET_FOCAL_LENGTH_PX))
        depth_m = cv2.medianBlur(np.ascontiguousarray(frame.depth_m[::stride, ::stride]), 3)
        height, width = depth_m.shape
        full = frame.camera
        camera = Camera(
            full.fx / stride, full.fy / stride, full.cx / stride, full.cy / stride, width, height
        )
        x = (np.arange(width, dtype=np.float32) - np.float32(camera.cx)) / np.float32(camera.fx)
        y = (np.arange(height, dtype=np.float32) - np.float32(camera.cy)) / np.float32(camera.fy)
        points_camera = np.empty((height, width, 3), np.float32)
        np.multiply(depth_m, x, out=points_camera[..., 0])
        np.multiply(depth_m, y[:, None], out=points_camera[..., 1])
        points_camera[..., 2] = depth_m
        return cls(frame, stride, camera, depth_m, points_camera)

    @property
    def has_reading(self) -> NDArray[np.bool_]:
        """[h, w] True where there is a depth."""
        return self.depth_m > 0.0

    def lookup(
        self, points_camera: NDArray[np.floating]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """The depth seen in the direction of each of [..., 3] points, and whether it is in view."""
        row, column, is_inside = self.pixel_of(points_camera)
        return self.depth_m[row, column], is_inside

    def pixel_of(
        self, points_camera: NDArray[np.floating]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """Row and column (clipped into the image) of [..., 3] points, and whether it is in view."""
        z = np.maximum(points_camera[..., 2], 1e-3)
        u = points_camera[..., 0] / z * self.camera.fx + self.camera.cx
        v = points_camera[..., 1] / z * self.camera.fy + self.camera.cy
        height, width = self.depth_m.shape
        column = np.clip(np.rint(u), -1, width).astype(np.intp)
        row = np.clip(np.rint(v), -1, height).astype(np.intp)
        is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1), is_inside
