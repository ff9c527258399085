"""What the tracker is told of each person in a frame (Sec. 5.3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only


@dataclass(frozen=True, slots=True, eq=False)
class User:
    """A person found in one frame.

    Attributes:
        id: identity that lasts, counted from 1.
        head_camera: [3] metres, the centre of the head: measured, or predicted while it is hidden.
        head_is_seen: False while `head_camera` is a prediction.
        height_m: stature, the best estimate so far.
        height_is_measured: False while `height_m` is only the mean of all people.
        pixels: [N] int32 flat indices (row * width + column) into the depth image: the pixels that
            belong, or may belong, to this person; users who touch may share some. Empty while the
            person is fully hidden.
    """

    id: int
    head_camera: NDArray[np.float64]
    head_is_seen: bool
    height_m: float
    height_is_measured: bool
    pixels: NDArray[np.int32]

    def __post_init__(self) -> None:
        read_only(self.head_camera)
        read_only(self.pixels)
