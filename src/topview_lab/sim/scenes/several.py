"""Scenes of several people who hide, meet and touch each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2

import numpy as np

from topview.records import Camera
from topview_lab.sim.bodies import SIM_PART_NAMES
from topview_lab.sim.paths import Path, Route
from topview_lab.sim.render import draw_people
from topview_lab.sim.room import render_room
from topview_lab.sim.scene import Actor, Mount, Room
from topview_lab.sim.scenes.stage import (
    SETTLE_S,
    TO_CAMERA,
    TO_LEFT,
    TO_RIGHT,
    Cast,
    Casting,
    SceneKind,
    Staging,
    clip,
    stands,
)
from topview_lab.sim.skeleton import segment_poses

Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Go:
    """A walk through places from a start time on, and the heading after it."""

    start_s: float
    to: tuple[Place, ...]
    looks_rad: float = TO_CAMERA
    speed_mps: float = 1.0


def route(start: Place, heading_rad: float, *walks: Go) -> Route:
    """A route from a place through several walks."""
    legs = [Path((start,), heading_rad, heading_rad)] if not walks else []
    for walk in walks:
        legs.append(
            Path((start, *walk.to), heading_rad, walk.looks_rad, walk.start_s, walk.speed_mps)
        )
        start, heading_rad = walk.to[-1], walk.looks_rad
    return Route(tuple(legs))


def towards(a: Place, b: Place) -> float:
    """Heading from a to b."""
    return atan2(b[1] - a[1], b[0] - a[0])


def _two_users(casting: Casting) -> Staging:
    first = casting.actor(
        route((-0.65, 2.8), TO_CAMERA, Go(8.0, ((0.0, 2.5), (0.65, 2.7)))),
        (
            clip("waving_one_hand", SETTLE_S, 3.5),
            clip("boxing", 4.0, 7.2),
            clip("crossed_arms", 11.0, 14.0),
            clip("reaching", 14.5),
        ),
    )
    second = casting.actor(
        route((0.65, 3.0), TO_CAMERA, Go(8.3, ((0.0, 3.5), (-0.65, 3.1)))),
        (
            clip("clapping", SETTLE_S, 3.5),
            clip("leaning", 4.0, 7.5),
            clip("hands_behind_back", 11.5, 14.0),
            clip("waving_two_hands", 14.5),
        ),
    )
    return Staging([first, second])


def _crossing(casting: Casting) -> Staging:
    near = route(
        (-1.0, 2.4), TO_CAMERA,
        Go(0.6, ((0.95, 2.4),), TO_LEFT, 0.9), Go(4.6, ((-1.0, 2.4),), TO_RIGHT, 1.1),
        Go(8.4, ((0.95, 2.5),), TO_CAMERA, 0.8),
    )  # fmt: skip
    far = route(
        (1.2, 3.3), TO_CAMERA,
        Go(0.8, ((-1.2, 3.3),), TO_CAMERA, 1.0), Go(4.8, ((1.2, 3.4),), TO_CAMERA, 1.1),
        Go(8.4, ((-1.0, 3.3),), TO_CAMERA, 1.0),
    )  # fmt: skip
    return Staging([casting.actor(near), casting.actor(far)])


def _meet(gap_m: float, leave_s: float, y: float) -> tuple[Route, Route]:
    """Two routes that meet in the middle, face to face, and part again."""
    half = gap_m / 2
    return (
        route((-1.0, y), TO_CAMERA, Go(0.7, ((-half, y),), TO_RIGHT, 0.9),
              Go(leave_s, ((-1.0, y + 0.1),), TO_CAMERA, 0.9)),
        route((1.0, y), TO_CAMERA, Go(0.8, ((half, y),), TO_LEFT, 0.9),
              Go(leave_s + 0.2, ((1.0, y + 0.1),), TO_CAMERA, 0.9)),
    )  # fmt: skip


def _handshake(casting: Casting) -> Staging:
    y = casting.rng.uniform(2.7, 3.0)
    left, right = _meet(0.86, 6.2, y)
    shake = clip("handshake", 2.6, 5.9, target_room=(0.0, y, 1.02), ramp_s=0.6)
    return Staging([
        casting.actor(left, (shake, clip("waving_one_hand", 9.0, side="l"))),
        casting.actor(right, (shake, clip("crossed_arms", 9.2))),
    ])  # fmt: skip


def _hug(casting: Casting) -> Staging:
    left, right = _meet(0.40, 6.2, casting.rng.uniform(2.7, 3.0))
    hug = clip("hug", 2.6, 5.9, ramp_s=0.9)
    return Staging([casting.actor(left, (hug,)), casting.actor(right, (hug,))])


def _throw_between(casting: Casting) -> Staging:
    a, b = (-0.95, 2.9), (0.95, 3.1)
    throws, catches = (clip(name, SETTLE_S) for name in ("throw_to", "catch_from"))
    return Staging([
        casting.actor(stands(*a, 0.75 * towards(a, b) + 0.25 * TO_CAMERA), (throws,)),
        casting.actor(stands(*b, TO_LEFT + 0.5), (catches,)),
    ])  # fmt: skip


def _enter_and_leave(casting: Casting) -> Staging:
    stays = casting.actor(
        stands(-0.2, 3.3),
        (clip("looking_around", SETTLE_S, 7.5), clip("boxing", 8.0, 12.0), clip("pointing", 12.5)),
    )
    first = casting.actor(
        route((-2.3, 2.6), TO_RIGHT, Go(0.8, ((0.6, 2.5),), TO_CAMERA, 1.0),
              Go(8.0, ((2.35, 2.6),), TO_RIGHT, 1.1)),
        (clip("waving_one_hand", 4.6, 7.4, side="l"),),
    )  # fmt: skip
    second = casting.actor(
        route((2.6, 3.5), TO_LEFT, Go(4.5, ((0.85, 3.7),), TO_CAMERA, 1.0),
              Go(12.0, ((2.6, 3.5),), TO_RIGHT, 1.1)),
        (clip("crossed_arms", 8.0, 11.4),),
    )  # fmt: skip
    return Staging([stays, first, second])


DUMMY_Y_M, USER_Y_M = 2.25, 3.1
TINY = Camera(fx=131.25, fy=131.25, cx=79.5, cy=59.5, width=160, height=120)


def _dummy_occluder(casting: Casting) -> Staging:
    """Person 2 steps between the camera and person 1 and hides a share of the trunk, twice."""
    user = casting.actor(
        stands(0.0, USER_Y_M),
        (
            clip("leaning", SETTLE_S, 4.5),
            clip("raise_arms", 5.0, 8.0),
            clip("marching", 8.2, 10.8),
            clip("leaning", 11.0, 13.2),
            clip("turned_left", 13.4, 16.4),
            clip("turned_right", 16.6, 19.6),
            clip("marching", 19.8, 22.0),
            clip("reaching", 22.2),
        ),
    )
    dummy = casting.actor(stands(0.0, DUMMY_Y_M))
    spots = [(_hiding_x(user, dummy, share), DUMMY_Y_M) for share in (0.3, 0.6)]
    way = route(
        (-1.9, 1.95), TO_RIGHT, Go(3.6, (spots[0],), TO_CAMERA, 0.9),
        Go(11.4, (spots[1],), TO_CAMERA, 0.3), Go(19.0, ((-1.9, 1.95),), TO_LEFT, 1.0),
    )  # fmt: skip
    return Staging([user, replace(dummy, performance=replace(dummy.performance, path=way))])


def _hiding_x(user: Actor, dummy: Actor, share: float) -> float:
    """The x at which the dummy, coming from the left, hides a share of the user's trunk; found by
    rendering."""
    background = render_room(Room(), (), TINY, Mount())
    T_camera_room = Mount().T_camera_room()
    trunk = [SIM_PART_NAMES.index(part) for part in ("upper_torso", "lower_torso")]

    def seen(*xs: float) -> int:
        """Pixels of the user's trunk, with a dummy at x if one is given."""
        bodies, poses = [user.body], [user.performance.pose(user.body, 0.0)]
        for x in xs:
            pose = dummy.performance.pose(dummy.body, 0.0)
            bodies.append(dummy.body)
            poses.append(replace(pose, root_room=pose.root_room + np.array([x, 0.0, 0.0])))
        Ts = [
            T_camera_room @ segment_poses(body.offsets_m, pose)
            for body, pose in zip(bodies, poses, strict=True)
        ]
        drawn = draw_people(bodies, Ts, background, TINY)
        return int(((drawn.instance == 1) & np.isin(drawn.part, trunk)).sum())

    whole = seen()
    low, high = -0.9, 0.0
    for _ in range(7):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if seen(middle) > (1.0 - share) * whole else (low, middle)
    return 0.5 * (low + high)


def _four_users(casting: Casting) -> Staging:
    hands = clip("handshake", 9.4, 12.4, target_room=(0.05, 2.7, 1.02), ramp_s=0.6)
    again = clip("handshake", 33.6, 36.6, target_room=(0.1, 3.6, 1.02), ramp_s=0.6)
    return Staging([
        casting.actor(
            route((-1.0, 2.7), TO_CAMERA, Go(6.5, ((-0.38, 2.7),), TO_RIGHT),
                  Go(13.0, ((-1.0, 2.6),)), Go(25.0, ((-0.95, 2.9),)),
                  Go(39.0, ((0.0, 2.5), (0.95, 2.8)))),
            (clip("waving_one_hand", 0.5, 4.0, side="l"), hands, clip("boxing", 17.0, 23.0),
             clip("looking_around", 28.0, 33.0), clip("pointing", 33.5, 38.0, side="l"),
             clip("clapping", 44.0)),
        ),
        casting.actor(
            route((1.0, 2.7), TO_CAMERA, Go(6.3, ((0.48, 2.7),), TO_LEFT),
                  Go(13.2, ((1.0, 2.7),)), Go(40.5, ((0.2, 3.1), (-0.95, 2.9)))),
            (clip("crossed_arms", 0.8, 5.2), hands, clip("pointing", 17.0, 24.0),
             clip("clapping", 26.0, 30.0), clip("leaning", 30.5, 37.0), clip("throwing", 45.0)),
        ),
        casting.actor(
            route((-0.5, 3.7), TO_CAMERA, Go(13.0, ((0.1, 4.0), (0.75, 3.8))),
                  Go(30.5, ((0.53, 3.6),), TO_LEFT), Go(37.0, ((0.6, 3.9),))),
            (clip("looking_around", 0.5, 6.0), clip("hands_behind_back", 6.5, 12.0),
             clip("reaching", 18.0, 29.0), again, clip("crossed_arms", 41.0)),
        ),
        casting.actor(
            route((0.5, 3.8), TO_CAMERA, Go(13.6, ((0.0, 3.4), (-0.65, 3.6))),
                  Go(30.8, ((-0.33, 3.6),), TO_RIGHT), Go(37.2, ((-0.45, 3.9),))),
            (clip("waving_two_hands", 0.5, 5.0), clip("bowing", 5.5, 12.5),
             clip("boxing", 18.5, 24.0), clip("pointing", 24.5, 29.5), again,
             clip("waving_one_hand", 41.0)),
        ),
    ])  # fmt: skip


def _kind(about: str, cast: Cast, frames: int) -> SceneKind:
    return SceneKind(about, cast, frames, group="several people")


SEVERAL: dict[str, SceneKind] = {
    "dummy_occluder": _kind(
        "one leans, turns and lifts limbs, another hides 30 %, then 60 % of the trunk",
        _dummy_occluder, 750,
    ),
    "two_users": _kind("two gesture side by side and change places", _two_users, 540),
    "four_users": _kind("four gesture, walk, cross and shake hands", _four_users, 1500),
    "crossing": _kind("two walk to and fro, one behind the other", _crossing, 360),
    "handshake": _kind("two meet, shake hands and part", _handshake, 330),
    "hug": _kind("two meet, hug and part", _hug, 300),
    "throw_between": _kind("two throw each other a ball", _throw_between, 400),
    "enter_and_leave": _kind("one stays, two come and go", _enter_and_leave, 480),
}  # fmt: skip
