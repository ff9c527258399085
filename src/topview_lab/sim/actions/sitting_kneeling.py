"""Sitting on a chair, and kneeling on one knee."""

from __future__ import annotations

from math import pi, sin
from typing import Final

from topview_lab.sim.actions.act import Act, Angles, Feet, Foot, Moment
from topview_lab.sim.actions.arms import add_angles, idle_trunk
from topview_lab.sim.actions.keyframes import curve
from topview_lab.sim.actions.style import smooth_step
from topview_lab.sim.anthropometry import HIP_SHARE

SEAT_BACK: Final = 0.225
"""How far sitting moves the hip centres back, share of the stature (ours)."""
SEAT_FLESH: Final = 0.058
"""Height of the hip centres above the seat, share of the stature: after the trochanter of Gordon et
al. (1989), less as the flesh is pressed."""
SIT_S: Final = 1.8
"""Duration of sitting down or standing up (ours; Berkeley MHAD's take about as long)."""


def _sat(moment: Moment, down: float) -> Act:
    """Between standing (0) and sitting (1): the trunk leans ahead, the hips go back and down."""
    style, t = moment.style, moment.time_s
    lean = sin(pi * min(down, 1.0)) * style.size(0.1 * t, 4)
    seated = moment.seat_m / moment.stature_m + SEAT_FLESH - HIP_SHARE
    restless = {name: (0.8 * a, b, c) for name, (a, b, c) in _wandering(moment, 1.6).items()}
    angles: Angles = {
        "pelvis": (2.0 + 30.0 * lean - 7.0 * down, 0.0, 0.0),
        "abdomen": (1.0 + 10.0 * lean + 8.0 * down, 0.0, 0.0),
        "chest": (2.0 + 7.0 * lean + 5.0 * down, 0.0, 0.0),
        "neck": (6.0 - 12.0 * lean, 0.0, 0.0),
        "head": (-4.0 - 6.0 * lean, 0.0, 0.0),
    }
    for side, k in (("l", 4), ("r", 5)):
        d = style.drift(t, k)
        angles |= {
            f"upper_arm_{side}": (3.0 + 26.0 * down + 18.0 * lean, 9.0 + 3.0 * d * down, 14.0),
            f"forearm_{side}": (16.0 + 48.0 * down + 4.0 * d * down, 0.0, 25.0),
        }
    back = smooth_step(1.35 * down)
    return Act(
        angles=add_angles(angles, restless),
        hips=(0.006 * style.drift(t, 3) * (1 - down), seated * down, -SEAT_BACK * back),
        support=min(1.6 * down, 1.0),
    )


def _wandering(moment: Moment, effort: float) -> Angles:
    """Slow drifts of the trunk, relative to the standing posture."""
    still = {"pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (2, 0, 0), "neck": (7, 0, 0),
             "head": (-5, 0, 0)}  # fmt: skip
    return {
        name: (effort * (a - still[name][0]), effort * 0.6 * b, effort * c)
        for name, (a, b, c) in idle_trunk(moment).items()
    }


def sitting(moment: Moment) -> Act:
    """Sits, never quite still."""
    return _sat(moment, 1.0)


def sit_down(moment: Moment) -> Act:
    """Stands a moment, sits down and stays."""
    return _sat(moment, smooth_step((moment.time_s - 0.6) * moment.style.tempo / SIT_S))


def stand_up(moment: Moment) -> Act:
    """Sits a moment, stands up and stays."""
    return _sat(moment, 1.0 - smooth_step((moment.time_s - 0.9) * moment.style.tempo / SIT_S))


_DOWN_UP = curve((0.0, 0.0), (0.06, 0.0), (0.38, 1.0), (0.56, 1.0), (0.90, 0.0), (1.0, 0.0))


def sit_down_stand_up(moment: Moment) -> Act:
    """Sits down and stands up, again and again."""
    now = moment.style.repetition(moment.time_s, 5.0)
    return _sat(moment, float(_DOWN_UP(now.phase)))


KNEE_UP: Final = 0.048
"""Height of the knee's centre above the floor while kneeling: half its breadth (ours)."""
THIGH_SHARE: Final = 0.245
_KNEEL = curve((0.0, 0.0), (0.05, 0.0), (0.30, 1.0), (0.66, 1.0), (0.92, 0.0), (1.0, 0.0))


def kneeling(moment: Moment) -> Act:
    """Goes down on the right knee, works with the hands there, gets up again."""
    now = moment.style.repetition(moment.time_s, 7.0)
    return kneel(moment, float(_KNEEL(now.phase)))


def kneel(moment: Moment, down: float) -> Act:
    """Between standing (0) and kneeling on the right knee (1)."""
    step, back = smooth_step(2.4 * down), smooth_step(1.7 * (down - 0.40))
    lean = sin(pi * min(down, 1.0))
    hips_up = THIGH_SHARE + KNEE_UP - HIP_SHARE
    angles: Angles = {
        "pelvis": (2.0 + 24.0 * lean + 6.0 * down, 0.0, 0.0),
        "abdomen": (1.0 + 8.0 * lean + 6.0 * down, 0.0, 0.0),
        "chest": (2.0 + 6.0 * lean + 6.0 * down, 0.0, 0.0),
        "neck": (6.0 + 4.0 * down, 0.0, 0.0),
        "upper_arm_l": (4.0 + 36.0 * down, 10.0, 14.0),
        "upper_arm_r": (4.0 + 40.0 * down, 10.0, 14.0),
        "forearm_l": (16.0 + 40.0 * down, 0.0, 20.0),
        "forearm_r": (16.0 + 46.0 * down, 0.0, 20.0),
    }
    feet: Feet = {
        "l": Foot(front=0.21 * step, up=0.05 * 4.0 * step * (1.0 - step)),
        "r": Foot(
            front=-0.459 * back,
            up=0.024 * back + 0.04 * 4.0 * back * (1.0 - back),
            heel_deg=140.0 * back,
        ),
    }
    hips = (0.008 * moment.style.drift(moment.time_s, 3), hips_up * down, 0.0)
    trunk = add_angles(angles, _wandering(moment, 1.4))
    return Act(trunk, hips, feet=feet, support=min(1.5 * down, 1.0))
