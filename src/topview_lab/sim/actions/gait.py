"""Standing, walking, and stepping round on the spot."""

from __future__ import annotations

from math import ceil
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from topview_lab.sim.actions.act import SIDES, Angles, Feet, Foot
from topview_lab.sim.actions.style import Style, smooth_step


def standing(style: Style, time_s: float) -> Angles:
    """At ease: arms hang a little away from the body, everything drifts by a degree or two."""
    d = [style.drift(time_s, k) for k in range(12)]
    angles: Angles = {
        "pelvis": (1.0 + d[0], 0.0, 1.5 * d[1]),
        "abdomen": (d[2], 0.8 * d[3], d[4]),
        "chest": (2.0 + d[5], 0.0, 1.5 * d[6]),
        "neck": (6.0 + 2.0 * d[7], d[8], 4.0 * d[9]),
        "head": (-6.0 + 2.0 * d[10], d[11], 4.0 * d[1]),
    }
    for k, side in enumerate(("l", "r")):
        angles |= {
            f"upper_arm_{side}": (2.0 + 2.0 * d[k], 9.0 + 1.5 * d[k + 2], 10.0),
            f"forearm_{side}": (16.0 + 3.0 * d[k + 4], 0.0, 15.0),
            f"hand_{side}": (0.0, -6.0 + 2.0 * d[k + 6], 0.0),
            f"thigh_{side}": (2.0, 3.0, -6.0),
            f"calf_{side}": (4.0 + d[k + 8], 0.0, 0.0),
            f"foot_{side}": (2.0, -1.0, 0.0),
        }
    return angles


def _cycle(*degrees: float) -> CubicSpline:
    """A periodic curve through equidistant values of one gait cycle."""
    return CubicSpline(np.linspace(0.0, 1.0, len(degrees) + 1), [*degrees, degrees[0]],
                       bc_type="periodic")  # fmt: skip


# From heel strike to heel strike in tenths, after Winter (2009), Fig. 5.36 and Table A, smoothed so
# that the standing foot hardly slides.
_HIP = _cycle(27, 22, 13, 3, -6, -13, -10, 5, 20, 28)
_KNEE = _cycle(4, 13, 13, 9, 6, 12, 38, 62, 53, 20)
_ANKLE = _cycle(-1, -5, 2, 6, 9, 8, -14, -9, 0, 2)


def walking(style: Style, time_s: float, phase: float) -> Angles:
    """Level gait; arms swing against the legs. The phase counts strides, left heel first."""
    swing = np.cos(2.0 * np.pi * phase) * style.reach
    angles = standing(style, time_s) | {
        "pelvis": (3.0, 3.0 * np.sin(2.0 * np.pi * phase), -5.0 * swing),
        "abdomen": (1.0, -2.0 * np.sin(2.0 * np.pi * phase), 4.0 * swing),
        "chest": (2.0, 0.0, 6.0 * swing),
    }
    for side, p, s in (("l", phase, 1.0), ("r", phase + 0.5, -1.0)):
        back = -s * swing  # the arm is behind while the leg of its side is in front
        angles |= {
            f"thigh_{side}": (float(_HIP(p % 1.0)), 1.0, -4.0),
            f"calf_{side}": (float(_KNEE(p % 1.0)), 0.0, 0.0),
            f"foot_{side}": (float(_ANKLE(p % 1.0)), 0.0, 0.0),
            f"upper_arm_{side}": (2.0 + 22.0 * back, 9.0, 8.0),
            f"forearm_{side}": (24.0 + 12.0 * back, 0.0, 15.0),
        }
    return angles


STEP_DEG: Final = 45.0
"""How far a foot turns in one unhurried step on the spot, at most (ours)."""
STEP_LIFT: Final = 0.02
"""How high it is lifted, share of the stature (ours)."""


def stepping_round(turn_deg: float, progress: float, step_deg: float = STEP_DEG) -> Feet:
    """Displacements of the feet while the body turns on the spot: they follow it alternately.

    Args:
        turn_deg: of the whole turn, to the left.
        progress: of the body in it, 0 to 1.
        step_deg: how far a foot turns in one step, at most.
    """
    steps = max(ceil(abs(turn_deg) / step_deg), 1)
    feet: Feet = {}
    for late, side in enumerate(SIDES if turn_deg > 0.0 else SIDES[::-1]):
        walked = 2.0 * steps * progress - late
        done = sum(smooth_step(walked - 2.0 * k) for k in range(steps))
        lift = sum(4.0 * w * (1.0 - w) for k in range(steps) if (w := smooth_step(walked - 2 * k)))
        feet[side] = Foot(up=STEP_LIFT * lift, turn_deg=turn_deg * (done / steps - progress))
    return feet
