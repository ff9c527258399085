"""What has been seen of the room while nobody stood before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.kernels.scene import learn_background, shows_background
from topview.records import KINECT1_NOISE, DepthNoise

# All ours: frames until a depth is believed; how much of a new depth goes into the mean; and how
# far a reading may be from the mean, besides 2.5 standard deviations of the noise.
FRAMES_UNTIL_KNOWN = 10
LEARNING_RATE = 0.1
TOLERANCE_M, TOLERANCE_NOISES = 0.05, 2.5


class Background:
    """The farthest steady depth of each pixel of the small cloud; users are never learnt."""

    def __init__(self) -> None:
        self._mean_m: NDArray[np.float32] | None = None
        self._frames: NDArray[np.int32] | None = None

    def update(
        self,
        depth_m: NDArray[np.float32],
        is_somebodys: NDArray[np.bool_],
        noise: DepthNoise = KINECT1_NOISE,
    ) -> None:
        """Learn from one [h, w] frame where it is nobody's."""
        if self._mean_m is None or self._mean_m.shape != depth_m.shape:
            self._mean_m = np.zeros_like(depth_m)
            self._frames = np.zeros(depth_m.shape, np.int32)
        assert self._frames is not None
        tolerance = noise.times(TOLERANCE_NOISES, TOLERANCE_M)
        learn_background(
            depth_m, is_somebodys, LEARNING_RATE, tolerance, self._mean_m, self._frames
        )

    def forget(self, is_somebodys: NDArray[np.bool_]) -> None:
        """Somebody turned out to have been standing there."""
        if self._frames is not None:
            self._frames[is_somebodys] = 0

    def learn(self, depth_m: NDArray[np.float32], is_room: NDArray[np.bool_]) -> None:
        """Take what is seen as the room at once."""
        if self._mean_m is None or self._frames is None:
            self.update(depth_m, ~is_room)
        assert self._mean_m is not None
        assert self._frames is not None
        self._mean_m[is_room] = depth_m[is_room]
        self._frames[is_room] = FRAMES_UNTIL_KNOWN

    def is_seen_in(
        self, depth_m: NDArray[np.float32], noise: DepthNoise = KINECT1_NOISE
    ) -> NDArray[np.bool_]:
        """[h, w] where a frame shows the known background."""
        if self._mean_m is None or self._frames is None:
            return np.zeros(depth_m.shape, np.bool_)
        is_seen = np.empty(depth_m.shape, np.bool_)
        tolerance = noise.times(TOLERANCE_NOISES, TOLERANCE_M)
        shows_background(
            depth_m, self._mean_m, self._frames, FRAMES_UNTIL_KNOWN, tolerance, is_seen
        )
        return is_seen
