"""Images as a pinhole camera would have taken them, through a look-up made once for a camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.lens import distort, undistort
from topview.records import Camera, Frame, InputError, read_only

# Ours: the undistorted image goes on beyond the original's by this share of its size at most, on
# each side; of the Azure Kinect's widest field of view it takes 0.36.
MAX_GROWTH: Final = 0.5
EVERY_PX: Final = 8  # ours: rays of so many pixels tell how large the undistorted image is


@dataclass(frozen=True, slots=True, eq=False)
class Undistortion:
    """The look-up from the pixels of a pinhole camera to those of one with a lens.

    Attributes:
        camera: the pinhole camera: the same focal lengths, and an image that shows all that the
            original does.
        at_px: [2, H, W] float32 column and row in the original, NaN where the lens's model says
            nothing.
        nearest: [H, W] flat index of the nearest original pixel, 0 where there is none.
        is_unseen: [H, W] where there is none.
    """

    camera: Camera
    at_px: NDArray[np.float32]
    nearest: NDArray[np.intp]
    is_unseen: NDArray[np.bool_]

    def depth(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """[H, W] metres of an original's; readings are taken as they are, never mixed."""
        undistorted_m = depth_m.ravel()[self.nearest]
        undistorted_m[self.is_unseen] = 0.0
        return undistorted_m

    def color(self, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """[H, W, 3] of an original's, interpolated; black where it shows nothing."""
        image = _sampled(color, self.at_px).astype(np.uint8, copy=False)
        image[self.is_unseen] = 0
        return image

    def original_px(self, places_px: NDArray[np.float32]) -> NDArray[np.float32]:
        """[2, H', W'] where the original shows what is at places of the pinhole image, [2, H', W'];
        NaN where it does not."""
        seen = [_sampled(at_px, places_px) for at_px in self.at_px]
        last = np.array([self.camera.width, self.camera.height])[:, None, None] - 0.5
        is_inside = ((places_px >= -0.5) & (places_px < last)).all(0)
        return np.where(is_inside, np.stack(seen), np.nan).astype(np.float32)


def undistorted_camera(camera: Camera) -> Camera:
    """The pinhole camera of the undistorted images; the camera itself if it is one."""
    if camera.is_pinhole:
        return camera
    return replace(
        undistortion(camera).camera,
        T_world_camera=camera.T_world_camera,
        gravity_camera=camera.gravity_camera,
    )


def undistorted(frame: Frame) -> Frame:
    """The frame as a pinhole camera would have taken it; itself if one has."""
    if frame.camera.is_pinhole:
        return frame
    look_up = undistortion(frame.camera)
    return replace(
        frame,
        depth_m=look_up.depth(frame.depth_m),
        camera=undistorted_camera(frame.camera),
        color=None if frame.color is None else look_up.color(frame.color),
    )


def undistortion(camera: Camera) -> Undistortion:
    """The look-up of a camera with a lens, made when it is first asked for.

    Raises:
        InputError: no pixel has a ray by the lens's model.
    """
    return _undistortion(replace(camera, T_world_camera=None, gravity_camera=None))


@lru_cache(maxsize=8)
def _undistortion(camera: Camera) -> Undistortion:
    pinhole = _pinhole(camera)
    rows, columns = np.mgrid[: pinhole.height, : pinhole.width]
    ideal = np.stack(
        [(columns - pinhole.cx) / pinhole.fx, (rows - pinhole.cy) / pinhole.fy], axis=-1
    )
    x, y = np.moveaxis(distort(ideal, camera.distortion), -1, 0)
    at_px = np.stack([camera.fx * x + camera.cx, camera.fy * y + camera.cy])
    with np.errstate(invalid="ignore"):
        column, row = np.rint(at_px)
        is_seen = (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
    nearest = np.where(is_seen, row * camera.width + column, 0.0).astype(np.intp)
    return Undistortion(
        pinhole, read_only(at_px.astype(np.float32)), read_only(nearest), read_only(~is_seen)
    )


def _pinhole(camera: Camera) -> Camera:
    """Of the same focal lengths, with an image that shows all that the camera's does."""
    columns, rows = np.meshgrid(_some(camera.width), _some(camera.height))
    seen = np.stack([(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy], axis=-1)
    ideal = undistort(seen, camera.distortion)
    ideal = ideal[np.isfinite(ideal).all(-1)]
    if not len(ideal):
        raise InputError(
            f"camera distortion {camera.distortion} leaves no pixel a ray; "
            "it must be in OpenCV's order, k1 k2 p1 p2 k3 k4 k5 k6, for normalised places"
        )
    left, right = _extent(camera.fx * ideal[:, 0] + camera.cx, camera.width)
    top, bottom = _extent(camera.fy * ideal[:, 1] + camera.cy, camera.height)
    return replace(
        camera,
        cx=camera.cx - left,
        cy=camera.cy - top,
        width=right - left + 1,
        height=bottom - top + 1,
        distortion=None,
    )


def _sampled(image: NDArray[Any], at_px: NDArray[np.float32]) -> NDArray[Any]:
    """[H', W', ...] an image at places [2, H', W'], interpolated; beyond its border as on it."""
    column, row = at_px
    border = cv2.BORDER_REPLICATE
    return np.asarray(cv2.remap(image, column, row, cv2.INTER_LINEAR, borderMode=border))


def _some(size_px: int) -> NDArray[np.int64]:
    """Every few of so many pixels, the last included."""
    return np.append(np.arange(0, size_px - 1, EVERY_PX), size_px - 1)


def _extent(places_px: NDArray[np.float64], size_px: int) -> tuple[int, int]:
    """The first and the last pixel of an image that shows all places, within limits."""
    most_px = int(MAX_GROWTH * size_px)
    first = max(round(float(places_px.min())), -most_px)
    last = min(round(float(places_px.max())), size_px - 1 + most_px)
    return first, max(first, last)
