"""Colour histograms of a known head and of the body below it (ours; the thesis knows skin alone).

A head that hangs down, or is half hidden, has hardly a shape; but hair, skin or a cap seldom have
the colours of the clothes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import NEAREST_READING_M, Cloud
from topview.kernels.colors import color_shares, count_head_and_body

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]
Counts = NDArray[np.float32]

# All ours. Bins of Y, U and V, as powers of two of levels.
SHIFTS: Final = (5, 4, 4)
# Metres from the head's centre: of the head, and of the body below it from and to.
HEAD_M: Final = 0.12
BODY_M: Final = (0.3, 1.3)
# Fewer pixels of either give no histogram.
LEAST_COLOR_PIXELS: Final = 12
# Weight of a new histogram against the remembered one.
COLOR_LEARNING_RATE: Final = 0.2
# Added to every bin: a colour that neither has more of is no evidence.
RARE: Final = 0.002
# Colours are averaged over this radius about a place.
ABOUT_M: Final = 0.06
# A pixel whose depth differs from the head's by more than this is no evidence.
HEAD_DEPTH_M: Final = 0.35


@dataclass(frozen=True, slots=True, eq=False)
class HeadColors:
    """Histograms, [8, 16, 16] of Y, U and V and of sum 1, of a head and of the body below it."""

    head: Counts
    body: Counts

    @classmethod
    def of(cls, cloud: Cloud, head_camera: Vector, body: Distance) -> HeadColors | None:
        """Of a head at [3] and its body ([h, w] metres from the head, `body_distance`); None where
        too few pixels of them are visible or there is no colour."""
        color = cloud.frame.color
        if color is None:
            return None
        head, below = np.zeros((2, *(256 >> shift for shift in SHIFTS)), np.float32)
        x, y, z = head_camera.tolist()
        heads, bodys = count_head_and_body(
            color, cloud.stride, cloud.points_camera, body, (x, y, z), HEAD_M, BODY_M, SHIFTS,
            head, below,
        )  # fmt: skip
        if min(heads, bodys) < LEAST_COLOR_PIXELS:
            return None
        return cls(head / heads, below / bodys)

    def learn(self, now: HeadColors) -> HeadColors:
        """Both, updated with the histograms of a new frame."""
        head, body = (
            np.asarray(old + COLOR_LEARNING_RATE * (new - old), np.float32)
            for old, new in ((self.head, now.head), (self.body, now.body))
        )
        return HeadColors(head, body)

    def against(self, others: Sequence[HeadColors]) -> HeadColors:
        """The same head against its own body and other people's heads and bodies."""
        if not others:
            return self
        theirs = [counts for other in others for counts in (other.head, other.body)]
        return HeadColors(self.head, np.maximum.reduce([self.body, *theirs]))

    def share_at(self, cloud: Cloud, head_camera: Vector) -> float | None:
        """Whether a head at [3] has this one's colours (1) or the body's (0); None without any."""
        if cloud.frame.color is None:
            return None
        row, column, _ = cloud.pixel_at(head_camera)
        return float(self.share_about(cloud, row, column, float(head_camera[2]), 0)[0, 0])

    def share_about(
        self, cloud: Cloud, row: int, column: int, depth_m: float, radius_px: int
    ) -> NDArray[np.float32]:
        """[n, n] for the pixels about one, `n = 2 * radius_px + 1`: whether the colours around
        each are the head's (1) or the body's (0); 0.5 where that is not known. The image is
        replicated beyond its border."""
        color = cloud.frame.color
        assert color is not None
        return color_shares(
            color, cloud.depth_m, cloud.stride, (row, column), radius_px, _about_px(cloud, depth_m),
            self.head, self.body, SHIFTS, RARE, depth_m, HEAD_DEPTH_M,
        )  # fmt: skip


def _about_px(cloud: Cloud, depth_m: float) -> int:
    return max(1, round(ABOUT_M * cloud.camera.fx / max(depth_m, NEAREST_READING_M)))
