"""The light in a room over time, as a colour camera with automatic exposure renders it."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sin
from typing import Final, NamedTuple

import numpy as np

AMBIENT: Final = 0.36
"""Share of ambient light; the rest comes from the lamp (ours)."""
LAMP_ON_AVERAGE: Final = 0.6
"""Share of the lamp's light that an average surface in view receives (ours)."""
EXPOSURE_S: Final = 0.4
"""Time constant of the automatic exposure (ours)."""
GREATEST_GAIN: Final = 1.8
"""How much brighter the automatic exposure can make a dark room (ours)."""


class Levels(NamedTuple):
    """Brightness of the ambient light and of the lamp; both together are 1 in a lit room."""

    ambient: float
    lamp: float


@dataclass(frozen=True, slots=True)
class Light:
    """How the light changes.

    Attributes:
        switches_s: moments at which the lamp is switched; it is on before the first.
        drift: amplitude of the slow relative change of the daylight.
        drift_period_s: period of that change.
    """

    switches_s: tuple[float, ...] = ()
    drift: float = 0.0
    drift_period_s: float = 9.0

    @classmethod
    def sample(cls, rng: np.random.Generator) -> Light:
        """Drifting daylight; one lamp in four is switched off and on again (ours)."""
        drift, period_s = rng.uniform(0.0, 0.2), rng.uniform(5.0, 20.0)
        off_s, dark_s = rng.uniform(0.5, 3.0), rng.uniform(0.5, 2.0)
        is_switched = bool(rng.random() < 0.25)
        return cls((off_s, off_s + dark_s) if is_switched else (), drift, period_s)

    def levels(self, time_s: float) -> Levels:
        """Brightness in the camera's image at a time, exposure included."""
        is_on, gain, since_s = True, 1.0, 0.0
        for switch_s in sorted(self.switches_s):
            if switch_s > time_s:
                break
            gain = _exposed(gain, is_on, switch_s - since_s)
            is_on, since_s = not is_on, switch_s
        gain = _exposed(gain, is_on, time_s - since_s)
        daylight = 1.0 + self.drift * sin(2.0 * pi * time_s / self.drift_period_s)
        return Levels(gain * AMBIENT * daylight, gain * (1.0 - AMBIENT) * is_on)


STEADY: Final = Light()
"""A lamp that stays on."""


def _exposed(gain: float, is_on: bool, duration_s: float) -> float:
    """The gain after the lamp has been on or off for a duration."""
    received = AMBIENT + (1.0 - AMBIENT) * LAMP_ON_AVERAGE
    wanted = 1.0 if is_on else min(received / AMBIENT, GREATEST_GAIN)
    return wanted + (gain - wanted) * exp(-duration_s / EXPOSURE_S)
