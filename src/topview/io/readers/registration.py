"""Colour images of a camera of its own, brought to the depth image's pixels.

As the sensors' own software does it (librealsense's `align` to depth, the Azure Kinect's
`color_image_to_depth_camera`): each depth pixel's point is projected into the colour image, whose
colour there is taken. Both leave pixels without a reading black, and give what the colour camera
cannot see the colour of what hides it. Here

- a pixel without a reading is taken to lie as far as what is behind its surroundings, since colour
  is the only evidence there;
- a pixel that the colour camera cannot see, because something nearer hides it or it is out of its
  view, is black.

A colour camera with a lens is taken for the pinhole camera of its undistorted image; what is found
there is then looked up in the image as it was taken, so that colours are interpolated once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.camera import undistorted_camera, undistortion
from topview.kernels.registration import fill_from_behind, locate_pixels
from topview.records import Camera, read_only

# Ours: rows without any reading are looked up without parallax.
FAR_M: Final = 100.0
# Ours: nearer surfaces hide; steps of a floor seen at a flat angle, which grow with the square of
# the distance, do not: parallax between two cameras of one sensor is then below a fifth of a pixel.
OCCLUDING_M: Final = 0.03
OCCLUDING_PER_SQUARE_M: Final = 0.01
MIN_CELL_PX: Final = 0.25  # ours; depth images are not that much finer


@dataclass(frozen=True, slots=True, eq=False)
class ColorCamera:
    """The camera that the colour images come from: intrinsics, and [4, 4] T_color_depth."""

    camera: Camera
    T_color_depth: NDArray[np.float64]

    def __post_init__(self) -> None:
        read_only(self.T_color_depth)


def register_color(
    color: NDArray[np.uint8],
    color_camera: ColorCamera,
    depth_m: NDArray[np.float32],
    camera: Camera,
) -> NDArray[np.uint8]:
    """[H, W, 3] the colour at each pixel of the depth image, black where it was not seen.

    Args:
        color: of the colour camera's size.
        color_camera: what took it.
        depth_m: [H, W] metres, 0 where there is no reading.
        camera: of the depth image, a pinhole.
    """
    taken = color_camera.camera
    other = undistorted_camera(taken)
    cell_px = max(other.fx / camera.fx, MIN_CELL_PX), max(other.fy / camera.fy, MIN_CELL_PX)
    cells = ceil(other.height / cell_px[1]) + 1, ceil(other.width / cell_px[0]) + 1
    filled_m = np.empty_like(depth_m)
    fill_from_behind(depth_m, FAR_M, filled_m)
    at_px = np.empty((2, *depth_m.shape), np.float32)
    locate_pixels(
        filled_m,
        depth_m > 0.0,
        (camera.fx, camera.fy),
        (camera.cx, camera.cy),
        color_camera.T_color_depth,
        (other.fx, other.fy),
        (other.cx, other.cy),
        (other.width, other.height),
        cell_px,
        OCCLUDING_M,
        OCCLUDING_PER_SQUARE_M,
        np.full(cells, np.inf, np.float32),
        np.empty_like(depth_m),
        at_px,
    )
    if not taken.is_pinhole:
        at_px = _as_taken(at_px, taken)
    registered = cv2.remap(color, at_px[0], at_px[1], cv2.INTER_LINEAR)  # black beyond its border
    return registered.astype(np.uint8, copy=False)


def _as_taken(at_px: NDArray[np.float32], taken: Camera) -> NDArray[np.float32]:
    """[2, H, W] places of the undistorted image in the image as it was taken; -2 out of view."""
    seen_px = undistortion(taken).original_px(at_px)
    last_px = np.array([taken.width, taken.height], np.float32)[:, None, None] - 1.0
    is_seen = ((seen_px >= -0.5) & (seen_px < last_px + 0.5)).all(0)
    clipped = np.minimum(np.maximum(seen_px, 0.0), last_px)
    return np.where(is_seen, clipped, np.float32(-2.0))
