"""One frame at every resolution that the tracker uses, each computed once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.undistortion import undistorted
from topview.kernels.scene import thin
from topview.records import Camera, Frame, read_only


@dataclass(frozen=True, slots=True, eq=False)
class DepthView:
    """A depth image and its intrinsics, as the kernels take them.

    Attributes:
        depth_m: [H, W] float32, 0 without a reading.
        fx, fy, cx, cy: intrinsics of this image in pixels.
    """

    depth_m: NDArray[np.float32]
    fx: float
    fy: float
    cx: float
    cy: float

    def points(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """[N, 3] points_camera in metres of [N] pixels."""
        z = self.depth_m[rows, columns].astype(np.float64)
        x, y = (columns - self.cx) * z / self.fx, (rows - self.cy) * z / self.fy
        return np.stack([x, y, z], axis=1)

    def nearest_pixels(
        self, points_camera: NDArray[np.float64], nearest_m: float
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """[N] rows and columns of the pixels at which [N, 3] points in metres are seen, and which
        of them are in the image; 0 for the others.

        Args:
            points_camera: what is nearer to the camera than `nearest_m` is taken to be there.
            nearest_m: above 0.
        """
        x, y, z = np.asarray(points_camera, np.float64).T
        z = np.maximum(z, nearest_m)
        columns = np.rint(self.fx * x / z + self.cx).astype(np.intp)
        rows = np.rint(self.fy * y / z + self.cy).astype(np.intp)
        height, width = self.depth_m.shape
        is_inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        return np.where(is_inside, rows, 0), np.where(is_inside, columns, 0), is_inside

    def cell_m(self, distance_m: float) -> float:
        """Side of a top-view cell: the distance between neighbouring points there (Sec. 3.1)."""
        return distance_m / min(self.fx, self.fy)


class Pyramid:
    """A frame and its thinned images; pixel (i, j) at a `stride` is full pixel (i, j) * stride, so
    that no depth is ever a mean of two surfaces.

    Attributes:
        frame: the full resolution, undistorted.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = undistorted(frame)
        self._made: dict[tuple[str, int], Any] = {}

    @property
    def full(self) -> DepthView:
        """The depth of every pixel."""
        return self.view(1)

    def camera(self, stride: int) -> Camera:
        """Of the thinned image."""
        return _thinned_camera(self.frame.camera, stride)

    def depth_m(self, stride: int) -> NDArray[np.float32]:
        """[h, w] readings, 0 for none."""
        return self._once("depth", stride, lambda: thinned(self.frame.depth_m, stride))

    def smooth_depth_m(self, stride: int) -> NDArray[np.float32]:
        """[h, w] readings, each the median of its 3 x 3 thinned neighbours."""
        return self._once(
            "smooth",
            stride,
            lambda: np.asarray(cv2.medianBlur(self.depth_m(stride), 3), np.float32),
        )

    def view(self, stride: int) -> DepthView:
        """The depth with its intrinsics."""
        full = self.frame.camera
        return self._once(
            "view",
            stride,
            lambda: DepthView(
                self.depth_m(stride),
                full.fx / stride,
                full.fy / stride,
                full.cx / stride,
                full.cy / stride,
            ),
        )

    def _once(self, what: str, stride: int, make: Callable[[], Any]) -> Any:
        key = what, stride
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]


@lru_cache(maxsize=8)
def _thinned_camera(full: Camera, stride: int) -> Camera:
    return replace(
        full,
        fx=full.fx / stride,
        fy=full.fy / stride,
        cx=full.cx / stride,
        cy=full.cy / stride,
        width=-(-full.width // stride),
        height=-(-full.height // stride),
    )


def thinned(depth_m: NDArray[np.float32], stride: int) -> NDArray[np.float32]:
    """[h, w] every `stride`-th pixel of every `stride`-th row of [H, W], contiguous; read-only as
    the frame's own images are, so that no kernel is compiled for both."""
    if stride == 1:
        return read_only(np.ascontiguousarray(depth_m))
    height, width = depth_m.shape
    out = np.empty((-(-height // stride), -(-width // stride)), np.float32)
    thin(depth_m, stride, out)
    return read_only(out)
