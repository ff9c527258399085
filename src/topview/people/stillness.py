"""Has something moved? People sway, breathe and turn their heads all the time; furniture does not.

A reading's noise hides that, the mean of a body's readings over some frames does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.records import KINECT1_NOISE, DepthNoise

# All ours. Frames whose mean is compared with the later ones, whose mean moves with `RATE`.
FIRST_FRAMES = 5
RATE = 0.2
# Readings that differ more are another surface's, which has come before or left free a pixel.
SAME_M = 0.15
# A mean over a body, or a pixel's, has changed if it differs by this much, by this share of the
# noise and by so many of its own usual steps from one frame to the next. Each frame's noise alone
# makes the difference 0.4 of a step: of furniture in the simulator and in a real room, watched for
# five seconds, it never was as large, but for what a passer-by's shadow fell on.
SHIFTED_M, SHIFTED_NOISE, SHIFTED_STEPS = 0.001, 0.15, 2.4
CHANGED_M, CHANGED_NOISE, CHANGED_STEPS = 0.002, 0.1, 0.55
# The mean of so few pixels' changes that they are this number's square is twice as large by chance.
FEW = 2.0
# Before there are many steps, those of a body's mean are taken to be this share of the noise, as if
# that had been seen for so many frames.
USUAL_STEP, USUAL_FRAMES = 0.09, 10
# The largest changes are left out, which on an outline show now this surface, now the one behind;
# of normal numbers the mean of the magnitudes that are kept is this share of that of all.
KEPT, KEPT_MAGNITUDE = 0.85, 0.76
# The median of the squares of normal numbers is this share of their mean.
MEDIAN_SQUARE = 0.455
# Less of a body says nothing of that, as readings beside what hides the rest are off.
LEAST_SHARE = 0.7
# What stands still leaves no pixels free for what is behind it, save along its outline, which shows
# now this, now that: of those that showed it in so many of the first frames it leaves fewer.
LEFT_SHARE = 0.3
STEADY_FRAMES, STEADY_LEFT_SHARE = 4, 0.12
# One frame alone may show what somebody's shadow does.
MOVED_FRAMES = 3
# Readings beside what hid the rest were off: from so many times the pixels on they count no more.
GROWN = 1.5


class Stillness:
    """Watches what a body's pixels show, from the frame on in which it is made.

    Attributes:
        telling_frames: in how many enough of them was in view.
        moved_frames: in how many it was no thing that stands still.
        is_mixed: whether what was taken for a part of it may be somebody else, who was near.
    """

    def __init__(
        self,
        depth_m: NDArray[np.float32],
        is_body: NDArray[np.bool_],
        noise: DepthNoise = KINECT1_NOISE,
    ) -> None:
        self._is_body = is_body
        self._start_m = depth_m[is_body]
        self._noise_m = float(np.median(noise.sigma_m(self._start_m)))
        self._sum_m = self._start_m.copy()
        self._count = np.ones(len(self._start_m), np.int32)
        self._recent_m = self._start_m.copy()
        self._last_m = self._start_m.copy()
        self._steps_m: list[float] = []
        self._square_steps: list[float] = []
        self._frames = 1
        self.telling_frames = self.moved_frames = self._left_frames = 0
        self.is_mixed = False

    @property
    def is_broken(self) -> bool:
        """Whether it is no thing that stands still."""
        return self.moved_frames >= MOVED_FRAMES

    @property
    def has_left(self) -> bool:
        """Whether it has left pixels free for long enough, as limbs do."""
        return self._left_frames >= MOVED_FRAMES and not self.is_mixed

    def look(self, depth_m: NDArray[np.float32]) -> None:
        """Watch the next frame, [h, w]."""
        self.moved_frames += self.is_broken_in(depth_m)

    def has_grown(self, is_body: NDArray[np.bool_]) -> bool:
        """Whether so much more is seen of the body, [h, w], that it must be watched afresh."""
        return bool(np.count_nonzero(is_body) > GROWN * len(self._start_m))

    def is_broken_in(self, depth_m: NDArray[np.float32]) -> bool:
        """Whether the next frame, [h, w], shows that it is no thing that stands still."""
        seen_m = depth_m[self._is_body]
        is_same = (seen_m > 0.0) & (np.abs(seen_m - self._start_m) < SAME_M)
        self._frames += 1
        if self._frames <= FIRST_FRAMES:
            self._sum_m[is_same] += seen_m[is_same]
            self._count += is_same
        self._step(seen_m, is_same)
        self._recent_m[is_same] += np.float32(RATE) * (seen_m - self._recent_m)[is_same]
        is_left = seen_m > self._start_m + SAME_M
        if self._frames > FIRST_FRAMES:
            steady = (is_left & (self._count >= STEADY_FRAMES)).mean()
            self._left_frames += bool(steady > STEADY_LEFT_SHARE)
        if is_left.mean() > LEFT_SHARE:
            return True
        if self._frames <= FIRST_FRAMES or is_same.mean() < LEAST_SHARE:
            return False
        self.telling_frames += 1
        change_m = (self._recent_m - self._sum_m / self._count)[is_same]
        step_m, mean_step_m = self._usual_steps_m()
        is_shifted = abs(change_m.mean()) > (
            SHIFTED_M + SHIFTED_NOISE * self._noise_m + SHIFTED_STEPS * mean_step_m
        )
        magnitudes_m = np.sort(np.abs(change_m))[: int(KEPT * len(change_m))]
        is_changed = magnitudes_m.mean() > KEPT_MAGNITUDE * (1.0 + FEW / np.sqrt(len(change_m))) * (
            CHANGED_M + CHANGED_NOISE * self._noise_m + CHANGED_STEPS * step_m
        )
        return bool(is_shifted or is_changed)

    def _step(self, seen_m: NDArray[np.float32], is_same: NDArray[np.bool_]) -> None:
        """Remember by how much readings have changed since the last frame."""
        steps_m = (seen_m - self._last_m)[is_same & (np.abs(self._last_m - self._start_m) < SAME_M)]
        self._last_m = seen_m
        if len(steps_m):
            self._steps_m.append(float(np.abs(steps_m).mean()))
            self._square_steps.append(float(steps_m.mean()) ** 2)

    def _usual_steps_m(self) -> tuple[float, float]:
        """Of a pixel: the mean; of the mean of all: the standard deviation."""
        if not self._steps_m:
            return 0.0, USUAL_STEP * self._noise_m
        count = len(self._square_steps)
        square = float(np.median(self._square_steps)) / MEDIAN_SQUARE
        usual = (USUAL_STEP * self._noise_m) ** 2
        blend = (count * square + USUAL_FRAMES * usual) / (count + USUAL_FRAMES)
        return float(np.median(self._steps_m)), float(np.sqrt(blend))
