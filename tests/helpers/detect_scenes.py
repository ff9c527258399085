"""Synthetic frames for the tests of the detectors: coloured discs before a wall."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.color_view import ColorView
from topview.detect.ellipses import Moments
from topview.detect.skin import SkinRegion
from topview.kernels.skin import moments
from topview.records import Camera, Frame

CAMERA = Camera(262.5, 262.5, 79.5, 59.5, 160, 120)
WALL_M = 3.0
WALL_RGB = (120, 130, 125)
SKIN_RGB = (200, 140, 110)
SHIRT_RGB = (40, 60, 140)

Disc = tuple[float, float, float, float, tuple[int, int, int]]
"""x, y, radius in pixels, depth in metres, colour."""


def frame_of(
    discs: Iterable[Disc] = (),
    *,
    index: int = 0,
    fps: float = 30.0,
    gain: float = 1.0,
    noise: float = 1.5,
    camera: Camera = CAMERA,
) -> Frame:
    """Discs before a wall; the later hide the earlier. `gain` is the lamp's, on the wall too."""
    rng = np.random.default_rng(index)
    rgb = np.empty((camera.height, camera.width, 3), np.float32)
    rgb[:] = WALL_RGB
    depth_m = np.full(rgb.shape[:2], WALL_M, np.float32)
    rows, columns = np.mgrid[: camera.height, : camera.width]
    for x, y, radius, z, color in discs:
        inside = np.hypot(columns - x, rows - y) <= radius
        rgb[inside], depth_m[inside] = color, z
    depth_m += (camera.noise.sigma_m(depth_m) * rng.standard_normal(depth_m.shape)).astype(
        np.float32
    )
    rgb = gain * rgb + noise * rng.standard_normal(rgb.shape, np.float32)
    color = np.clip(np.rint(rgb), 0, 255).astype(np.uint8)
    return Frame(index, index / fps, depth_m, camera, color)


def view_of(frame: Frame) -> ColorView:
    view = ColorView.from_frame(frame)
    assert view is not None
    return view


def regions_of(mask: NDArray[np.bool_], depth_m: float) -> list[SkinRegion]:
    """The connected regions of a mask."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8))
    regions = []
    for label in range(1, count):
        rows, columns = np.nonzero(np.asarray(labels) == label)
        pixels = np.stack([columns, rows], axis=1).astype(np.float32)
        box = int(columns.min()), int(rows.min()), int(columns.max()), int(rows.max())
        regions.append(SkinRegion(pixels, box, depth_m, 0.01, 0.9, Moments(*moments(pixels))))
    return regions
