"""One moment of an action: joint angles, place of the hips, and targets of hands and feet.

Actions are written for the right hand or foot; `Act.mirrored` gives the left-handed ones.

Angles are in degrees, lengths in shares of the person's stature.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final, Literal

from topview_lab.sim.actions.style import Style

Side = Literal["l", "r"]
SIDES: Final[tuple[Side, Side]] = ("l", "r")
ALTERNATING: Final[tuple[tuple[Side, float], ...]] = (("r", 0.0), ("l", 0.5))
"""Sides that alternate, and by how many cycles each lags."""
Vector = tuple[float, float, float]
Angles = dict[str, tuple[float, float, float]]
"""Flexion, abduction and twist by segment, in the senses of `topview_lab.sim.skeleton.SEGMENTS`."""


def other(side: Side) -> Side:
    """The other side."""
    return "l" if side == "r" else "r"


def outwards(side: Side) -> float:
    """1 for the left, -1 for the right: the sign of x in a person's frame."""
    return 1.0 if side == "l" else -1.0


@dataclass(frozen=True, slots=True)
class Moment:
    """What an action may depend on.

    Attributes:
        style: of the person who acts.
        time_s: since the action began.
        left_s: until the action ends.
        stature_m: of the person.
        seat_m: height of the seat behind the person, if there is one.
        target_room: (x, y, z) in metres in the room that the hands reach for, or None.
    """

    style: Style
    time_s: float
    remaining_s: float
    stature_m: float
    seat_m: float
    target_room: Vector | None


@dataclass(frozen=True, slots=True)
class Foot:
    """The displacement of a foot from the place where it stands.

    Attributes:
        left, up, front: of its toes.
        heel_deg: how far the foot is turned up about the toes.
        turn_deg: of the foot and of its place about the person's vertical, to the left.
    """

    left: float = 0.0
    up: float = 0.0
    front: float = 0.0
    heel_deg: float = 0.0
    turn_deg: float = 0.0

    def mirrored(self) -> Foot:
        """The other foot's."""
        return replace(self, left=-self.left, turn_deg=-self.turn_deg)


@dataclass(frozen=True, slots=True)
class Hand:
    """What a palm reaches for.

    Attributes:
        at: left, up and front of the mid spine with the chest's axes, or of the floor where the
            person stands; x, y and z in metres in the room.
        elbow: where the elbow points to, with the chest's axes.
        palm_deg: twist of the forearm.
        frame: of `at`.
        weight: 0 where the arm only follows its joint angles.
    """

    at: Vector
    elbow: Vector = (0.0, -1.0, 0.0)
    palm_deg: float = 0.0
    frame: Literal["chest", "floor", "room"] = "chest"
    weight: float = 1.0

    def mirrored(self) -> Hand:
        """The other hand's."""
        (left, up, front), (x, y, z) = self.at, self.elbow
        at = self.at if self.frame == "room" else (-left, up, front)
        return replace(self, at=at, elbow=(-x, y, z))


Feet = dict[Side, Foot]
Hands = dict[Side, Hand]


@dataclass(frozen=True, slots=True)
class Act:
    """One moment of an action.

    Attributes:
        angles: of the segments that take part.
        hips: left, up and front, from where they are while standing.
        turn_deg: of the whole person about the vertical, to the left.
        feet: those that leave their places.
        hands: what palms reach for.
        support: 0 to 1, how much of the weight something other than the soles carries (a seat, a
            knee, the momentum of a jump). At 0 the hips move to keep the balance.
    """

    angles: Angles = field(default_factory=dict)
    hips: Vector = (0.0, 0.0, 0.0)
    turn_deg: float = 0.0
    feet: Feet = field(default_factory=dict)
    hands: Hands = field(default_factory=dict)
    support: float = 0.0

    def mirrored(self) -> Act:
        """The same with left and right exchanged; what is in the room stays where it is."""
        left, up, front = self.hips
        return Act(
            angles={
                _other_name(name): (flexion, abduction, twist)
                if _other_name(name) != name
                else (flexion, -abduction, -twist)
                for name, (flexion, abduction, twist) in self.angles.items()
            },
            hips=(-left, up, front),
            turn_deg=-self.turn_deg,
            feet={other(side): foot.mirrored() for side, foot in self.feet.items()},
            hands={other(side): hand.mirrored() for side, hand in self.hands.items()},
            support=self.support,
        )


def _other_name(name: str) -> str:
    return name[:-1] + {"l": "r", "r": "l"}[name[-1]] if name[-2:] in ("_l", "_r") else name
