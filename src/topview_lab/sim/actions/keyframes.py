"""Curves of joint angles through key poses."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from topview_lab.sim.actions.act import Angles


class Keyframes:
    """Curves of joint angles through key poses, without overshoot, with zero slope at both ends.

    A segment that a key does not name keeps the value of the key before.
    """

    def __init__(self, *keys: tuple[float, Angles]) -> None:
        self.names = list(dict.fromkeys(name for _, angles in keys for name in angles))
        held: Angles = dict.fromkeys(self.names, (0.0, 0.0, 0.0))
        rows = []
        for _, angles in keys:
            held |= angles
            rows.append([held[name] for name in self.names])
        self._first = np.array(rows[0])
        # slopes at the ends are 0 where the curve goes on at the same value
        phases = [keys[0][0] - 1e-3, *(phase for phase, _ in keys), keys[-1][0] + 1e-3]
        self._curve = PchipInterpolator(phases, [rows[0], *rows, rows[-1]])

    def __call__(self, phase: float, size: float = 1.0) -> Angles:
        """The angles at a phase; size scales how far they are from the first key."""
        values = self._first + size * (self._curve(phase) - self._first)
        return {
            name: (x, y, z) for name, (x, y, z) in zip(self.names, values.tolist(), strict=True)
        }


def curve(*knots: tuple[float, float]) -> PchipInterpolator:
    """A curve of one value through knots, without overshoot, with zero slope at both ends."""
    x, y = zip(*knots, strict=True)
    return PchipInterpolator([x[0] - 1e-3, *x, x[-1] + 1e-3], [y[0], *y, y[-1]])
