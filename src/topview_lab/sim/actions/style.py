"""What is a person's own in the motions, and how no two repetitions are the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

UNEVENNESS: Final = 0.07
"""How far the beat wanders, in cycles (ours)."""
VARIETY: Final = 0.12
"""How much the size of a movement wanders from repetition to repetition (ours)."""


def smooth_step(x: float) -> float:
    """0 below 0, 1 above 1, with no speed at either end."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@dataclass(frozen=True, slots=True)
class Repetition:
    """The k-th time that an action is done: seconds since its start, and how long it takes."""

    k: int
    since_s: float
    length_s: float

    @property
    def phase(self) -> float:
        """0 at its start, 1 at its end."""
        return self.since_s / self.length_s


@dataclass(frozen=True, slots=True, eq=False)
class Style:
    """A person's own way to move.

    Attributes:
        tempo: speed of actions relative to the mean.
        reach: size of movements relative to the mean.
        waves: [K, 3] frequency in Hz, phase in radians and size of the slow drifts of a person who
            only stands.
    """

    tempo: float
    reach: float
    waves: NDArray[np.float64]

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Style:
        """A person's own style."""
        count = 24
        waves = np.stack(
            [
                rng.uniform(0.12, 0.5, count),
                rng.uniform(0.0, 2.0 * np.pi, count),
                rng.uniform(0.4, 1.0, count),
            ],
            -1,
        )
        return cls(
            tempo=float(rng.uniform(0.9, 1.1)),
            reach=float(rng.uniform(0.92, 1.06)),
            waves=waves,
        )

    def drift(self, time_s: float, k: int) -> float:
        """Slow drift number k, about -1 to 1."""
        k %= len(self.waves)
        frequency, phase, size = self.waves[[k, (k + 7) % len(self.waves)]].T
        return float(0.6 * (size * np.sin(2.0 * np.pi * frequency * time_s + phase)).sum())

    def beat(self, time_s: float, period_s: float) -> float:
        """Cycles done since 0 s, a little faster or slower from one to the next."""
        cycles = time_s * self.tempo / period_s
        return cycles + UNEVENNESS * (self.drift(cycles, 3) - self.drift(0.0, 3))

    def size(self, cycles: float, k: int) -> float:
        """How large a movement is in that cycle, about 1; k tells movements apart."""
        return self.reach * (1.0 + VARIETY * self.drift(cycles, k))

    def repetition(self, time_s: float, period_s: float) -> Repetition:
        """Which repetition is on; each takes its own time."""
        period_s /= self.tempo

        def starts(k: int) -> float:
            return period_s * (k + UNEVENNESS * (self.drift(k, 11) - self.drift(0, 11)))

        k = int(np.floor(time_s / period_s))
        k += 1 if time_s >= starts(k + 1) else 0
        k -= 1 if time_s < starts(k) else 0
        return Repetition(k, time_s - starts(k), starts(k + 1) - starts(k))
