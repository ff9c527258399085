"""The noise-free images of a frame, and what their labels mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only

ROOM: Final = 0
FURNITURE: Final = 255
NO_PART: Final = 255
NO_MATERIAL: Final = 255


@dataclass(frozen=True, slots=True, eq=False)
class Rendering:
    """What an ideal camera sees.

    Attributes:
        depth_m: [H, W] float32 along the optical axis, inf where there is nothing.
        instance: [H, W] uint8, 0 room, k = person k, 255 furniture.
        part: [H, W] uint8 index into `bodies.SIM_PART_NAMES`, 255 off the people.
        material: [H, W] uint8 index into `materials.MATERIALS`, 255 off the people.
        normals: [H, W, 3] float32 outward units in the camera frame.
        albedo: [H, W, 3] float32 linear colour in 0..1.
    """

    depth_m: NDArray[np.float32]
    instance: NDArray[np.uint8]
    part: NDArray[np.uint8]
    material: NDArray[np.uint8]
    normals: NDArray[np.float32]
    albedo: NDArray[np.float32]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            read_only(getattr(self, name))
