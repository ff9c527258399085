"""What happens over time, however often frames come: means that forget, and work done in turns.

Frames come 5 or 120 times a second, are dropped, or pause. So no rate is one per frame: it is per
second, and what counts is how many seconds have gone by.
"""

from __future__ import annotations

from math import exp, floor
from typing import Final

# Ours.
FRAME_S: Final = 1 / 30  # from frame to frame where noise and weights of priors were chosen
PAUSE_FRAMES: Final = 6.0  # a longer pause makes nothing that is known less certain


def share_after(elapsed_s: float, memory_s: float) -> float:
    """The share of the new in a mean that forgets, 0..1: 63 % once `memory_s` have gone by.

    None where no time has gone by, or a clock has run backwards. Steps of any length that add up to
    the same time forget as much.
    """
    return 1.0 - exp(-max(elapsed_s, 0.0) / memory_s)


def begins_turn(time_s: float, last_s: float | None, every_s: float) -> bool:
    """Whether one of the turns that begin every so often has begun since the last frame (None for
    the first one, which begins one).

    Turns are counted from time 0, so that work is done at the same moments at any rate of frames,
    as far as there are frames. Timestamps are rounded: a turn may begin 1 % of one too early.
    """
    if last_s is None:
        return True
    now, last = (floor(moment_s / every_s + 0.01) for moment_s in (time_s, last_s))
    return now != last


def frames_in(elapsed_s: float) -> float:
    """How many `FRAME_S` have gone by, 0 to `PAUSE_FRAMES`."""
    return min(max(elapsed_s, 0.0) / FRAME_S, PAUSE_FRAMES)


class Pace:
    """How fast frames come, in units of `FRAME_S`.

    What was chosen for frames of that length (a variance, a share of evidence) is multiplied by it.
    """

    def __init__(self) -> None:
        self._last_s: float | None = None

    def frames(self, time_s: float) -> float:
        """Units that have gone by since the last call, 0 to `PAUSE_FRAMES`; 1 at the first."""
        last_s, self._last_s = self._last_s, time_s
        return 1.0 if last_s is None else frames_in(time_s - last_s)


class Turns:
    """Work that is not done in every frame, but so often on average."""

    # Timestamps are rounded; a turn may come this share of one too early.
    _EARLY = 0.1

    def __init__(self, every_s: float) -> None:
        """`every_s`: seconds from one turn to the next."""
        self._every_s = every_s
        self._last_s: float | None = None
        self._owed = 1.0

    def due(self, time_s: float) -> int:
        """How many turns have come round since the last call; one at the first."""
        if self._last_s is not None:
            self._owed += max(time_s - self._last_s, 0.0) / self._every_s
        self._last_s = time_s
        turns = int(self._owed + self._EARLY)
        self._owed -= turns
        return turns
