"""Has something moved? People sway, breathe and turn their heads all the time; furniture does not.

A reading's noise hides that, the mean of a body's readings over some frames does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.filter.over_time import share_after
from topview.records import KINECT1_NOISE, DepthNoise

# All ours. Time is counted in looks, which come `look_s` seconds apart: a look that comes later
# counts for as many as there would have been, but for no more than so many.
MOST_LOOKS = 3.0
# And so many seconds are watched at most from one look to the next.
LONGEST_S = 0.5
# It comes no sooner than after this share of that, as frames are not in step with it.
SOONEST = 0.75
# The mean of so many looks' time from the start on is compared with that of the latest.
FIRST_LOOKS, MEMORY_LOOKS = 4.5, 4.5
# Looks in the first mean, and the squares of the shares of those in the latest, where frames come
# as often as looks. Where they come less often, the means are noisier.
USUAL_FIRST, USUAL_SQUARE = 5, 0.11
# Readings that differ more are another surface's, which has come before or left free a pixel.
SAME_SURFACE_M = 0.15
# A mean over a body, or a pixel's, has changed if it differs by this much, by this share of the
# noise and by so many of its own usual steps from one look to the next. Each look's noise alone
# makes the difference 0.4 of a step: of furniture in the simulator and in a real room, watched for
# five seconds, it never was as large, but for what a passer-by's shadow fell on.
SHIFTED_M, SHIFTED_NOISE, SHIFTED_STEPS = 0.001, 0.15, 2.4
CHANGED_M, CHANGED_NOISE, CHANGED_STEPS = 0.002, 0.1, 0.55
# The mean of so few pixels' changes that they are this number's square is twice as large by chance.
FEW = 2.0
# Before there are many steps, those of a body's mean are taken to be this share of the noise, as if
# that had been seen so many times.
USUAL_STEP, USUAL_TIMES = 0.09, 10
# The largest changes are left out, which on an outline show now this surface, now the one behind;
# of normal numbers the mean of the magnitudes that are kept is this share of that of all.
KEPT, KEPT_MAGNITUDE = 0.85, 0.76
# The median of the squares of normal numbers is this share of their mean.
MEDIAN_SQUARE = 0.455
# Less of a body says nothing of that, as readings beside what hides the rest are off.
LEAST_SHARE = 0.7
# What stands still leaves no pixels free for what is behind it, save along its outline, which shows
# now this, now that: of those that showed it in so many of the first looks it leaves fewer.
LEFT_SHARE = 0.3
STEADY_SHARE, STEADY_LEFT_SHARE = 0.75, 0.12
# One look alone may show what somebody's shadow does.
MOVED_LOOKS = 2.5
# Readings beside what hid the rest were off: from so many times the pixels on they count no more.
GROWN = 1.5


class Stillness:
    """Watches what a body's pixels show, from the frame on in which it is made.

    Attributes:
        telling_looks: in how many enough of them was in view.
        moved_looks: in how many it was no thing that stands still.
        watched_s: for how long; of a pause without frames only the beginning counts.
        is_mixed: whether what was taken for a part of it may be somebody else, who was near.
    """

    def __init__(
        self,
        depth_m: NDArray[np.float32],
        is_body: NDArray[np.bool_],
        time_s: float,
        look_s: float,
        noise: DepthNoise = KINECT1_NOISE,
        watched_s: float = 0.0,
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
        self.watched_s = watched_s
        self._look_s = look_s
        self._last_s = time_s
        self._age_looks = 0.0
        self._first = 1
        self._square = USUAL_SQUARE
        self.telling_looks = self.moved_looks = self._left_looks = 0.0
        self.is_mixed = False

    @property
    def is_broken(self) -> bool:
        """Whether it is no thing that stands still."""
        return self.moved_looks >= MOVED_LOOKS

    @property
    def has_left(self) -> bool:
        """Whether it has left pixels free for long enough, as limbs do."""
        return self._left_looks >= MOVED_LOOKS and not self.is_mixed

    def is_due(self, time_s: float) -> bool:
        """Whether it is time for the next look."""
        return not 0.0 <= time_s - self._last_s < SOONEST * self._look_s

    def look(self, depth_m: NDArray[np.float32], time_s: float) -> float:
        """Watch the next frame, [h, w]; gives for how many looks it counts."""
        elapsed_s, self._last_s = max(time_s - self._last_s, 0.0), time_s
        elapsed_looks = elapsed_s / self._look_s
        self.watched_s += min(elapsed_s, LONGEST_S)
        looks = min(elapsed_looks, MOST_LOOKS)
        self.moved_looks += looks * self.is_broken_in(depth_m, elapsed_looks)
        return looks

    def has_grown(self, is_body: NDArray[np.bool_]) -> bool:
        """Whether so much more is seen of the body, [h, w], that it must be watched afresh."""
        return bool(np.count_nonzero(is_body) > GROWN * len(self._start_m))

    def is_broken_in(self, depth_m: NDArray[np.float32], elapsed_looks: float = 1.0) -> bool:
        """Whether the next frame, [h, w], so long after the last, shows that it is no thing that
        stands still."""
        if not len(self._start_m):
            return False
        looks = min(elapsed_looks, MOST_LOOKS)
        seen_m = depth_m[self._is_body]
        is_same = (seen_m > 0.0) & (np.abs(seen_m - self._start_m) < SAME_SURFACE_M)
        self._age_looks += elapsed_looks
        is_first = self._age_looks < FIRST_LOOKS
        if is_first:
            self._sum_m[is_same] += seen_m[is_same]
            self._count += is_same
            self._first += 1
        self._step(seen_m, is_same)
        share = share_after(elapsed_looks, MEMORY_LOOKS)
        self._recent_m[is_same] += np.float32(share) * (seen_m - self._recent_m)[is_same]
        self._square = max((1.0 - share) ** 2 * self._square + share**2, USUAL_SQUARE)
        is_left = seen_m > self._start_m + SAME_SURFACE_M
        if not is_first:
            steady = (is_left & (self._count >= STEADY_SHARE * self._first)).mean()
            self._left_looks += looks * bool(steady > STEADY_LEFT_SHARE)
        if is_left.mean() > LEFT_SHARE:
            return True
        if is_first or is_same.mean() < LEAST_SHARE:
            return False
        self.telling_looks += looks
        change_m = (self._recent_m - self._sum_m / self._count)[is_same]
        step_m, mean_step_m = (self._noisier * step_m for step_m in self._usual_steps_m())
        is_shifted = abs(change_m.mean()) > (
            SHIFTED_M + SHIFTED_NOISE * self._noise_m + SHIFTED_STEPS * mean_step_m
        )
        magnitudes_m = np.sort(np.abs(change_m))[: int(KEPT * len(change_m))]
        is_changed = magnitudes_m.mean() > KEPT_MAGNITUDE * (1.0 + FEW / np.sqrt(len(change_m))) * (
            CHANGED_M + CHANGED_NOISE * self._noise_m + CHANGED_STEPS * step_m
        )
        return bool(is_shifted or is_changed)

    @property
    def _noisier(self) -> float:
        """How much more than usual noise alone makes the two means differ."""
        usual = 1.0 / USUAL_FIRST + USUAL_SQUARE
        return float(np.sqrt(max((1.0 / self._first + self._square) / usual, 1.0)))

    def _step(self, seen_m: NDArray[np.float32], is_same: NDArray[np.bool_]) -> None:
        """Remember by how much readings have changed since the last look."""
        steps_m = (seen_m - self._last_m)[
            is_same & (np.abs(self._last_m - self._start_m) < SAME_SURFACE_M)
        ]
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
        blend = (count * square + USUAL_TIMES * usual) / (count + USUAL_TIMES)
        return float(np.median(self._steps_m)), float(np.sqrt(blend))
