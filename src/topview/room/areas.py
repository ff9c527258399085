"""Where people are looked for: polygons in the image, and boxes on the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.records import InputError, shown
from topview.room.scene import Scene

ON_FLOOR: Final = "floor"
HELP: Final = (
    "it must be corners in the image, like 0,0 320,0 320,200 (pixels), or a box on the floor, like "
    "floor -1,1 1,4 (two corners; metres to the right and ahead of the camera)"
)


@dataclass(frozen=True, slots=True)
class Area:
    """A polygon in the image, or a box on the floor.

    Attributes:
        corners: of a polygon, pixels (column, row) of the depth image; of a box, two of metres
            (right, ahead of the camera).
        is_on_floor: whether it is a box.
    """

    corners: tuple[tuple[float, float], ...]
    is_on_floor: bool = False

    def of_pixels(self, scene: Scene) -> NDArray[np.bool_]:
        """[h, w] which pixels of the cloud are inside; on the floor, whose points are over it."""
        if self.is_on_floor:
            return self._over_box(scene.overview_m)
        inside = np.zeros(scene.cloud.depth_m.shape, np.uint8)
        corners = np.rint(np.array(self.corners) / scene.cloud.stride).astype(np.int32)
        cv2.fillPoly(inside, [corners], 1)
        return inside.astype(np.bool_)

    def holds(self, scene: Scene, point_camera: NDArray[np.float64]) -> bool:
        """Whether a [3] point is inside, or over the box."""
        if self.is_on_floor:
            return bool(self._over_box(scene.overview_of(point_camera)))
        row, column, is_inside = scene.cloud.pixel_at(point_camera)
        return is_inside and bool(self.of_pixels(scene)[row, column])

    def _over_box(self, overview_m: NDArray[np.floating]) -> NDArray[np.bool_]:
        low, high = np.min(self.corners, axis=0), np.max(self.corners, axis=0)
        return np.asarray(((overview_m >= low) & (overview_m <= high)).all(axis=-1))


@dataclass(frozen=True, slots=True)
class Areas:
    """Where people are looked for.

    Attributes:
        region: only inside of one of these; anywhere if there are none.
        ignored: not inside of any of these.
    """

    region: tuple[Area, ...] = ()
    ignored: tuple[Area, ...] = ()

    @classmethod
    def told(cls, region: str, ignore: str) -> Areas:
        """Of texts: areas separated by semicolons.

        Raises:
            InputError: a text that names no area.
        """
        return cls(parse_areas(region, "region"), parse_areas(ignore, "ignore"))

    def looked_at(self, scene: Scene) -> NDArray[np.bool_] | None:
        """[h, w] which pixels may be somebody's; None for all."""
        if not self.region and not self.ignored:
            return None
        is_looked_at = np.full(scene.cloud.depth_m.shape, not self.region)
        for area in self.region:
            is_looked_at |= area.of_pixels(scene)
        for area in self.ignored:
            is_looked_at &= ~area.of_pixels(scene)
        return is_looked_at

    def hold(self, scene: Scene, head_camera: NDArray[np.float64]) -> bool:
        """Whether a head [3] may be somebody's."""
        is_in = not self.region or any(area.holds(scene, head_camera) for area in self.region)
        return is_in and not any(area.holds(scene, head_camera) for area in self.ignored)


def parse_areas(text: str, name: str) -> tuple[Area, ...]:
    """The areas of a text, separated by semicolons.

    Raises:
        InputError: a text that names no area.
    """
    parts = [part.split() for part in text.split(";")]
    return tuple(_parsed(words, text, name) for words in parts if words)


def _parsed(words: Sequence[str], text: str, name: str) -> Area:
    is_on_floor = words[0] == ON_FLOOR
    numbers = words[1:] if is_on_floor else words
    try:
        corners = tuple((float(x), float(y)) for x, y in (word.split(",") for word in numbers))
    except ValueError:
        corners = ()
    is_right = len(corners) == 2 if is_on_floor else len(corners) >= 3
    if not is_right or not np.isfinite(corners).all():
        raise InputError(f"{name} is {shown(text)}; {HELP}")
    return Area(corners, is_on_floor)
