"""Markers found by their colour in one view, placed in 3D by the depth image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, Frame, InputError, read_only

GREY: Final = 1.0 / 3.0
"""Share of red (green, blue) in the brightness of everything grey."""
LEAST_CHROMA: Final = 0.10
"""Least distance of a marker's colour from grey, in the plane of the shares of red and green
(ours). Pure red has 0.75, skin about 0.1."""
COLOR_REACH: Final = 0.45
"""A pixel belongs to a marker if their colours are closer than this share of the marker's distance
from grey (ours)."""
LEAST_COLOR_LEVEL: Final = 25.0
"""Mean of red, green and blue below which a pixel has no reliable colour (ours)."""
LEAST_SPOT_PIXELS: Final = 4
"""Smaller spots are no markers (ours)."""
LEAST_RADIUS_RATIO, GREATEST_RADIUS_RATIO = 0.35, 1.6
"""Radius of a spot over the marker's: less where part of a marker is hidden, more where colours
run (ours)."""
GREATEST_STRETCH: Final = 3.0
"""Breadth over height of a spot, or height over breadth (ours)."""


@dataclass(frozen=True, slots=True)
class MarkerAppearance:
    """Appearance of a marker: its colour (0..255) and its radius."""

    red: int
    green: int
    blue: int
    radius_m: float

    @property
    def rgb(self) -> tuple[int, int, int]:
        return self.red, self.green, self.blue


@dataclass(frozen=True, slots=True, eq=False)
class Blobs:
    """N spots in one image: [N, 2] pixels, [N, 3] metres in the camera frame, [N] radii."""

    pixels: NDArray[np.float64]
    points_camera: NDArray[np.float64]
    radii_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            read_only(getattr(self, name))

    def __len__(self) -> int:
        return len(self.pixels)

    @classmethod
    def none(cls) -> Blobs:
        return cls(np.zeros((0, 2)), np.zeros((0, 3)), np.zeros(0))


def find_blobs(frame: Frame, looks: Sequence[MarkerAppearance]) -> Blobs:
    """The spots of the markers' colours that have a marker's size in metres."""
    if frame.color is None:
        return Blobs.none()
    found = [
        spot
        for look in looks
        for spot in _spots(frame, color_mask(frame.color, look))
        if LEAST_RADIUS_RATIO <= spot[5] / look.radius_m <= GREATEST_RADIUS_RATIO
        and spot[6] <= GREATEST_STRETCH
    ]
    if not found:
        return Blobs.none()
    table = np.array(found)
    return Blobs(table[:, :2].copy(), table[:, 2:5].copy(), table[:, 5].copy())


def pick_marker(frame: Frame, u: float, v: float) -> MarkerAppearance:
    """The appearance of the marker at a pixel.

    Raises:
        InputError: outside the image, no colour there to tell, no depth, or no marker's size.
    """
    where = f"the pixel at ({u:.0f}, {v:.0f})"
    if frame.color is None:
        raise InputError(f"{where} has no colour; the recordings must have rgb/")
    height, width = frame.color.shape[:2]
    if not (0 <= u < width and 0 <= v < height):
        raise InputError(f"{where} is outside of the image of {width} x {height}")
    row, column = int(v), int(u)
    patch = frame.color[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    red, green, blue = (int(value) for value in np.median(patch.reshape(-1, 3), axis=0))
    unsized = MarkerAppearance(red, green, blue, 1.0)
    if chroma_of(unsized) < LEAST_CHROMA:
        raise InputError(
            f"{where} is rgb({red}, {green}, {blue}), which is nearly grey; "
            "click the middle of a marker with a strong colour"
        )
    mask = color_mask(frame.color, unsized)
    _, labels = cv2.connectedComponents(mask.astype(np.uint8))
    label = labels[row, column]
    spots = _spots(frame, labels == label) if label else []
    if not spots:
        raise InputError(f"{where} has no depth reading; click another marker or frame")
    radius_m = float(spots[0][5])
    if not LEAST_RADIUS_M <= radius_m <= GREATEST_RADIUS_M:
        raise InputError(
            f"the spot at ({u:.0f}, {v:.0f}) has a radius of {100 * radius_m:.1f} cm; a marker's "
            f"must be {100 * LEAST_RADIUS_M:g} to {100 * GREATEST_RADIUS_M:g} cm"
        )
    return MarkerAppearance(red, green, blue, round(radius_m, 4))


LEAST_RADIUS_M: Final = 0.005
GREATEST_RADIUS_M: Final = 0.06
"""Of markers that fit a wrist and can be seen from 3 m (ours)."""


def chroma_of(look: MarkerAppearance) -> float:
    """How far the colour is from grey, in shares of red and green."""
    total = max(sum(look.rgb), 1)
    return float(np.hypot(look.red / total - GREY, look.green / total - GREY))


def color_mask(color: NDArray[np.uint8], look: MarkerAppearance) -> NDArray[np.bool_]:
    """[H, W] True where the colour is the marker's, however bright."""
    levels = color.astype(np.float32)
    total = levels.sum(-1)
    bright = np.maximum(total, 1.0)
    own = np.float32(sum(look.rgb))
    distance = np.hypot(levels[..., 0] / bright - look.red / own,
                        levels[..., 1] / bright - look.green / own)  # fmt: skip
    return (distance < COLOR_REACH * chroma_of(look)) & (total > 3.0 * LEAST_COLOR_LEVEL)


def _spots(frame: Frame, mask: NDArray[np.bool_]) -> list[tuple[float, ...]]:
    """(u, v, x, y, z, radius_m, stretch) of each connected spot that has a depth."""
    count, labels, stats, centres = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    spots = []
    for k in range(1, count):
        left, top, width, height, area = (int(value) for value in stats[k])
        if area < LEAST_SPOT_PIXELS:
            continue
        window = slice(max(top - 1, 0), top + height + 1), slice(max(left - 1, 0), left + width + 1)
        z = _depth(frame.depth_m[window], labels[window] == k)
        if z <= 0.0:
            continue
        u, v = centres[k]
        radius_m = float(np.sqrt(area / pi) * z / np.sqrt(frame.camera.fx * frame.camera.fy))
        z += BULGE * min(radius_m, GREATEST_RADIUS_M)
        x, y, _ = ray(frame.camera, u, v) * z
        stretch = max(width, height) / min(width, height)
        spots.append((float(u), float(v), float(x), float(y), z, radius_m, stretch))
    return spots


def _depth(depth_m: NDArray[np.float32], inside: NDArray[np.bool_]) -> float:
    """Mean depth of the readings in a spot, or of the nearer ones around it; 0 if there is none.

    Readings at the outline may belong to the background: only the nearer ones are used. Of these,
    the ones near the median are averaged, so that the sensor's depth steps average out over the
    curve of the ball.
    """
    readings = depth_m[inside & (depth_m > 0.0)]
    if readings.size < 2:
        readings = depth_m[depth_m > 0.0]
    if readings.size == 0:
        return 0.0
    if readings.max() - readings.min() > MIXED_DEPTHS_M:
        readings = readings[readings < readings.min() + MIXED_DEPTHS_M]
    median = np.sort(readings)[(readings.size - 1) // 2]
    near = np.abs(readings - median) <= DEPTH_STEP_M
    return float(readings[near].mean())


DEPTH_STEP_M: Final = 0.04
"""Height of a ball, and a Kinect's step of depth at 3 m (ours)."""

BULGE: Final = 2.0 / 3.0
"""Mean height of a half ball over its base, in radii. Markers are modelled as balls half sunk in
the clothes, and the centre of the ball is wanted. (Flat markers on both sides: the errors
cancel.)"""

MIXED_DEPTHS_M: Final = 0.12
"""Greatest spread of the readings of one marker, noise included (ours)."""


def ray(camera: Camera, u: float, v: float) -> NDArray[np.float64]:
    """[3] direction of the ray through a pixel, z = 1."""
    return np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0])


def depth_near(frame: Frame, u: float, v: float, radius_px: float) -> float:
    """Metres of the surface at a pixel and around it, 0 where there is no reading."""
    height, width = frame.depth_m.shape
    reach = max(round(radius_px), 1)
    window = (
        slice(max(round(v) - reach, 0), min(round(v) + reach + 1, height)),
        slice(max(round(u) - reach, 0), min(round(u) + reach + 1, width)),
    )
    readings = frame.depth_m[window]
    return _depth(readings, np.ones(readings.shape, np.bool_)) if readings.size else 0.0
