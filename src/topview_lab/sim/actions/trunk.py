"""Bending, bowing, leaning, looking around and turning."""

from __future__ import annotations

from math import pi, sin
from typing import Final

from topview_lab.sim.actions.act import SIDES, Act, Angles, Hand, Hands, Moment, outwards
from topview_lab.sim.actions.arms import add_angles, hip_sway, idle_trunk
from topview_lab.sim.actions.gait import stepping_round
from topview_lab.sim.actions.keyframes import Keyframes, curve
from topview_lab.sim.actions.style import smooth_step


def _both(angles: Angles) -> Angles:
    """The same angles for left and right; segments without a side stay as they are."""
    sided = ("upper_arm", "forearm", "hand")
    return {
        name: value
        for stem, value in angles.items()
        for name in ((f"{stem}_l", f"{stem}_r") if stem in sided else (stem,))
    }


_BENDING = Keyframes(
    (0.00, _both({
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (2, 0, 0), "neck": (6, 0, 0),
        "upper_arm": (3, 9, 10), "forearm": (14, 0, 15), "hand": (0, 0, 0),
    })),
    (0.28, _both({
        "pelvis": (-3, 0, 0), "abdomen": (-6, 0, 0), "chest": (-6, 0, 0), "neck": (-8, 0, 0),
        "upper_arm": (164, 14, -8), "forearm": (12, 0, 10),
    })),
    (0.31, {}),
    (0.61, _both({
        "pelvis": (74, 0, 0), "abdomen": (34, 0, 0), "chest": (22, 0, 0), "neck": (4, 0, 0),
        "upper_arm": (112, 6, 8), "forearm": (8, 0, 20),
    })),
    (0.68, _both({"pelvis": (77, 0, 0), "abdomen": (36, 0, 0), "upper_arm": (108, 6, 8)})),
    (0.97, _both({
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (2, 0, 0), "neck": (6, 0, 0),
        "upper_arm": (3, 9, 10), "forearm": (14, 0, 15),
    })),
    (1.00, {}),
)  # fmt: skip


def bending(moment: Moment) -> Act:
    """Hands up, then down to the feet with straight knees."""
    style = moment.style
    now = style.repetition(moment.time_s, 5.2)
    size = min(style.size(now.k, 4), 1.04)
    uneven = {name: (0.0, b, c) for name, (_, b, c) in idle_trunk(moment).items()}
    down = float(_TO_THE_FEET(now.phase))
    apart = 0.055 + 0.01 * style.drift(now.k, 6)
    hands: Hands = {
        side: Hand(
            (apart * outwards(side), 0.095 + 0.02 * style.drift(now.k, 8), 0.115),
            elbow=(0.6 * outwards(side), 0.2, -0.6),
            frame="floor",
            weight=down,
        )
        for side in SIDES
    }
    return Act(add_angles(_BENDING(now.phase, size), uneven), hip_sway(moment, 0.5), hands=hands)


_TO_THE_FEET = curve((0.0, 0.0), (0.36, 0.0), (0.61, 1.0), (0.68, 1.0), (0.94, 0.0), (1.0, 0.0))


def bowing(moment: Moment) -> Act:
    """A bow from the hips with the hands at the thighs, every four seconds."""
    style = moment.style
    now = style.repetition(moment.time_s, 4.0)
    down = float(_BOW(now.phase)) * style.size(now.k, 4)
    angles: Angles = {
        "pelvis": (2.0 + 32.0 * down, 0.0, 0.0),
        "abdomen": (1.0 + 12.0 * down, 0.0, 0.0),
        "chest": (2.0 + 8.0 * down, 0.0, 0.0),
        "neck": (6.0 + 6.0 * down, 0.0, 0.0),
        "upper_arm_l": (3.0 + 36.0 * down, 9.0, 10.0),
        "upper_arm_r": (3.0 + 36.0 * down, 9.0, 10.0),
    }
    uneven = {name: (0.0, b, c) for name, (_, b, c) in idle_trunk(moment).items()}
    return Act(add_angles(angles, uneven), hip_sway(moment, 0.5))


_BOW = curve((0.0, 0.0), (0.08, 0.0), (0.36, 1.0), (0.56, 1.0), (0.86, 0.0), (1.0, 0.0))


def leaning(moment: Moment) -> Act:
    """The trunk leans forward, to the sides and back, the arms hang."""
    style = moment.style
    cycles = style.beat(moment.time_s, 5.0)
    size = style.size(cycles, 4)
    aside, fore = sin(2.0 * pi * cycles) * size, 0.5 * (1.0 - sin(4.0 * pi * cycles + 1.0)) * size
    angles: Angles = {
        "pelvis": (4.0 + 10.0 * fore, 7.0 * aside, 0.0),
        "abdomen": (2.0 + 9.0 * fore, 11.0 * aside, 0.0),
        "chest": (2.0 + 7.0 * fore, 9.0 * aside, 3.0 * aside),
        "neck": (2.0, -8.0 * aside, 0.0),
        "upper_arm_l": (4.0 + 18.0 * fore, 11.0 + 10.0 * max(aside, 0.0), 10.0),
        "upper_arm_r": (4.0 + 18.0 * fore, 11.0 + 10.0 * max(-aside, 0.0), 10.0),
    }
    return Act(angles, hip_sway(moment))


def looking_around(moment: Moment) -> Act:
    """Head and trunk turn to one side, then to the other, up and down."""
    style = moment.style
    cycles = style.beat(moment.time_s, 4.2)
    appearance = sin(2.0 * pi * cycles) * style.size(cycles, 4)
    nod = sin(2.0 * pi * 0.7 * cycles + 0.6)
    trunk = {
        "pelvis": (2.0, 0.0, 7.0 * appearance),
        "abdomen": (1.0, 0.0, 6.0 * appearance),
        "chest": (2.0, 0.0, 10.0 * appearance),
        "neck": (4.0 + 8.0 * nod, 3.0 * appearance, 30.0 * appearance),
        "head": (-4.0 + 9.0 * nod, 2.0 * appearance, 34.0 * appearance),
    }
    return Act(trunk, hip_sway(moment))


ROUND_S: Final = 5.0
"""Duration of a full turn on the spot (ours)."""


def _turn(turn_deg: float, progress: float, moment: Moment) -> Act:
    ahead = turn_deg / 360.0 * 60.0 * 4.0 * progress * (1.0 - progress)
    trunk = add_angles(
        idle_trunk(moment), {"chest": (0, 0, 0.3 * ahead), "neck": (0, 0, 0.5 * ahead)}
    )
    swing = 9.0 * sin(2.0 * pi * abs(turn_deg) / 90.0 * progress)
    arms: Angles = {"upper_arm_l": (2 + swing, 10, 10), "upper_arm_r": (2 - swing, 10, 10)}
    return Act(
        trunk | arms, hip_sway(moment), turn_deg * progress, feet=stepping_round(turn_deg, progress)
    )


def turning(moment: Moment) -> Act:
    """Steps all the way round on the spot, to the left, rests and goes on the other way."""
    now = moment.style.repetition(moment.time_s, ROUND_S + 1.0)
    progress = smooth_step(now.phase * (ROUND_S + 1.0) / ROUND_S)
    return _turn(360.0 if now.k % 2 == 0 else -360.0, progress, moment)


ASIDE_S: Final = 1.0


def _aside(turn_deg: float, moment: Moment) -> Act:
    """Turned to a side. The action steps there itself, as fading it in would slide the feet."""
    there, back = moment.time_s / ASIDE_S, moment.remaining_s / ASIDE_S
    return _turn(turn_deg, smooth_step(min(there, back)), moment)


def turned_left(moment: Moment) -> Act:
    """Steps 60 degrees to the left, and back in the end."""
    return _aside(60.0, moment)


def turned_right(moment: Moment) -> Act:
    """Steps 60 degrees to the right, and back in the end."""
    return _aside(-60.0, moment)
