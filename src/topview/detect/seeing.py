"""A frame's colour image as detectors look at it: small, in YUV, and judged for its light."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, Frame

# Ours: a hand of 9 cm at 4 m is then 6 pixels wide, which is enough for an ellipse.
TARGET_FOCAL_LENGTH_PX: Final = 262.5

# All ours, of 255 levels: real cameras' grey images spread by less than this around one colour
# (JPEG, noise); fewer pixels than a tenth lighter than this leave no colour to tell skin by; and
# light of which this share of the image is clipped has lost it.
GREY_SPREAD: Final = 6.0
DARK_LEVEL: Final = 40.0
CLIPPED_LEVEL: Final = 250
CLIPPED_SHARE: Final = 0.4
JUDGED_STRIDE: Final = 4


class Light(StrEnum):
    """Whether the colours of an image can tell skin, and if not, why."""

    USABLE = "usable"
    GREY = "the colour image is grey or of a single tint"
    UNDEREXPOSED = "the colour image is underexposed"
    OVEREXPOSED = "the colour image is overexposed"
    ABSENT = "there is no colour image"


@dataclass(frozen=True, slots=True, eq=False)
class ColorView:
    """A frame with its colour, averaged over `stride` x `stride` pixels.

    Attributes:
        frame: where it comes from.
        stride: full pixels per small pixel, in both directions.
        camera: intrinsics of the small images.
        rgb: [h, w, 3] uint8.
        yuv: [h, w, 3] uint8; U and V are 128 where there is no colour.
        depth_m: [h, w] float32, every `stride`-th reading, 0 where there is none.
        light: whether the colours can tell skin.
    """

    frame: Frame
    stride: int
    camera: Camera
    rgb: NDArray[np.uint8]
    yuv: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    light: Light

    @classmethod
    def from_frame(cls, frame: Frame) -> ColorView | None:
        """None where the frame has no colour image."""
        if frame.color is None:
            return None
        full = frame.camera
        stride = max(1, round(full.fx / TARGET_FOCAL_LENGTH_PX))
        stride = min(stride, full.width, full.height)
        width, height = full.width // stride, full.height // stride
        rows, columns = slice(0, height * stride), slice(0, width * stride)
        rgb = frame.color[rows, columns]
        if stride > 1:
            small = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA)
            rgb = np.asarray(small, np.uint8)
        center = (stride - 1) / 2
        camera = Camera(
            full.fx / stride,
            full.fy / stride,
            (full.cx - center) / stride,
            (full.cy - center) / stride,
            width,
            height,
        )
        yuv = np.asarray(cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2YUV), np.uint8)
        depth_m = frame.depth_m[rows, columns][::stride, ::stride]
        return cls(
            frame, stride, camera, rgb, yuv, np.ascontiguousarray(depth_m), light_of(rgb, yuv)
        )

    def full_px(self, small_px: NDArray[np.floating]) -> NDArray[np.floating]:
        """Places in the full image of [..., 2] places (x, y) in the small one."""
        return small_px * self.stride + (self.stride - 1) / 2

    def points_camera(
        self, pixels: NDArray[np.floating], depth_m: NDArray[np.floating]
    ) -> NDArray[np.float64]:
        """[N, 3] metres of [N, 2] small pixels (x, y) at [N] depths."""
        camera = self.camera
        return np.stack(
            [
                (pixels[..., 0] - camera.cx) / camera.fx * depth_m,
                (pixels[..., 1] - camera.cy) / camera.fy * depth_m,
                np.asarray(depth_m, np.float64),
            ],
            axis=-1,
        )


def light_of(rgb: NDArray[np.uint8], yuv: NDArray[np.uint8]) -> Light:
    """Judge [h, w, 3] images; what is exactly black has no pixel of the colour camera."""
    few = slice(None, None, JUDGED_STRIDE)
    pixels = rgb[few, few].reshape(-1, 3)
    is_there = pixels.any(axis=1)
    if not is_there.any():
        return Light.UNDEREXPOSED
    y, u, v = yuv[few, few].reshape(-1, 3)[is_there].T
    if (y < DARK_LEVEL).mean() > 0.9:
        return Light.UNDEREXPOSED
    if (pixels[is_there].min(axis=1) >= CLIPPED_LEVEL).mean() > CLIPPED_SHARE:
        return Light.OVEREXPOSED
    low, high = np.percentile(np.stack([u, v]), (1, 99), axis=1)
    return Light.GREY if (high - low).max() <= GREY_SPREAD else Light.USABLE
