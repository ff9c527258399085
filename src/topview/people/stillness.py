"""Has something moved? People sway, breathe and turn their heads all the time; furniture does not.

A reading's noise hides that, the mean of a body's readings over some frames does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import depth_noise_m

# All ours. Frames whose mean is compared with the later ones, whose mean moves with `RATE`.
FIRST_FRAMES = 5
RATE = 0.2
# Readings that differ more are another surface's, which has come before or left free a pixel.
SAME_M = 0.15
# Of furniture at 4.4 m to 5 m the mean depth wanders by up to 4 mm, a tenth of the noise.
# One who sits at 3 m moves by as much within a third of a second.
MOVED_M = 0.002
MOVED_NOISE = 0.15
# A head's measured centre jumps by less, where nothing moves.
HEAD_MOVED_M = 0.2
# Less of a body says nothing.
LEAST_SHARE = 0.5


class Stillness:
    """Watches what a body's pixels show, from the frame on in which it is made."""

    def __init__(
        self, depth_m: NDArray[np.float32], is_body: NDArray[np.bool_], head_camera: NDArray
    ) -> None:
        self._is_body = is_body
        self._head_camera = head_camera
        self._start_m = depth_m[is_body]
        self._sum_m = self._start_m.copy()
        self._count = np.ones(len(self._start_m), np.int32)
        self._recent_m = self._start_m.copy()
        self._frames = 1

    def is_broken(self, depth_m: NDArray[np.float32], head_camera: NDArray[np.float64]) -> bool:
        """Whether the next frame, [h, w], shows that it is no thing that stands still."""
        seen_m = depth_m[self._is_body]
        is_same = (seen_m > 0.0) & (np.abs(seen_m - self._start_m) < SAME_M)
        self._frames += 1
        if self._frames <= FIRST_FRAMES:
            self._sum_m += np.where(is_same, seen_m, np.float32(0.0))
            self._count += is_same
        self._recent_m += np.float32(RATE) * np.where(
            is_same, seen_m - self._recent_m, np.float32(0.0)
        )
        if np.linalg.norm(head_camera - self._head_camera) > HEAD_MOVED_M:
            return True
        if self._frames <= FIRST_FRAMES or is_same.mean() < LEAST_SHARE:
            return False
        moved_m = (self._recent_m - self._sum_m / self._count)[is_same].mean()
        noise_m = float(depth_noise_m(head_camera[2]))
        return bool(abs(moved_m) > MOVED_M + MOVED_NOISE * noise_m)
