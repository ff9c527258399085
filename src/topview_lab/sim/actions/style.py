"""How one person's motions differ from another's, and each repetition from the last."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

UNEVENNESS: Final = 0.07
"""Amplitude of the beat's irregularity, in cycles (ours)."""
VARIETY: Final = 0.12
"""Relative spread of a movement's size between repetitions (ours)."""


def smooth_step(x: float) -> float:
    """Rises smoothly from 0 at 0 to 1 at 1, with zero slope at both ends; constant outside."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@dataclass(frozen=True, slots=True)
class Repetition:
    """The k-th repetition of an action: seconds since it began, and its duration."""

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
    def sample(cls, rng: np.random.Generator) -> Style:
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
        """Number of cycles since 0 s; the tempo varies a little from one to the next."""
        cycles = time_s * self.tempo / period_s
        return cycles + UNEVENNESS * (self.drift(cycles, 3) - self.drift(0.0, 3))

    def size(self, cycles: float, k: int) -> float:
        """Relative size of a movement in that cycle, about 1; each k has its own sequence."""
        return self.reach * (1.0 + VARIETY * self.drift(cycles, k))

    def repetition(self, time_s: float, period_s: float) -> Repetition:
        """The repetition under way at a time; each has its own duration."""
        period_s /= self.tempo

        def starts(k: int) -> float:
            return period_s * (k + UNEVENNESS * (self.drift(k, 11) - self.drift(0, 11)))

        k = int(np.floor(time_s / period_s))
        k += 1 if time_s >= starts(k + 1) else 0
        k -= 1 if time_s < starts(k) else 0
        return Repetition(k, time_s - starts(k), starts(k + 1) - starts(k))
