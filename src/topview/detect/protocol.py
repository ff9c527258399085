"""What a detector of people provides: heads, and maybe skin detections, in each frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.faces_and_hands import SkinDetections
from topview.detect.heads import NO_HINTS, HeadCandidate, Hints
from topview.records import Frame

Vector = NDArray[np.float64]


class ColorDetector(Protocol):
    """What a detector that uses colour provides besides heads."""

    @property
    def skin_detections(self) -> SkinDetections | None:
        """The skin detections of the last frame; None before the first."""
        ...

    def check_faces_in_turn(
        self, frame: Frame, heads_camera: Sequence[Vector]
    ) -> list[tuple[int, bool | None]]:
        """Check some of the heads for a frontal face, in turn from call to call: their indices, and
        whether there is one (None where that cannot be known)."""
        ...

    @property
    def background_is_due(self) -> bool:
        """Whether `update_background` would learn from the last frame."""
        ...

    def update_background(self, is_person: NDArray[np.bool_]) -> None:
        """Learn the background from the last frame, where [H, W] is False."""
        ...


class HeadDetector(Protocol):
    """Detects heads in one frame after the other."""

    @property
    def needs_color(self) -> bool:
        """Whether it detects nobody without colour images."""
        ...

    @property
    def colors(self) -> ColorDetector | None:
        """The part that uses colour; None if there is none."""
        ...

    def detect(
        self, cloud: Cloud, up_camera: Vector, hints: Hints = NO_HINTS
    ) -> list[HeadCandidate]:
        """Heads in the frame, best first; `up_camera` [3] is the unit vector away from the floor.

        The full frame, with its colour image if there is one, is `cloud.frame`.
        """
        ...
