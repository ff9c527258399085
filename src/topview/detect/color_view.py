"""The colour view of a frame: its colour image made small, in YUV, and judged for its light."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, lru_cache
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.kernels.skin import count_lights
from topview.records import Camera, Frame, read_only

Mask = NDArray[np.bool_]
Place = tuple[float, float, float]

# Ours: a hand of 9 cm at 4 m is then 6 pixels wide, which is enough for an ellipse.
COLOR_FOCAL_LENGTH_PX: Final = 262.5

# All ours; levels are of 255. The grey images of real cameras spread by less than this around one
# colour (JPEG, noise).
GREY_SPREAD: Final = 6.0
# An image is underexposed if more than this share of its pixels is darker than this level.
DIM_LEVEL: Final = 40.0
DIM_SHARE: Final = 0.9
# An image is overexposed if more than this share of its pixels has all colours at this level.
CLIPPED_LEVEL: Final = 250
CLIPPED_SHARE: Final = 0.4
# The light is judged by every eighth small pixel, in both directions.
JUDGED_STRIDE: Final = 8


class Light(StrEnum):
    """Whether skin can be detected by the colours of an image, and if not, why."""

    USABLE = "usable"
    GREY = "the colour image is grey or of a single tint"
    UNDEREXPOSED = "the colour image is underexposed"
    OVEREXPOSED = "the colour image is overexposed"
    ABSENT = "there is no colour image"


@dataclass(frozen=True, eq=False)
class ColorView:
    """A frame with its colour, averaged over `stride` x `stride` pixels.

    Attributes:
        frame: where it comes from.
        stride: full pixels per small pixel, in both directions.
        camera: intrinsics of the small images.
        color: [h * step, w * step, 3] uint8.
        step: 1, or 2 if the mean of 2 x 2 of its pixels is a small pixel's colour.
        depth_m: [h, w] float32, every `stride`-th reading, 0 where there is none.
        light: whether skin can be detected by the colours.
    """

    frame: Frame
    stride: int
    camera: Camera
    color: NDArray[np.uint8]
    step: int
    depth_m: NDArray[np.float32]
    light: Light

    @classmethod
    def from_frame(cls, frame: Frame) -> ColorView | None:
        """The view of a frame whose pyramid nothing else shares."""
        return cls.of(Pyramid(frame))

    @classmethod
    def of(cls, image: Pyramid) -> ColorView | None:
        """None where the frame has no colour image."""
        frame = image.frame
        if frame.color is None:
            return None
        stride = stride_of_colors(frame.camera)
        camera = _small_camera(frame.camera, stride)
        depth_m = image.depth_m(stride)[: camera.height, : camera.width]
        depth_m = read_only(np.ascontiguousarray(depth_m))
        # Means of more pixels are not made one by one.
        step = stride if stride <= 2 else 1
        color = frame.color if stride <= 2 else averaged(frame.color, stride)
        return cls(frame, stride, camera, color, step, depth_m, light_of(color, step))

    @cached_property
    def rgb(self) -> NDArray[np.uint8]:
        """[h, w, 3]."""
        return averaged(self.color, self.step)

    @cached_property
    def yuv(self) -> NDArray[np.uint8]:
        """[h, w, 3]; U and V are 128 where there is no colour."""
        return np.asarray(cv2.cvtColor(self.rgb, cv2.COLOR_RGB2YUV), np.uint8)

    def small(self, mask: Mask) -> Mask:
        """[h, w] of a mask of this size, or of the full image ([H, W])."""
        height, width = self.depth_m.shape
        if mask.shape == (height, width):
            return mask
        return mask[:: self.stride, :: self.stride][:height, :width]

    def point_camera(self, x: float, y: float, depth_m: float) -> Place:
        """Metres, the point at a depth that is seen at (x, y) of the small image."""
        camera = self.camera
        return (x - camera.cx) / camera.fx * depth_m, (y - camera.cy) / camera.fy * depth_m, depth_m


def stride_of_colors(camera: Camera) -> int:
    """Full pixels per pixel of the view."""
    stride = max(1, round(camera.fx / COLOR_FOCAL_LENGTH_PX))
    return min(stride, camera.width, camera.height)


@lru_cache(maxsize=8)
def _small_camera(full: Camera, stride: int) -> Camera:
    """Of the view: its pixels lie in the middle of those that they average."""
    center = (stride - 1) / 2
    return replace(
        full,
        fx=full.fx / stride,
        fy=full.fy / stride,
        cx=(full.cx - center) / stride,
        cy=(full.cy - center) / stride,
        width=full.width // stride,
        height=full.height // stride,
    )


def averaged(rgb: NDArray[np.uint8], step: int) -> NDArray[np.uint8]:
    """[H // step, W // step, 3] means over `step` x `step` pixels of [H, W, 3]."""
    if step == 1:
        return np.ascontiguousarray(rgb)
    height, width = rgb.shape[0] // step, rgb.shape[1] // step
    whole = rgb[: height * step, : width * step]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def light_of(color: NDArray[np.uint8], step: int) -> Light:
    """Judge a [h * step, w * step, 3] image, averaged over `step` x `step` pixels, 1 or 2; exactly
    black ones are outside of the colour camera's image."""
    count, dim, clipped, spread = count_lights(color, step, JUDGED_STRIDE, DIM_LEVEL, CLIPPED_LEVEL)
    if count == 0 or dim > DIM_SHARE * count:
        return Light.UNDEREXPOSED
    if clipped > CLIPPED_SHARE * count:
        return Light.OVEREXPOSED
    return Light.GREY if spread <= GREY_SPREAD else Light.USABLE
