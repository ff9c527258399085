"""Jumping: on the spot, and with arms and legs apart."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt
from typing import Final

from scipy.interpolate import CubicHermiteSpline

from topview_lab.sim.actions.act import (
    ALTERNATING,
    SIDES,
    Act,
    Angles,
    Feet,
    Foot,
    Moment,
    outwards,
)
from topview_lab.sim.actions.arms import add_angles, idle_trunk
from topview_lab.sim.actions.keyframes import Keyframes
from topview_lab.sim.actions.style import smooth_step
from topview_lab.sim.anthropometry import HIP_SHARE, SOLE_SHARE

GRAVITY: Final = 9.81
"""m/s^2."""
LEG_SHARE: Final = HIP_SHARE - SOLE_SHARE
TOE_SHARE: Final = 0.110
"""The tip of the foot before the ankle, as in `topview_lab.sim.flesh`."""
TOE_OFF_DEG: Final = 36.0
"""How far the heel is up when the toes leave the floor (ours)."""


def heel_rise(heel_deg: float) -> float:
    """How much higher the ankle is than on a flat foot, share of the stature."""
    a = radians(heel_deg)
    return TOE_SHARE * sin(a) - SOLE_SHARE * (1.0 - cos(a))


@dataclass(frozen=True, slots=True)
class Hop:
    """One jump: crouch, push off, fly, land. Seconds since its start, shares of the stature.

    Attributes:
        crouch, landing: how far the hips go down before and after.
        flight_s: between toe-off and touch-down.
        crouch_s, push_s, land_s, rise_s: how long the other phases take.
        stature_m: of the person, for gravity.
    """

    crouch: float
    landing: float
    flight_s: float
    crouch_s: float
    push_s: float
    land_s: float
    rise_s: float
    stature_m: float

    @property
    def takeoff_s(self) -> float:
        """When the toes leave the floor."""
        return self.crouch_s + self.push_s

    @property
    def length_s(self) -> float:
        """From rest to rest."""
        return self.takeoff_s + self.flight_s + self.land_s + self.rise_s

    def flown(self, time_s: float) -> float:
        """How much of the flight is over, 0 to 1."""
        return min(max((time_s - self.takeoff_s) / self.flight_s, 0.0), 1.0)

    def toes_up(self, time_s: float) -> float:
        """Height of the toes: a parabola under gravity while they are in the air."""
        flown = self.flown(time_s)
        fall = 0.5 * GRAVITY * self.flight_s**2 / self.stature_m
        return fall * flown * (1.0 - flown)

    def hips_up(self, time_s: float) -> float:
        """Height of the hips over where they are while standing."""
        speed, top = 0.5 * GRAVITY * self.flight_s / self.stature_m, heel_rise(TOE_OFF_DEG)
        if time_s <= self.takeoff_s:
            times = [0.0, self.crouch_s, self.takeoff_s]
            ground = CubicHermiteSpline(times, [0.0, -self.crouch, top], [0.0, 0.0, speed])
            return float(ground(max(time_s, 0.0)))
        since = time_s - self.takeoff_s - self.flight_s
        if since < 0.0:
            return top + self.toes_up(time_s)
        times = [0.0, self.land_s, self.land_s + self.rise_s]
        ground = CubicHermiteSpline(times, [top, -self.landing, 0.0], [-speed, 0.0, 0.0])
        return float(ground(min(since, times[-1])))

    def heel_deg(self, time_s: float) -> float:
        """How far the heels are up about the toes."""
        up = smooth_step((time_s - self.crouch_s) / self.push_s)
        down = smooth_step((time_s - self.takeoff_s - self.flight_s) / self.land_s)
        return TOE_OFF_DEG * (up - down)


_JUMPING_ARMS = Keyframes(
    (0.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (2, 0, 0), "neck": (6, 0, 0),
        "upper_arm_l": (2, 9, 10), "upper_arm_r": (2, 9, 10),
        "forearm_l": (18, 0, 15), "forearm_r": (18, 0, 15),
    }),
    (0.24, {
        "pelvis": (15, 0, 0), "abdomen": (10, 0, 0), "chest": (8, 0, 0), "neck": (-6, 0, 0),
        "upper_arm_l": (-12, 12, 8), "upper_arm_r": (-12, 12, 8),
        "forearm_l": (28, 0, 15), "forearm_r": (28, 0, 15),
    }),
    (0.57, {
        "pelvis": (0, 0, 0), "abdomen": (-3, 0, 0), "chest": (-2, 0, 0), "neck": (4, 0, 0),
        "upper_arm_l": (28, 18, 6), "upper_arm_r": (28, 18, 6),
        "forearm_l": (38, 0, 15), "forearm_r": (38, 0, 15),
    }),
    (0.76, {
        "pelvis": (12, 0, 0), "abdomen": (6, 0, 0), "chest": (5, 0, 0),
        "upper_arm_l": (14, 16, 8), "upper_arm_r": (14, 16, 8),
        "forearm_l": (34, 0, 15), "forearm_r": (34, 0, 15),
    }),
    (1.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (2, 0, 0), "neck": (6, 0, 0),
        "upper_arm_l": (2, 9, 10), "upper_arm_r": (2, 9, 10),
        "forearm_l": (18, 0, 15), "forearm_r": (18, 0, 15),
    }),
)  # fmt: skip


def _hop(moment: Moment, crouch: float, flight_s: float, length_s: float) -> Hop:
    """A hop of a given duration: crouching and rising share what the other phases leave."""
    push_s, land_s = 0.20, 0.16
    spare_s = length_s - push_s - land_s - flight_s
    return Hop(
        crouch=crouch,
        landing=0.7 * crouch,
        flight_s=flight_s,
        crouch_s=0.55 * spare_s,
        push_s=push_s,
        land_s=land_s,
        rise_s=0.45 * spare_s,
        stature_m=moment.stature_m,
    )


def _steady(moment: Moment) -> Angles:
    """Slow drifts of trunk and head, relative to their posture."""
    return {name: (0.0, b, 0.6 * c) for name, (_, b, c) in idle_trunk(moment).items()}


def jumping_in_place(moment: Moment) -> Act:
    """Jumps up from a crouch, arms swing along; 10 to 20 cm high, never landing quite where the
    jump began."""
    style = moment.style
    now = style.repetition(moment.time_s, 1.35)
    size = min(style.size(now.k, 4), 1.12)
    hop = _hop(moment, 0.068 * size, 0.35 * size, now.length_s)
    t = now.since_s

    def spot(k: int) -> tuple[float, float]:
        return 0.015 * style.drift(k, 9), 0.015 * style.drift(k, 2)

    flown = hop.flown(t)
    left, front = (a + flown * (b - a) for a, b in zip(spot(now.k), spot(now.k + 1), strict=True))
    up, heel_deg = hop.toes_up(t), hop.heel_deg(t)
    return Act(
        angles=add_angles(_JUMPING_ARMS(now.phase, size), _steady(moment)),
        hips=(left, hop.hips_up(t), front),
        feet={side: Foot(left, up, front, heel_deg) for side in SIDES},
        support=1.0,
    )


_JACK_ARMS = Keyframes(
    (0.00, {
        "pelvis": (2, 0, 0), "chest": (2, 0, 0), "neck": (6, 0, 0),
        "upper_arm_l": (2, 9, 10), "upper_arm_r": (2, 9, 10),
        "forearm_l": (14, 0, 15), "forearm_r": (14, 0, 15),
    }),
    (0.10, {"pelvis": (8, 0, 0), "chest": (5, 0, 0)}),
    (0.43, {
        "pelvis": (1, 0, 0), "chest": (-4, 0, 0), "neck": (2, 0, 0),
        "upper_arm_l": (10, 152, -16), "upper_arm_r": (10, 152, -16),
        "forearm_l": (18, 0, 10), "forearm_r": (18, 0, 10),
    }),
    (0.56, {"pelvis": (6, 0, 0), "upper_arm_l": (10, 148, -16), "upper_arm_r": (10, 148, -16)}),
    (0.93, {
        "pelvis": (4, 0, 0), "chest": (3, 0, 0), "neck": (6, 0, 0),
        "upper_arm_l": (3, 9, 10), "upper_arm_r": (3, 9, 10),
        "forearm_l": (14, 0, 15), "forearm_r": (14, 0, 15),
    }),
    (1.00, {"pelvis": (2, 0, 0), "chest": (2, 0, 0), "upper_arm_l": (2, 9, 10),
            "upper_arm_r": (2, 9, 10)}),
)  # fmt: skip
APART: Final = 0.105
"""Sideways displacement of each foot in a jumping jack, share of the stature (ours)."""


def jumping_jacks(moment: Moment) -> Act:
    """Hops with legs apart and arms up, and back again."""
    style = moment.style
    now = style.repetition(moment.time_s, 2.4)
    size = min(style.size(now.k, 4), 1.1)
    half_s = 0.5 * now.length_s
    is_out = now.since_s < half_s
    t = now.since_s if is_out else now.since_s - half_s
    hop = _hop(moment, 0.035 * size, 0.20 * size, half_s)
    flown = hop.flown(t) if is_out else 1.0 - hop.flown(t)
    up, heel_deg = hop.toes_up(t), hop.heel_deg(t)
    reach = APART * size * smooth_step(flown)
    lower = LEG_SHARE - sqrt(LEG_SHARE**2 - (APART * size) ** 2)
    feet: Feet = {
        side: Foot(left=outwards(side) * reach, up=up, heel_deg=heel_deg) for side in SIDES
    }
    return Act(
        angles=add_angles(_JACK_ARMS(now.phase, size), _steady(moment)),
        hips=(0.0, hop.hips_up(t) - lower * flown, 0.0),
        feet=feet,
        support=1.0,
    )


def marching(moment: Moment) -> Act:
    """Lifts the knees in turns on the spot; the hips go over the standing foot."""
    style = moment.style
    cycles = style.beat(moment.time_s, 1.7)
    feet: Feet = {}
    for side, late in ALTERNATING:
        up = max(sin(2.0 * pi * (cycles + late)), 0.0) ** 2 * style.size(cycles + late, 4)
        feet[side] = Foot(up=0.13 * up, front=0.05 * up, heel_deg=18.0 * up)
    aside = 0.030 * sin(2.0 * pi * cycles)
    swing = 14.0 * sin(2.0 * pi * cycles)
    arms: Angles = {
        "upper_arm_l": (4.0 + swing, 10.0, 10.0),
        "upper_arm_r": (4.0 - swing, 10.0, 10.0),
        "forearm_l": (30.0 + 0.6 * swing, 0.0, 15.0),
        "forearm_r": (30.0 - 0.6 * swing, 0.0, 15.0),
    }
    trunk = add_angles(idle_trunk(moment), {"chest": (0.0, 0.0, 0.3 * swing)})
    return Act(trunk | arms, (aside, 0.0, 0.0), feet=feet)
