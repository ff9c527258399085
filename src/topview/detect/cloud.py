"""A frame's depth image as a small, smoothed, organized cloud, in which people are detected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.kernels.scene import to_points
from topview.records import Camera, Frame

# Ours: an arm of 8 cm at 4 m is then 3 pixels wide, the least that survives a 3 x 3 median.
CLOUD_FOCAL_LENGTH_PX: Final = 140.0
# The nearest reading of a depth camera, metres (Kinect's near mode).
NEAREST_READING_M: Final = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Every `stride`-th pixel of a frame, in both directions, as points.

    Attributes:
        image: the pyramid that it comes from.
        stride: full pixels per cloud pixel; cloud pixel (i, j) is full pixel (i, j) * stride.
        camera: intrinsics of the small image.
        depth_m: [h, w] float32 median-filtered, 0 where there is no reading.
        points_camera: [h, w, 3] float32 metres, zeros where there is no reading.
    """

    image: Pyramid
    stride: int
    camera: Camera
    depth_m: NDArray[np.float32]
    points_camera: NDArray[np.float32]

    @classmethod
    def of(cls, image: Pyramid) -> Cloud:
        stride = stride_of(image.frame.camera)
        depth_m = image.smooth_depth_m(stride)
        camera = image.camera(stride)
        points_camera = np.empty((*depth_m.shape, 3), np.float32)
        to_points(depth_m, (camera.fx, camera.fy), (camera.cx, camera.cy), points_camera)
        return cls(image, stride, camera, depth_m, points_camera)

    @classmethod
    def from_frame(cls, frame: Frame) -> Cloud:
        """The cloud of a frame whose pyramid nothing else shares."""
        return cls.of(Pyramid(frame))

    @property
    def frame(self) -> Frame:
        """The full image."""
        return self.image.frame

    @property
    def has_reading(self) -> NDArray[np.bool_]:
        """[h, w] True where there is a depth."""
        return self.depth_m > 0.0

    def pixel_m(self, point_camera: NDArray[np.float64]) -> float:
        """How broad a pixel is at the depth of a [3] point, metres."""
        return float(point_camera[2]) / self.camera.fx

    def lookup(
        self, points_camera: NDArray[np.floating]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """The depth seen in the direction of each of [3, ...] points, and whether it is in view."""
        row, column, is_inside = self.pixel_of(points_camera)
        return self.depth_m[row, column], is_inside

    def pixel_at(self, point_camera: NDArray[np.floating]) -> tuple[int, int, bool]:
        """As `pixel_of`, of a single [3] point, which is asked of many a head in a frame."""
        x, y, z = point_camera.tolist()
        camera = self.camera
        z = max(z, 1e-3)
        last_row, last_column = camera.height - 1, camera.width - 1
        u = x / z * camera.fx + camera.cx
        v = y / z * camera.fy + camera.cy
        is_inside = -0.5 < u < last_column + 0.5 and -0.5 < v < last_row + 0.5
        return round(min(max(0.0, v), last_row)), round(min(max(0.0, u), last_column)), is_inside

    def pixel_of(
        self, points_camera: NDArray[np.floating]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """Row and column (clipped into the image) of [3, ...] points, and whether it is in view."""
        x, y, z = points_camera
        camera = self.camera
        z = np.maximum(z, 1e-3)
        last_row, last_column = camera.height - 1, camera.width - 1
        u = x / z * camera.fx + camera.cx
        v = y / z * camera.fy + camera.cy
        is_inside = (u > -0.5) & (u < last_column + 0.5) & (v > -0.5) & (v < last_row + 0.5)
        column = np.rint(np.minimum(np.maximum(u, 0.0), last_column)).astype(np.intp)
        row = np.rint(np.minimum(np.maximum(v, 0.0), last_row)).astype(np.intp)
        return row, column, is_inside


def stride_of(camera: Camera) -> int:
    """Full pixels per pixel of the cloud."""
    return max(1, round(camera.fx / CLOUD_FOCAL_LENGTH_PX))
