"""What people do with things and with each other: point, reach, shake hands, hug, throw."""

from __future__ import annotations

from math import pi, sin

from topview_lab.sim.actions.act import Act, Hand, Hands, Moment, Vector
from topview_lab.sim.actions.arms import THROW_S, add_angles, hip_sway, idle_trunk, throw
from topview_lab.sim.actions.keyframes import Keyframes, curve

_POINT = curve((0.0, 0.0), (0.22, 1.0), (0.74, 1.0), (1.0, 0.0))


def pointing(moment: Moment) -> Act:
    """Points with a straight arm, each time somewhere else; trunk and head go with it."""
    style = moment.style
    now = style.repetition(moment.time_s, 2.8)
    out = float(_POINT(now.phase))
    up, aside = 82.0 + 22.0 * style.drift(3.0 * now.k, 5), 28.0 + 52.0 * style.drift(2.3 * now.k, 9)
    turn = (20.0 - 0.5 * aside) * out
    arm = {
        "upper_arm_r": (3.0 + (up * 0.8 - 0.3 * aside) * out, 9.0 + aside * out, 10.0 - 25.0 * out),
        "forearm_r": (16.0 + 30.0 * out * (1.0 - out) - 8.0 * out, 0.0, 15.0 + 30.0 * out),
        "hand_r": (0.0, 0.0, 0.0),
    }
    more = {
        "abdomen": (2.0 * out, 0.0, 0.2 * turn),
        "chest": (0.0, 0.0, 0.4 * turn),
        "neck": (0.0, 0.0, -0.8 * aside * out),
        "head": (0.0, 0.0, -0.4 * aside * out),
    }
    return Act(add_angles(idle_trunk(moment), more) | arm, hip_sway(moment))


def reaching_out(moment: Moment) -> Act:
    """The right hand fetches things, high and low, near and to the side; the trunk follows."""
    style = moment.style
    now = style.repetition(moment.time_s, 2.8)
    out = float(_REACH(now.phase))
    high, aside = style.drift(3.0 * now.k + 1.0, 5), style.drift(2.3 * now.k, 9)
    at = (-0.11 + 0.18 * aside * out, -0.12 + (0.22 + 0.26 * high) * out, 0.07 + 0.25 * out)
    low = max(0.4 - high, 0.0)
    more = {
        "pelvis": (8.0 * out * low, 0.0, 4.0 * out),
        "abdomen": (7.0 * out, -2.0 * aside * out, 6.0 * out),
        "chest": (6.0 * out, 0.0, (9.0 - 5.0 * aside) * out),
        "neck": (-6.0 * out * high, 0.0, (8.0 * aside - 8.0) * out),
    }
    hands: Hands = {"r": Hand(at, (-0.7, -1.0, -0.2), 15.0)}
    return Act(add_angles(idle_trunk(moment), more), hip_sway(moment), hands=hands)


_REACH = curve((0.0, 0.0), (0.08, 0.0), (0.40, 1.0), (0.58, 1.0), (0.92, 0.0), (1.0, 0.0))


def _target(moment: Moment) -> Vector:
    return moment.target_room or (0.0, 0.0, 0.0)


def handshake(moment: Moment) -> Act:
    """The right hand holds another's at a point in the room, and shakes it."""
    x, y, z = _target(moment)
    shake = 0.035 * sin(2.0 * pi * moment.time_s / 0.42)
    hands: Hands = {"r": Hand((x, y, z + shake), (-0.5, -1.0, -0.3), 0.0, frame="room")}
    more = {"pelvis": (4, 0, 3), "abdomen": (3, 0, 3), "chest": (2, 0, 8), "neck": (0, 0, -8)}
    return Act(add_angles(idle_trunk(moment), more), hip_sway(moment, 0.6), hands=hands)


def hug(moment: Moment) -> Act:
    """Both arms around somebody who stands at a point in the room, the right one over."""
    pat = 0.015 * sin(2.0 * pi * moment.time_s / 0.7)
    hands: Hands = {
        "r": Hand((0.045, 0.13 + pat, 0.25), (-1.0, 0.0, 0.6), 10.0),
        "l": Hand((-0.045, 0.0, 0.24), (1.0, -0.5, 0.6), 10.0),
    }
    more = {"pelvis": (5, 0, 0), "abdomen": (5, 0, 0), "chest": (3, 3, 0), "neck": (4, 12, 10),
            "head": (6, 8, 6)}  # fmt: skip
    return Act(add_angles(idle_trunk(moment, 0.5), more), (-0.012, 0.0, 0.02), hands=hands)


def throw_to(moment: Moment) -> Act:
    """Throws to somebody, waits for the ball, catches it."""
    number, phase = divmod(moment.time_s / THROW_S, 2.0)
    return throw(phase, moment.style.size(number, 4)) if phase < 1.0 else _catch(phase - 1.0)


def catch_from(moment: Moment) -> Act:
    """Waits for the ball, catches it, throws it back."""
    number, phase = divmod(moment.time_s / THROW_S, 2.0)
    return _catch(phase) if phase < 1.0 else throw(phase - 1.0, moment.style.size(number, 4))


_CATCH = Keyframes(
    (0.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "chest": (3, 0, 0), "neck": (6, 0, 0),
        "upper_arm_r": (22, 8, 12), "forearm_r": (85, 0, 10), "hand_r": (0, 0, 0),
        "upper_arm_l": (20, 8, 14), "forearm_l": (80, 0, 10), "hand_l": (0, 0, 0),
    }),
    (0.15, {}),
    (0.50, {
        "pelvis": (8, 0, 0), "abdomen": (5, 0, 0), "upper_arm_r": (62, 2, 12),
        "upper_arm_l": (62, 2, 12), "forearm_r": (40, 0, 10), "forearm_l": (40, 0, 10),
    }),
    (0.60, {"upper_arm_r": (66, 0, 12), "upper_arm_l": (66, 0, 12)}),
    (0.74, {
        "upper_arm_r": (24, 4, 16), "upper_arm_l": (24, 4, 16), "forearm_r": (96, 0, 10),
        "forearm_l": (96, 0, 10),
    }),
    (1.00, {
        "pelvis": (2, 0, 0), "abdomen": (1, 0, 0), "upper_arm_r": (22, 8, 12),
        "forearm_r": (85, 0, 10), "upper_arm_l": (20, 8, 14), "forearm_l": (80, 0, 10),
    }),
)  # fmt: skip


def _catch(phase: float) -> Act:
    low = -0.02 * sin(pi * min(max(phase, 0.0), 1.0))
    return Act(_CATCH(phase), (0.0, low, 0.0))
