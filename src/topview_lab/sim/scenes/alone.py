"""One person before the camera."""

from __future__ import annotations

from math import radians

from topview_lab.sim.furniture import WOODS, table
from topview_lab.sim.paths import Path, Route
from topview_lab.sim.scenes.stage import (
    SETTLE_S,
    TO_CAMERA,
    TO_RIGHT,
    TO_WALL,
    Cast,
    Casting,
    SceneKind,
    Staging,
    chair_of,
    clip,
    stands,
)


def _acts(action: str, heading_rad: float = TO_CAMERA) -> Cast:
    """Stands a moment and does it again and again."""

    def cast(casting: Casting) -> Staging:
        rng = casting.rng
        place = stands(rng.uniform(-0.15, 0.15), rng.uniform(2.75, 3.05), heading_rad)
        return Staging([casting.actor(place, (clip(action, SETTLE_S),))])

    return cast


def _on_a_chair(action: str, *, is_seated_first: bool = False) -> Cast:
    """The same with a chair behind."""

    def cast(casting: Casting) -> Staging:
        rng = casting.rng
        turn = TO_CAMERA + radians(rng.uniform(-20.0, 20.0))
        seat_m = rng.uniform(0.42, 0.47)
        start_s = -1.0 if is_seated_first else SETTLE_S
        place = stands(rng.uniform(-0.15, 0.15), rng.uniform(2.6, 2.8), turn)
        actor = casting.actor(place, (clip(action, start_s, seat_m=seat_m),))
        return Staging([actor], chair_of(actor, seat_m))

    return cast


def _sitting(casting: Casting) -> Staging:
    rng = casting.rng
    seat_m = rng.uniform(0.42, 0.47)
    clips = (
        clip("sitting", -2.0, seat_m=seat_m),
        clip("pointing", 2.0, 5.0),
        clip("crossed_arms", 5.5, 8.0),
        clip("waving_one_hand", 8.5, 11.0),
        clip("looking_around", 11.5, 14.0),
        clip("reaching", 14.0),
    )
    turn = TO_CAMERA + radians(rng.uniform(-35.0, 35.0))
    actor = casting.actor(stands(0.0, rng.uniform(2.5, 2.7), turn), clips)
    return Staging([actor], chair_of(actor, seat_m))


def _behind_table(casting: Casting) -> Staging:
    rng = casting.rng
    clips = (
        clip("reaching", SETTLE_S, 6.0),
        clip("pointing", 6.2, 10.0, side="l"),
        clip("clapping", 10.2, 13.0),
        clip("crossed_arms", 13.2, 16.0),
        clip("waving_one_hand", 16.2),
    )
    actor = casting.actor(stands(rng.uniform(-0.2, 0.2), 3.05), clips)
    desk = table((0.0, 2.40), (rng.uniform(1.2, 1.5), 0.65), rng.uniform(0.70, 0.76), WOODS[2])
    return Staging([actor], desk)


def _walking(casting: Casting) -> Staging:
    legs = (
        Path(((-1.0, 3.4), (0.2, 3.6), (1.0, 3.0)), TO_RIGHT, TO_CAMERA, 0.3, 1.1),
        Path(((1.0, 3.0), (0.3, 2.5), (-0.7, 2.6)), TO_CAMERA, TO_CAMERA, 3.8, 0.9),
        Path(((-0.7, 2.6), (-0.3, 3.6), (0.9, 3.7)), TO_CAMERA, TO_RIGHT, 7.5, 1.2),
        Path(((0.9, 3.7), (0.0, 3.0), (-1.0, 3.4)), TO_RIGHT, TO_RIGHT, 11.2, 1.0),
    )
    return Staging([casting.actor(Route(legs))])


def _single_user(casting: Casting) -> Staging:
    """Poses that hide parts of the own body."""
    clips = (
        clip("crossed_arms", 0.8, 4.6, ramp_s=0.8),
        clip("arm_before_trunk", 4.8, 8.8),
        clip("turned_left", 9.2, 15.2),
        clip("reaching", 10.6, 14.0),
        clip("turned_right", 15.6, 21.6),
        clip("crossed_arms", 17.0, 20.2, ramp_s=0.8),
        clip("hands_behind_back", 22.0, 26.0, ramp_s=0.8),
        clip("reaching", 26.4, 32.0),
        clip("kneeling", 32.4, 39.0),
        clip("leaning", 39.4, 45.0),
        clip("arm_before_trunk", 45.2, 49.2, side="l"),
        clip("turned_left", 49.6, 55.6),
        clip("boxing", 50.9, 54.3),
        clip("pointing", 56.0),
    )
    return Staging([casting.actor(stands(0.0, casting.rng.uniform(2.7, 2.9)), clips)])


MHAD: dict[str, SceneKind] = {
    name: SceneKind(about, cast, frames=300, group="the actions of Berkeley MHAD")
    for name, about, cast in (
        ("jumping_in_place", "jumps on the spot", _acts("jumping_in_place")),
        ("jumping_jacks", "hops with legs apart and arms up, and back", _acts("jumping_jacks")),
        ("bending", "hands up, then down to the feet", _acts("bending")),
        ("boxing", "punches from a guard", _acts("boxing")),
        ("waving_two_hands", "waves both hands", _acts("waving_two_hands")),
        ("waving_one_hand", "waves the right hand", _acts("waving_one_hand")),
        ("clapping", "claps", _acts("clapping")),
        ("throwing", "throws a ball overhand", _acts("throwing")),
        ("sit_down_stand_up", "sits down and stands up", _on_a_chair("sit_down_stand_up")),
        ("sit_down", "sits down and stays", _on_a_chair("sit_down")),
        ("stand_up", "sits, then stands up", _on_a_chair("stand_up", is_seated_first=True)),
    )
}

ALONE: dict[str, SceneKind] = {
    "walking": SceneKind("walks to and fro", _walking, 400),
    "turning": SceneKind("steps all the way round, both ways", _acts("turning"), 360),
    "turning_from_behind": SceneKind(
        "the same, first seen from behind", _acts("turning", TO_WALL), 360
    ),
    "reaching": SceneKind("fetches things with the right hand", _acts("reaching"), 300),
    "pointing": SceneKind("points here and there", _acts("pointing"), 300),
    "crossed_arms": SceneKind("crosses the arms", _acts("crossed_arms"), 150),
    "hands_behind_back": SceneKind("hands behind the back", _acts("hands_behind_back"), 150),
    "bowing": SceneKind("bows", _acts("bowing"), 240),
    "leaning": SceneKind("leans forward and to the sides", _acts("leaning"), 300),
    "looking_around": SceneKind("looks around", _acts("looking_around"), 240),
    "marching": SceneKind("lifts the knees in turns", _acts("marching"), 240),
    "kneeling": SceneKind("goes down on a knee and up again", _acts("kneeling"), 300),
    "sitting": SceneKind("sits on a chair and gestures", _sitting, 480),
    "behind_table": SceneKind("stands behind a table and gestures", _behind_table, 540),
    "single_user": SceneKind("a sequence of poses that hide the own body", _single_user, 1800),
}
