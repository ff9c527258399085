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
# Of furniture at 4.4 m to 5 m the mean depth wanders by up to 4 mm, a tenth of the noise, and that
# of each pixel by 14 mm, 0.4 of the noise; of one who sits at 3 m by 5 mm within a third of a
# second, and of one who walks there by 30 mm.
SHIFTED_M, SHIFTED_NOISE = 0.002, 0.15
CHANGED_M, CHANGED_NOISE = 0.02, 0.5
# Less of a body says nothing of that, as readings beside what hides the rest are off.
LEAST_SHARE = 0.7
# What stands still leaves no pixels free for what is behind it, save along its outline.
LEFT_SHARE = 0.3


class Stillness:
    """Watches what a body's pixels show, from the frame on in which it is made."""

    def __init__(self, depth_m: NDArray[np.float32], is_body: NDArray[np.bool_]) -> None:
        self._is_body = is_body
        self._start_m = depth_m[is_body]
        self._noise_m = float(np.median(depth_noise_m(self._start_m)))
        self._sum_m = self._start_m.copy()
        self._count = np.ones(len(self._start_m), np.int32)
        self._recent_m = self._start_m.copy()
        self._frames = 1

    def is_broken_in(self, depth_m: NDArray[np.float32]) -> bool:
        """Whether the next frame, [h, w], shows that it is no thing that stands still."""
        seen_m = depth_m[self._is_body]
        is_same = (seen_m > 0.0) & (np.abs(seen_m - self._start_m) < SAME_M)
        self._frames += 1
        if self._frames <= FIRST_FRAMES:
            self._sum_m[is_same] += seen_m[is_same]
            self._count += is_same
        self._recent_m[is_same] += np.float32(RATE) * (seen_m - self._recent_m)[is_same]
        if (seen_m > self._start_m + SAME_M).mean() > LEFT_SHARE:
            return True
        if self._frames <= FIRST_FRAMES or is_same.mean() < LEAST_SHARE:
            return False
        change_m = (self._recent_m - self._sum_m / self._count)[is_same]
        is_shifted = abs(change_m.mean()) > SHIFTED_M + SHIFTED_NOISE * self._noise_m
        is_changed = np.abs(change_m).mean() > CHANGED_M + CHANGED_NOISE * self._noise_m
        return bool(is_shifted or is_changed)
