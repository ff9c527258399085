"""Whether the camera moves: whether one rigid motion explains the room better than none.

What moves by itself, a door, furniture, somebody who is not tracked yet, is in some parts of the
image, and any motion that explains it makes the others worse. A camera that moves shifts them all
alike. What the shake of a tripod moves is soon back in its place.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import degrees
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.filter.over_time import Turns
from topview.geometry.rotations import vectors_from_rotations
from topview.room.planes import RoomPlanes, losses, motion_between

# All ours. Seconds: between two looks; age of the room that is compared with, at least and at most;
# and for how long more looks than not must have seen it shift.
LOOK_EVERY_S: Final = 0.2
LEAST_AGE_S, MOST_AGE_S = 0.4, 1.0
SURE_S: Final = 1.5
# Parts of the image, in each direction; how many must show the room, each in so large a share of
# itself; and how many must be explained better by the motion, while none loses what all gain on
# average.
SIDE_PARTS: Final = 3
LEAST_SHARE, LEAST_PARTS, LEAST_GAINING = 0.1, 5, 3
# Mean loss of cells, 0 to 1: what is gained at least, and what may be left at most.
GAIN_NEEDED, MOST_LEFT = 0.05, 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Shift:
    """A motion of the camera.

    Attributes:
        T_then_now: [4, 4] metres.
        elapsed_s: from then to now.
    """

    T_then_now: NDArray[np.float64]
    elapsed_s: float

    @property
    def turn_rad(self) -> float:
        return float(np.linalg.norm(vectors_from_rotations(self.T_then_now[:3, :3])))

    @property
    def way_m(self) -> float:
        return float(np.linalg.norm(self.T_then_now[:3, 3]))

    def __str__(self) -> str:
        turn_deg, way_cm = degrees(self.turn_rad), 100.0 * self.way_m
        return f"{turn_deg:.1f} degrees and {way_cm:.0f} cm in {self.elapsed_s:.1f} s"


class CameraMotion:
    """Looks at the room a few times a second, and tells when the camera moves."""

    def __init__(self) -> None:
        self._turns = Turns(LOOK_EVERY_S)
        self._seen: deque[RoomPlanes] = deque()
        self._start_then_now = np.eye(4)
        self._moving_s = 0.0

    def update(self, image: Pyramid, labels: NDArray[np.int32]) -> Shift | None:
        """The latest shift of the room once it has shifted for `SURE_S`, else None.

        Args:
            image: the next frame.
            labels: [H, W] whose each pixel is, 0 for nobody's.
        """
        time_s = image.frame.timestamp_s
        if not self._turns.due(time_s):
            return None
        now = RoomPlanes.of(image, labels)
        before_s = self._seen[-1].time_s if self._seen else time_s
        while len(self._seen) > 1 and time_s - self._seen[1].time_s > LEAST_AGE_S - 0.01:
            self._seen.popleft()
        self._seen.append(now)
        age_s = time_s - self._seen[0].time_s
        if not LEAST_AGE_S - 0.01 < age_s < MOST_AGE_S:
            if age_s >= MOST_AGE_S:
                self._seen, self._moving_s = deque([now]), 0.0
            return None
        T_then_now = moved(now, self._seen[0], self._start_then_now)
        self._start_then_now = np.eye(4) if T_then_now is None else T_then_now
        if T_then_now is None:
            self._moving_s = max(self._moving_s - (time_s - before_s), 0.0)
            return None
        self._moving_s += time_s - before_s
        return Shift(T_then_now, age_s) if self._moving_s > SURE_S - 0.01 else None


def moved(
    now: RoomPlanes, then: RoomPlanes, start_then_now: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """[4, 4] T_then_now of the camera, sought from a first guess; None where it stood still as far
    as can be told."""
    still, was_there = losses(now, then, np.eye(4))
    if not was_there.any() or float(still[was_there].mean()) < GAIN_NEEDED:
        return None
    T_then_now = motion_between(now, then, start_then_now)
    left, is_there = losses(now, then, T_then_now)
    is_told = was_there & is_there
    gain = (still - left)[is_told]
    if not len(gain) or gain.mean() < GAIN_NEEDED or left[is_told].mean() > MOST_LEFT:
        return None
    gains = _gain_of_parts(now.is_room, is_told, gain)
    is_explained = len(gains) >= LEAST_PARTS and (gains > GAIN_NEEDED).sum() >= LEAST_GAINING
    return T_then_now if is_explained and gains.min() > -gain.mean() else None


def _gain_of_parts(
    is_room: NDArray[np.bool_], is_told: NDArray[np.bool_], gain: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[p] mean gain of the parts of the image that show enough of the room; `is_told` says of
    which of the [h, w] cells of the room the gain is."""
    height, width = is_room.shape
    rows, columns = np.nonzero(is_room)
    parts = (rows * SIDE_PARTS // height * SIDE_PARTS + columns * SIDE_PARTS // width)[is_told]
    counts = np.bincount(parts, minlength=SIDE_PARTS**2)
    sums = np.bincount(parts, gain, minlength=SIDE_PARTS**2)
    is_shown = counts > LEAST_SHARE * height * width / SIDE_PARTS**2
    return sums[is_shown] / counts[is_shown]
