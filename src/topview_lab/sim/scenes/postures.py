"""Scenes to learn from: somebody who is in another posture in every frame, as no capture shows.

Who lies, sits on the floor, kneels, squats, bends or goes on all fours; arms and legs anywhere that
the posture leaves free. Somebody on a seat, seen from anywhere. And somebody whose hands are on the
own body, where arms that are drawn freely seldom go.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import atan2, pi
from typing import Final

import numpy as np

from topview.records import Camera
from topview_lab.sim.actions import Angles, Hand, Side, Style
from topview_lab.sim.actions.act import SIDES
from topview_lab.sim.appearance import random_appearance
from topview_lab.sim.bodies import Body, build_body
from topview_lab.sim.furniture import WOODS, Furniture, chair, furnished
from topview_lab.sim.held import HeldPose, Holding
from topview_lab.sim.light import STEADY
from topview_lab.sim.motions import Performance
from topview_lab.sim.scene import Actor, Mount, Room, Scene
from topview_lab.sim.scenes.stage import seat_under, varied_room
from topview_lab.sim.skeleton import SEGMENT_INDEX, SEGMENT_LIMITS_RAD, Pose

POSTURES_A_BODY: Final = 40
"""Frames of one body in one room (ours)."""
SEATED_A_BODY: Final = 10
"""Frames of one body on one seat (ours)."""
TOUCHING_A_BODY: Final = 10
"""Frames of one body with hands on it (ours)."""
STOOL_SHARE: Final = 0.3
"""Of seats, that have no back (ours)."""
LEAST_SEAT_M: Final = 0.25
"""Height of the lowest seat (ours)."""
PLACES_AWAY_M: Final = (1.8, 4.2)
"""How far away the hips are (ours)."""
ASIDE: Final = 0.35
"""How far aside the hips are at most, as a share of how far away (ours)."""
FPS: Final = 30.0
MOUNT_HEIGHTS_M: Final = (0.6, 2.6)
MOUNT_AIMS_M: Final = (0.4, 1.0)
"""Of the camera, and of what it looks at in the middle of the places (ours)."""
DRAWS: Final = 6
"""Of somebody who lies the flattest of so many is taken, as arms seldom prop up the body (ours)."""

Range = tuple[float, float]
Ranges = Mapping[str, tuple[Range, Range, Range]]
"""Least and greatest flexion, abduction and twist by segment or pair of segments, degrees. Those of
a pair are drawn for each side; what is not named is 0. Limits of joints hold besides."""

_FREE_ARMS: Final[Ranges] = {
    "upper_arm": ((-40, 170), (0, 110), (-60, 60)), "forearm": ((0, 145), (0, 0), (-80, 80)),
    "hand": ((-30, 30), (-30, 30), (0, 0)),
}  # fmt: skip
_TRUNK: Final[Ranges] = {
    "abdomen": ((-5, 20), (-12, 12), (-12, 12)), "chest": ((-5, 15), (-12, 12), (-15, 15)),
    "neck": ((-20, 20), (-15, 15), (-30, 30)), "head": ((-15, 20), (-10, 10), (-30, 30)),
}  # fmt: skip
_ON_FLOOR: Final[Ranges] = {
    "upper_arm": ((0, 170), (0, 90), (-40, 40)),
    "forearm": ((0, 140), (0, 0), (-80, 80)),
}
_AT_SIDES: Final[Ranges] = {
    "upper_arm": ((-20, 30), (0, 90), (-40, 40)), "forearm": ((0, 70), (0, 0), (-80, 80)),
    "hand": ((-20, 20), (-20, 20), (0, 0)),
}  # fmt: skip
_STRAIGHT: Final[Ranges] = _TRUNK | _FREE_ARMS | {
    "pelvis": ((-5, 8), (-4, 4), (-5, 5)), "thigh": ((-10, 15), (-3, 15), (-15, 15)),
    "calf": ((0, 15), (0, 0), (0, 0)), "foot": ((-5, 5), (0, 0), (0, 0)),
}  # fmt: skip

POSTURES: Final[Mapping[str, Ranges]] = {
    "on back": _TRUNK | _ON_FLOOR | {
        "pelvis": ((-105, -75), (-15, 15), (0, 0)), "thigh": ((0, 100), (-5, 40), (-20, 20)),
        "calf": ((0, 130), (0, 0), (0, 0)), "foot": ((-45, 10), (0, 0), (0, 0)),
    },
    "flat on back": _TRUNK | _AT_SIDES | {
        "pelvis": ((-100, -80), (-12, 12), (0, 0)), "thigh": ((-5, 20), (-5, 30), (-30, 20)),
        "calf": ((0, 25), (0, 0), (0, 0)), "foot": ((-45, 5), (0, 0), (0, 0)),
    },
    "on left side": _TRUNK | _ON_FLOOR | {
        "pelvis": ((-20, 20), (70, 110), (0, 0)), "thigh": ((0, 110), (-5, 20), (0, 0)),
        "calf": ((0, 130), (0, 0), (0, 0)), "foot": ((-40, 10), (0, 0), (0, 0)),
    },
    "on right side": _TRUNK | _ON_FLOOR | {
        "pelvis": ((-20, 20), (-110, -70), (0, 0)), "thigh": ((0, 110), (-5, 20), (0, 0)),
        "calf": ((0, 130), (0, 0), (0, 0)), "foot": ((-40, 10), (0, 0), (0, 0)),
    },
    "on front": _TRUNK | _ON_FLOOR | {
        "pelvis": ((75, 105), (-15, 15), (0, 0)), "thigh": ((-15, 20), (0, 40), (-20, 20)),
        "calf": ((0, 100), (0, 0), (0, 0)), "foot": ((-50, -20), (0, 0), (0, 0)),
    },
    "flat on front": _TRUNK | _AT_SIDES | {
        "pelvis": ((80, 100), (-12, 12), (0, 0)), "thigh": ((-10, 10), (-5, 30), (-20, 20)),
        "calf": ((0, 25), (0, 0), (0, 0)), "foot": ((-50, -20), (0, 0), (0, 0)),
    },
    "on all fours": _TRUNK | {
        "pelvis": ((50, 95), (-10, 10), (-10, 10)), "thigh": ((45, 110), (-5, 20), (0, 0)),
        "calf": ((50, 110), (0, 0), (0, 0)), "foot": ((-50, -10), (0, 0), (0, 0)),
        "upper_arm": ((50, 115), (-5, 20), (-20, 20)), "forearm": ((0, 40), (0, 0), (-60, 60)),
        "neck": ((-30, 20), (-10, 10), (-25, 25)), "hand": ((-35, 0), (0, 0), (0, 0)),
    },
    "on knees": _TRUNK | _FREE_ARMS | {
        "pelvis": ((-10, 40), (-10, 10), (-10, 10)), "thigh": ((-5, 95), (-5, 30), (-15, 15)),
        "calf": ((80, 148), (0, 0), (0, 0)), "foot": ((-50, -20), (0, 0), (0, 0)),
    },
    "on the floor": _TRUNK | _FREE_ARMS | {
        "pelvis": ((-35, 25), (-8, 8), (-8, 8)), "thigh": ((65, 120), (-5, 50), (-45, 20)),
        "calf": ((0, 145), (0, 0), (0, 0)), "foot": ((-40, 10), (0, 0), (0, 0)),
    },
    "squatting": _TRUNK | _FREE_ARMS | {
        "pelvis": ((0, 45), (-8, 8), (-8, 8)), "thigh": ((80, 125), (0, 30), (-20, 20)),
        "calf": ((85, 145), (0, 0), (0, 0)), "foot": ((0, 35), (0, 0), (0, 0)),
    },
    "bent": _TRUNK | _FREE_ARMS | {
        "pelvis": ((25, 95), (-12, 12), (-10, 10)), "abdomen": ((0, 40), (-12, 12), (-15, 15)),
        "chest": ((0, 30), (-10, 10), (-15, 15)), "thigh": ((25, 100), (-5, 25), (-10, 10)),
        "calf": ((0, 60), (0, 0), (0, 0)), "foot": ((0, 30), (0, 0), (0, 0)),
    },
    "sitting": _TRUNK | _FREE_ARMS | {
        "pelvis": ((-20, 45), (-10, 10), (-10, 10)), "thigh": ((65, 120), (-5, 35), (-20, 20)),
        "calf": ((40, 120), (0, 0), (0, 0)), "foot": ((-30, 15), (0, 0), (0, 0)),
    },
    "sitting bent": _TRUNK | _FREE_ARMS | {
        "pelvis": ((5, 50), (-10, 10), (-10, 10)), "abdomen": ((0, 40), (-12, 12), (-15, 15)),
        "chest": ((0, 30), (-10, 10), (-15, 15)), "thigh": ((80, 125), (-5, 35), (-20, 20)),
        "calf": ((40, 120), (0, 0), (0, 0)), "foot": ((-30, 15), (0, 0), (0, 0)),
    },
    "standing": _TRUNK | _FREE_ARMS | {
        "pelvis": ((-10, 20), (-8, 8), (-10, 10)), "thigh": ((-20, 95), (-5, 35), (-20, 20)),
        "calf": ((0, 110), (0, 0), (0, 0)), "foot": ((-20, 20), (0, 0), (0, 0)),
    },
}  # fmt: skip
"""By name. The pelvis's angles are its turn in the room, as in `topview_lab.sim.held.HeldPose`."""


SEATED: Final = ("sitting", "sitting bent")
KEPT_ON_SEATS: Final = ("pelvis", "thigh", "calf", "foot")
"""Segments, of one side too, that whoever sits on one seat keeps as they are."""
LYING: Final = (
    "on back", "flat on back", "on left side", "on right side", "on front", "flat on front",
)  # fmt: skip
STANDING_STRAIGHT: Final = "upright"
_DRAWN: Final = {**POSTURES, STANDING_STRAIGHT: _STRAIGHT}
STRAIGHT_SHARE: Final = 0.5
"""Of whoever has hands on the own body (ours)."""
OTHERS_TOUCHING: Final = ("standing", "sitting", "on knees", "on the floor", "bent")
BOTH_SHARE: Final = 0.6
"""Of who touches, both of whose hands do the same (ours); of others each hand does as it likes."""
IDLE_HAND_SHARE: Final = 0.3
"""Of these hands, that touch nothing (ours)."""
Ends = tuple[Range, Range, Range]
ON_BODY: Final[Mapping[str, tuple[Ends, Ends]]] = {
    "behind the head": (
        ((0.0, 0.07), (0.2, 0.33), (-0.08, -0.02)), ((1.0, 1.0), (-0.8, 0.8), (-0.4, 1.0))
    ),
    "on the head": (
        ((0.0, 0.06), (0.32, 0.39), (-0.05, 0.05)), ((1.0, 1.0), (-0.8, 0.8), (-0.4, 1.0))
    ),
    "at an ear": (
        ((0.05, 0.09), (0.22, 0.32), (-0.03, 0.05)), ((1.0, 1.0), (-1.0, 0.3), (-0.3, 0.8))
    ),
    "before the face": (
        ((-0.02, 0.06), (0.2, 0.32), (0.06, 0.14)), ((0.8, 1.0), (-1.0, 0.3), (0.0, 0.6))
    ),
    "on the neck": (
        ((0.0, 0.06), (0.12, 0.2), (-0.09, -0.03)), ((1.0, 1.0), (-0.8, 0.5), (-0.2, 1.0))
    ),
    "on the other shoulder": (
        ((-0.12, -0.04), (0.1, 0.16), (0.02, 0.08)), ((0.0, 1.0), (-1.0, 0.0), (0.2, 0.8))
    ),
    "on the chest": (
        ((-0.09, 0.08), (0.0, 0.1), (0.08, 0.15)), ((0.5, 1.0), (-1.0, 0.0), (-0.2, 0.4))
    ),
    "on the belly": (
        ((-0.08, 0.08), (-0.14, 0.0), (0.08, 0.15)), ((0.6, 1.0), (-1.0, 0.2), (-0.5, 0.2))
    ),
    "on a hip": (
        ((0.09, 0.13), (-0.13, -0.04), (-0.04, 0.05)), ((1.0, 1.0), (-0.4, 0.3), (-0.8, 0.3))
    ),
    "behind the back": (
        ((-0.06, 0.08), (-0.13, 0.0), (-0.13, -0.1)), ((0.8, 1.0), (-0.5, 0.1), (-1.0, -0.5))
    ),
}  # fmt: skip
"""Ends between which the left palm may be and its elbow point, as `Hand` has both (ours)."""


def drawn_posture(name: str, rng: np.random.Generator) -> HeldPose:
    """One of `POSTURES`, or somebody upright, its angles drawn evenly between their ends."""
    angles: Angles = {}
    for stem, ranges in _DRAWN[name].items():
        for segment in (stem,) if stem in SEGMENT_INDEX else (f"{stem}_l", f"{stem}_r"):
            limits = np.degrees(SEGMENT_LIMITS_RAD[SEGMENT_INDEX[segment]])
            drawn = [rng.uniform(*between) for between in ranges]
            if segment != "pelvis":
                drawn = np.clip(drawn, limits[:, 0], limits[:, 1]).tolist()
            angles[segment] = (drawn[0], drawn[1], drawn[2])
    return HeldPose(name, angles)


def drawn_hands(rng: np.random.Generator) -> dict[Side, Hand]:
    """Palms on the own body: two that do the same, or each what it likes."""
    if rng.random() < BOTH_SHARE:
        left = _drawn_hand(rng)
        return {"l": left, "r": left.mirrored()}
    hands: dict[Side, Hand] = {}
    for side in SIDES:
        drawn = _drawn_hand(rng)
        if rng.random() > IDLE_HAND_SHARE:
            hands[side] = drawn if side == "l" else drawn.mirrored()
    return hands


def _drawn_hand(rng: np.random.Generator) -> Hand:
    """The left one, somewhere."""
    places = ON_BODY[str(rng.choice(list(ON_BODY)))]
    at, elbow = ([rng.uniform(*between) for between in own] for own in places)
    return Hand((at[0], at[1], at[2]), (elbow[0], elbow[1], elbow[2]), rng.uniform(-60.0, 60.0))


def _resting(
    name: str,
    place: tuple[float, float],
    heading_rad: float,
    body: Body,
    style: Style,
    rng: np.random.Generator,
) -> Holding:
    """Somebody at a place in one of `POSTURES`; of those who lie, who lies flat."""
    draws = DRAWS if name in LYING else 1
    drawn = [Holding.at(drawn_posture(name, rng), place, heading_rad, style) for _ in range(draws)]
    return min(drawn, key=lambda held: float(held.pose(body, 0.0).root_room[2]))


@dataclass(frozen=True, slots=True, eq=False)
class Posing(Performance):
    """One person who is in another posture, at another place, in every frame.

    Attributes:
        holdings: a posture for each frame.
        fps: frames a second.
    """

    holdings: tuple[Holding, ...]
    fps: float

    def _now(self, time_s: float) -> Holding:
        return self.holdings[min(round(time_s * self.fps), len(self.holdings) - 1)]

    def action_at(self, time_s: float) -> str:
        """The name of the posture."""
        return self._now(time_s).action_at(time_s)

    def pose(self, body: Body, time_s: float) -> Pose:
        """The pose of the frame at a time."""
        return self._now(time_s).pose(body, time_s)


def held_postures(scene: Scene, every: int, frames: int) -> list[Scene]:
    """Every so-manieth posture of a scene of this module, each held for so many frames in a scene
    of its own."""
    (actor,) = scene.actors
    posing = actor.performance
    assert isinstance(posing, Posing)
    return [
        replace(
            scene,
            name=f"{scene.name}_{index}",
            frames=frames,
            actors=(Actor(actor.body, replace(posing, holdings=(posing.holdings[index],))),),
        )
        for index in range(0, scene.frames, every)
    ]


def posture_scene(seed: int, camera: Camera) -> Scene:
    """One body in `POSTURES_A_BODY` postures, a frame each, in a room with furniture.

    Args:
        seed: of the body, the postures, the room and the noise.
        camera: intrinsics.
    """
    return _in_turn("postures", seed, camera, POSTURES_A_BODY, _in_posture)


def seated_scene(seed: int, camera: Camera) -> Scene:
    """One body on one seat, turned anywhere, in `SEATED_A_BODY` postures of trunk and arms.

    Args:
        seed: of the body, the postures, the seat, the room and the noise.
        camera: intrinsics.
    """
    rng = np.random.default_rng((seed, *b"seated"))
    body, style = build_body(random_appearance(rng)), Style.sample(rng)
    stage = _stage(rng)
    place, heading_rad = _place(rng), float(rng.uniform(-pi, pi))
    while True:
        seated = drawn_posture(str(rng.choice(SEATED)), rng)
        seat_m = seat_under(body, Holding.at(seated, place, heading_rad, style).pose(body, 0.0))
        if seat_m >= LEAST_SEAT_M:
            break
    legs = {name: own for name, own in seated.angles.items() if name.startswith(KEPT_ON_SEATS)}
    holdings = []
    for _ in range(SEATED_A_BODY):
        drawn = drawn_posture(seated.name, rng)
        held = HeldPose(seated.name, {**drawn.angles, **legs})
        holdings.append(Holding.at(held, place, heading_rad, style))
    seat, back, *rest = chair(place, heading_rad, seat_m, WOODS[0])
    parts = (seat, *rest) if rng.random() < STOOL_SHARE else (seat, back, *rest)
    return _scene("seated", seed, camera, stage, body, holdings, rng, parts)


def touching_scene(seed: int, camera: Camera) -> Scene:
    """One body in `TOUCHING_A_BODY` postures with hands on it, in a room with furniture.

    Args:
        seed: of the body, the postures, the room and the noise.
        camera: intrinsics.
    """
    return _in_turn("touching", seed, camera, TOUCHING_A_BODY, _touching)


def _in_posture(body: Body, style: Style, rng: np.random.Generator) -> Holding:
    place = _place(rng)
    name = str(rng.choice(list(POSTURES)))
    return _resting(name, place, float(rng.uniform(-pi, pi)), body, style, rng)


def _touching(_: Body, style: Style, rng: np.random.Generator) -> Holding:
    is_straight = rng.random() < STRAIGHT_SHARE
    name = STANDING_STRAIGHT if is_straight else str(rng.choice(OTHERS_TOUCHING))
    drawn = drawn_posture(name, rng)
    held = replace(drawn, hands=drawn_hands(rng))
    return Holding.at(held, _place(rng), float(rng.uniform(-pi, pi)), style)


def _in_turn(
    kind: str,
    seed: int,
    camera: Camera,
    frames: int,
    hold: Callable[[Body, Style, np.random.Generator], Holding],
) -> Scene:
    """One body that holds something else in every frame."""
    rng = np.random.default_rng((seed, *kind.encode()))
    body, style = build_body(random_appearance(rng)), Style.sample(rng)
    stage = _stage(rng)
    holdings = [hold(body, style, rng) for _ in range(frames)]
    return _scene(kind, seed, camera, stage, body, holdings, rng)


def _stage(rng: np.random.Generator) -> tuple[Room, Mount]:
    room, _ = varied_room(rng)
    height_m = rng.uniform(*MOUNT_HEIGHTS_M)
    aim_rad = atan2(height_m - rng.uniform(*MOUNT_AIMS_M), sum(PLACES_AWAY_M) / 2)
    return room, Mount(height_m, aim_rad)


def _place(rng: np.random.Generator) -> tuple[float, float]:
    """Of somebody's hips."""
    away_m = float(rng.uniform(*PLACES_AWAY_M))
    return float(rng.uniform(-ASIDE, ASIDE)) * away_m, away_m


def _scene(
    kind: str,
    seed: int,
    camera: Camera,
    stage: tuple[Room, Mount],
    body: Body,
    holdings: Sequence[Holding],
    rng: np.random.Generator,
    seat: tuple[Furniture, ...] = (),
) -> Scene:
    """A frame for each posture, in a room with furniture."""
    room, mount = stage
    first = holdings[0]
    posing = Posing(first.path, (), first.style, tuple(holdings), FPS)
    return Scene(
        name=f"{kind}_{seed}",
        seed=seed,
        frames=len(holdings),
        camera=camera,
        mount=mount,
        room=room,
        furniture=(*furnished(rng, room), *seat),
        actors=(Actor(body, posing),),
        fps=FPS,
        light=STEADY,
    )
