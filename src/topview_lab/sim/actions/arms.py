"""What people do with their arms while they stand."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, sin

from topview_lab.sim.actions.act import (
    ALTERNATING,
    SIDES,
    Act,
    Angles,
    Feet,
    Foot,
    Hand,
    Hands,
    Moment,
    Side,
    Vector,
    outwards,
)
from topview_lab.sim.actions.keyframes import Keyframes, curve


def hip_sway(moment: Moment, effort: float = 1.0) -> Vector:
    """Displacement of the hips while the arms move: the weight shifts between the feet."""
    style, t = moment.style, 1.6 * moment.time_s
    return (0.012 * effort * style.drift(t, 13), 0.0, 0.006 * effort * style.drift(t, 15))


def idle_trunk(moment: Moment, effort: float = 1.0) -> Angles:
    """Angles of trunk and head while the arms move: slow drifts about the standing posture."""
    style, t = moment.style, 2.2 * moment.time_s
    d = [1.3 * effort * style.drift(t, 6 + k) for k in range(7)]
    return {
        "pelvis": (2.0 + d[0], 1.2 * d[1], 3.0 * d[2]),
        "abdomen": (1.0 + d[3], -1.5 * d[1], d[4]),
        "chest": (2.0 + 1.5 * d[5], d[6], 2.0 * d[3]),
        "neck": (7.0 + 3.5 * d[4], 2.0 * d[0], -4.0 * d[2]),
        "head": (-5.0 + 4.5 * d[6], 3.0 * d[5], -6.0 * d[3]),
    }


def add_angles(angles: Angles, more: Mapping[str, tuple[float, float, float]]) -> Angles:
    """The sum of two sets of angles; segments that `more` lacks keep theirs."""
    sums = dict(angles)
    for name, (flexion, abduction, twist) in more.items():
        x, y, z = sums.get(name, (0.0, 0.0, 0.0))
        sums[name] = (x + flexion, y + abduction, z + twist)
    return sums


def _wave(moment: Moment, side: Side, late: float = 0.0) -> Angles:
    """An arm beside the head that swings from the elbow and the shoulder."""
    style = moment.style
    cycles = style.beat(moment.time_s, 0.85) + late
    beat = sin(2.0 * pi * cycles) * style.size(cycles, 2 + 3 * (side == "l"))
    raised = style.drift(0.8 * moment.time_s, 9 if side == "l" else 17)
    return {
        f"upper_arm_{side}": (28.0 + 6.0 * beat, 76.0 + 8.0 * raised + 10.0 * beat, -72.0),
        f"forearm_{side}": (88.0 + 6.0 * raised - 36.0 * beat, 0.0, 10.0),
        f"hand_{side}": (0.0, 4.0 - 14.0 * beat, 0.0),
    }


def waving_one_hand(moment: Moment) -> Act:
    """One hand waves beside the head, the trunk leans away from it a little."""
    trunk = add_angles(idle_trunk(moment), {"abdomen": (0.0, 3.0, -2.0)})
    return Act(trunk | _wave(moment, "r"), hip_sway(moment))


def waving_two_hands(moment: Moment) -> Act:
    """Both hands wave, not quite together."""
    late = 0.06 * moment.style.drift(moment.time_s, 19)
    arms = _wave(moment, "l", late) | _wave(moment, "r", -late)
    return Act(idle_trunk(moment) | arms, hip_sway(moment))


def clapping(moment: Moment) -> Act:
    """Hands meet before the chest, about twice a second."""
    style = moment.style
    cycles = style.beat(moment.time_s, 0.55)
    gap = 0.055 * style.size(cycles, 4) * (1.0 + sin(2.0 * pi * cycles))
    x, y = 0.010 * style.drift(moment.time_s, 5), 0.085 + 0.012 * style.drift(moment.time_s, 8)
    hands: Hands = {
        side: Hand(
            (x + outwards(side) * (0.014 + gap), y + 0.010 * outwards(side), 0.195 - 0.4 * gap),
            elbow=(0.6 * outwards(side), -1.0, -0.1),
        )
        for side in SIDES
    }
    return Act(idle_trunk(moment, 0.8), hip_sway(moment, 0.8), hands=hands)


def punching(moment: Moment) -> Act:
    """Boxing from a guard: straight punches in turns, hips and shoulders go with each."""
    style = moment.style
    cycles = style.beat(moment.time_s, 1.0)
    twist = 0.0
    hands: Hands = {}
    for side, late in ALTERNATING:
        to = outwards(side)
        out = max(sin(2.0 * pi * (cycles + late)), 0.0) ** 1.9
        out *= min(style.size(cycles + late, 4 if side == "l" else 10), 1.1)
        wobble = 0.012 * style.drift(1.5 * moment.time_s, 7 if side == "l" else 12)
        hands[side] = Hand(
            (to * (0.062 + 0.10 * out), 0.130 + wobble + 0.125 * out, 0.125 + 0.225 * out),
            elbow=(to * (0.45 + 0.5 * out), -1.0, -0.2),
            palm_deg=10.0 + 60.0 * out,
        )
        twist -= to * out
    bob = sin(4.0 * pi * cycles)
    angles: Angles = {
        "pelvis": (13.0 + 3.5 * bob, 0.0, 11.0 * twist),
        "abdomen": (9.0, 1.5 * twist, 8.0 * twist),
        "chest": (8.0 + 4.0 * bob, 0.0, 11.0 * twist),
        "neck": (4.0, 0.0, -14.0 * twist),
        "head": (-4.0 + 2.0 * style.drift(moment.time_s, 1), 0.0, -8.0 * twist),
    }
    left, _, front = hip_sway(moment, 1.2)
    hips = (left - 0.012 * twist, -0.028 + 0.009 * bob, front + 0.028 * abs(twist))
    feet: Feet = {
        "l": Foot(front=0.07),
        "r": Foot(left=-0.015, front=-0.06, heel_deg=8.0),
    }
    return Act(angles, hips, hands=hands, feet=feet)


_THROW = Keyframes(
    (0.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (3, 0, 0), "neck": (6, 0, 0),
        "upper_arm_r": (22, 8, 12), "forearm_r": (85, 0, 10), "hand_r": (0, 0, 0),
        "upper_arm_l": (20, 8, 14), "forearm_l": (80, 0, 10), "hand_l": (0, 0, 0),
    }),
    (0.12, {}),
    (0.38, {
        "pelvis": (-3, -3, -24), "abdomen": (-6, -4, -12), "chest": (-4, -3, -20),
        "neck": (8, 0, 30), "upper_arm_r": (-14, 88, -62), "forearm_r": (98, 0, 0),
        "hand_r": (-25, 0, 0), "upper_arm_l": (62, 26, 12), "forearm_l": (30, 0, 20),
    }),
    (0.47, {"upper_arm_r": (4, 96, -82), "pelvis": (2, -2, -6)}),
    (0.58, {
        "pelvis": (10, 2, 16), "abdomen": (12, 2, 10), "chest": (10, 0, 16), "neck": (0, 0, -20),
        "upper_arm_r": (98, 42, 6), "forearm_r": (28, 0, 40), "hand_r": (20, 0, 0),
        "upper_arm_l": (10, 22, 14), "forearm_l": (62, 0, 20),
    }),
    (0.70, {
        "pelvis": (14, 3, 20), "abdomen": (14, 2, 12), "chest": (10, 0, 18),
        "upper_arm_r": (48, -16, 34), "forearm_r": (36, 0, 40),
    }),
    (1.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (3, 0, 0), "neck": (6, 0, 0),
        "upper_arm_r": (22, 8, 12), "forearm_r": (85, 0, 10), "hand_r": (0, 0, 0),
        "upper_arm_l": (20, 8, 14), "forearm_l": (80, 0, 10), "hand_l": (0, 0, 0),
    }),
)  # fmt: skip
_STRIDE = curve((0.0, 0.0), (0.22, 0.0), (0.46, 1.0), (0.74, 1.0), (0.94, 0.0), (1.0, 0.0))
_STRIDE_LIFT = curve(
    (0.0, 0.0), (0.2, 0.0), (0.34, 1.0), (0.46, 0.0), (0.74, 0.0), (0.84, 0.7), (0.94, 0.0), (1, 0)
)
_WEIGHT = curve((0.0, 0.0), (0.3, -0.6), (0.5, 0.6), (0.62, 1.0), (0.74, 0.9), (1.0, 0.0))
THROW_S = 3.2
"""Duration of a throw, wind-up and recovery included (ours)."""


def throw(phase: float, size: float) -> Act:
    """An overhand throw at a phase from 0 to 1: wind up, stride, hurl, follow through, recover."""
    stride, weight = float(_STRIDE(phase)), float(_WEIGHT(phase))
    feet: Feet = {
        "l": Foot(front=0.20 * size * stride, up=0.05 * float(_STRIDE_LIFT(phase))),
        "r": Foot(heel_deg=38.0 * max(weight, 0.0) * stride),
    }
    hips = (-0.02 * (1.0 - stride) * abs(weight), -0.02 * stride, 0.10 * size * weight)
    return Act(_THROW(phase, size), hips, feet=feet, support=0.5 * abs(weight))


def throwing(moment: Moment) -> Act:
    """Throws a ball overhand, again and again."""
    style = moment.style
    now = style.repetition(moment.time_s, THROW_S)
    return throw(now.phase, style.size(now.k, 4))


def crossed_arms(moment: Moment) -> Act:
    """Arms crossed before the chest, the left forearm on top."""
    breath = 0.004 * moment.style.drift(moment.time_s, 2)
    hands: Hands = {
        "r": Hand((0.088, 0.055 + breath, 0.094), (-0.6, -1.0, 0.15), palm_deg=20.0),
        "l": Hand((-0.060, 0.068 + breath, 0.150), (0.7, -1.0, 0.25), palm_deg=20.0),
    }
    return Act(idle_trunk(moment), hip_sway(moment), hands=hands)


def hands_behind_back(moment: Moment) -> Act:
    """Hands hold each other behind the back."""
    hands: Hands = {
        side: Hand((0.018 * outwards(side), -0.075, -0.125), (outwards(side), -0.2, -0.8), 60.0)
        for side in SIDES
    }
    return Act(idle_trunk(moment), hip_sway(moment), hands=hands)


def arm_before_trunk(moment: Moment) -> Act:
    """The right arm goes to and fro before the trunk, as if to wipe it."""
    style = moment.style
    across = sin(2.0 * pi * style.beat(moment.time_s, 2.6)) * style.reach
    height = 0.02 + 0.06 * style.drift(moment.time_s, 6)
    hand = Hand((-0.01 + 0.10 * across, height, 0.150), (-0.9, -0.7, 0.1), palm_deg=20.0)
    return Act(
        add_angles(idle_trunk(moment), {"chest": (0, 0, 5 * across)}),
        hip_sway(moment),
        hands={"r": hand},
    )
