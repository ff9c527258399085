"""What has been seen of the room while nobody stood before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.filter.over_time import share_after
from topview.kernels.noise import Law
from topview.kernels.scene import (
    changed_share,
    continues_background,
    learn_background,
    shows_background,
)
from topview.records import KINECT1_NOISE, DepthNoise

# All ours: seconds until a depth is believed, of which what lies between two frames counts for no
# more than so many; over how many the mean is taken; and how far a reading may be from the mean,
# besides 2.5 standard deviations of the noise.
KNOWN_S, LONGEST_GAP_S = 0.28, 0.15
MEMORY_S = 0.32
TOLERANCE_M, TOLERANCE_NOISES = 0.05, 2.5
# Of a plane that is continued into what somebody hid until now: pixels between three places on it.
BASELINE_PX = 6


def same_depth(noise: DepthNoise) -> Law:
    """By how much two readings of the same surface may differ."""
    return noise.times(TOLERANCE_NOISES, TOLERANCE_M)


class Background:
    """The farthest steady depth of each pixel of the small cloud; users are never learnt."""

    def __init__(self, longest_gap_s: float = LONGEST_GAP_S) -> None:
        self._longest_gap_s = longest_gap_s
        self._mean_m = np.zeros((0, 0), np.float32)
        self._steady_s, self._age_s = np.zeros((2, 0, 0), np.float32)
        # The last frame, and what of it was somebody's.
        self._last_m, self._was_somebodys = self._mean_m, np.zeros((0, 0), np.bool_)
        self._last_s: float | None = None

    def update(
        self,
        depth_m: NDArray[np.float32],
        is_somebodys: NDArray[np.bool_],
        time_s: float,
        noise: DepthNoise = KINECT1_NOISE,
    ) -> None:
        """Learn from one [h, w] frame, taken at a time, where it is nobody's."""
        self._fit(depth_m)
        elapsed_s = 0.0 if self._last_s is None else max(time_s - self._last_s, 0.0)
        self._last_s = time_s
        learn_background(
            depth_m,
            is_somebodys,
            share_after(elapsed_s, MEMORY_S),
            min(elapsed_s, self._longest_gap_s),
            same_depth(noise),
            self._mean_m,
            self._steady_s,
            self._age_s,
        )
        self._last_m, self._was_somebodys = depth_m, is_somebodys

    def forget(self, is_somebodys: NDArray[np.bool_]) -> None:
        """Somebody turned out to have been standing there."""
        if self._steady_s.shape == is_somebodys.shape:
            self._steady_s[is_somebodys] = 0.0

    def learn(self, depth_m: NDArray[np.float32], is_room: NDArray[np.bool_]) -> None:
        """Take what is seen as the room at once."""
        self._fit(depth_m)
        self._mean_m[is_room] = depth_m[is_room]
        self._steady_s[is_room] = KNOWN_S

    def is_seen_in(
        self, depth_m: NDArray[np.float32], noise: DepthNoise = KINECT1_NOISE
    ) -> NDArray[np.bool_]:
        """[h, w] where a frame shows the known background, or its planes where they go on behind
        whoever has just left: what comes to light of a wall is nobody's body. Who still stands
        there keeps the feet that stand on such a plane."""
        self._fit(depth_m)
        is_seen = np.empty(depth_m.shape, np.bool_)
        learnt = self._mean_m, self._steady_s, KNOWN_S, same_depth(noise)
        shows_background(depth_m, *learnt, is_seen)
        before = self._last_m, self._was_somebodys
        continues_background(depth_m, *learnt, *before, BASELINE_PX, is_seen)
        return is_seen

    @property
    def farthest_m(self) -> float:
        """The farthest depth that is believed, infinity if none is."""
        return float(self._mean_m.max(where=self._steady_s >= KNOWN_S, initial=0.0)) or np.inf

    def changed_share(
        self,
        is_own: NDArray[np.bool_],
        depth_m: NDArray[np.float32],
        since_s: float,
        noise: DepthNoise = KINECT1_NOISE,
    ) -> float:
        """Share of the pixels [h, w] of a thing whose depths, which it has learnt from, have been
        the same for less than `since_s`, but while something hid it; 1 of none."""
        same = same_depth(noise)
        return changed_share(is_own, depth_m, self._mean_m, self._age_s, since_s, same)

    def _fit(self, depth_m: NDArray[np.float32]) -> None:
        """Start anew with images of another size."""
        if self._mean_m.shape != depth_m.shape:
            self._mean_m, self._steady_s = np.zeros_like(depth_m), np.zeros_like(depth_m)
            self._age_s = np.zeros_like(depth_m)
            self._last_m, self._was_somebodys = depth_m, np.zeros(depth_m.shape, np.bool_)
