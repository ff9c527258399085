"""What a detector of people is: heads in one frame after the other, and maybe a look at colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.faces_and_hands import Sight
from topview.detect.heads import NO_HINTS, HeadCandidate, Hints
from topview.records import Frame

Vector = NDArray[np.float64]


class ColorDetector(Protocol):
    """What else a detector that looks at colours tells of a frame."""

    @property
    def sight(self) -> Sight | None:
        """What the last frame's colours told; None before the first."""
        ...

    def look_round(
        self, frame: Frame, heads_camera: Sequence[Vector]
    ) -> list[tuple[int, bool | None]]:
        """Look for frontal faces at the heads in turn, some at a time: their indices, and whether
        there is one at each (None if that cannot be told)."""
        ...

    @property
    def learns_room(self) -> bool:
        """Whether it is time for `learn_room`."""
        ...

    def learn_room(self, is_somebodys: NDArray[np.bool_]) -> None:
        """Learn the room's colours from the frame that was looked at last, where [H, W] is
        False."""
        ...


class HeadDetector(Protocol):
    """Finds heads in one frame after the other."""

    @property
    def needs_color(self) -> bool:
        """Whether it finds nobody without colour images."""
        ...

    @property
    def colors(self) -> ColorDetector | None:
        """What looks at the colours; None if nothing does."""
        ...

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads in the frame, best first; `up_camera` [3] is the unit vector away from the floor.

        The full frame, with its colour image if there is one, is `cloud.frame`.
        """
        ...
