"""What people do: joint angles over time, and targets of hands, feet and hips.

Everything is a smooth function of time and of a `Style`, which is drawn once per person.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from topview_lab.sim.actions import arms, classic, jumps, sitting_kneeling, together, trunk
from topview_lab.sim.actions.act import Act, Angles, Foot, Hand, Moment, Side
from topview_lab.sim.actions.gait import standing, stepping_round, walking
from topview_lab.sim.actions.style import Style, smooth_step

__all__ = [
    "ACTIONS",
    "MHAD_ACTIONS",
    "Act",
    "Angles",
    "Foot",
    "Hand",
    "Moment",
    "Side",
    "Style",
    "smooth_step",
    "standing",
    "stepping_round",
    "walking",
]

MHAD_ACTIONS: Final = (
    "jumping_in_place", "jumping_jacks", "bending", "boxing", "waving_two_hands",
    "waving_one_hand", "clapping", "throwing", "sit_down_stand_up", "sit_down", "stand_up",
)  # fmt: skip
"""Those of F. Ofli et al., Berkeley MHAD (WACV 2013), in its order."""

ACTIONS: Final[dict[str, Callable[[Moment], Act]]] = {
    "wave": classic.wave,
    "box": classic.box,
    "raise_arms": classic.raise_arms,
    "reach": classic.reach,
    "jumping_in_place": jumps.jumping_in_place,
    "jumping_jacks": jumps.jumping_jacks,
    "bending": trunk.bending,
    "boxing": arms.punching,
    "waving_two_hands": arms.waving_two_hands,
    "waving_one_hand": arms.waving_one_hand,
    "clapping": arms.clapping,
    "throwing": arms.throwing,
    "sit_down_stand_up": sitting_kneeling.sit_down_stand_up,
    "sit_down": sitting_kneeling.sit_down,
    "stand_up": sitting_kneeling.stand_up,
    "sitting": sitting_kneeling.sitting,
    "kneeling": sitting_kneeling.kneeling,
    "crossed_arms": arms.crossed_arms,
    "hands_behind_back": arms.hands_behind_back,
    "arm_before_trunk": arms.arm_before_trunk,
    "pointing": together.pointing,
    "reaching": together.reaching_out,
    "handshake": together.handshake,
    "hug": together.hug,
    "throw_to": together.throw_to,
    "catch_from": together.catch_from,
    "turning": trunk.turning,
    "turned_left": trunk.turned_left,
    "turned_right": trunk.turned_right,
    "marching": jumps.marching,
    "bowing": trunk.bowing,
    "leaning": trunk.leaning,
    "looking_around": trunk.looking_around,
}
"""The actions by name; each is written for the right hand or foot."""
