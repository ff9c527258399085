"""Scenes in which somebody is in some pose from the first frame on: 20 poses in four directions.

The poses were written down from what people do, before any tracker was measured on them. They are
not changed by how a tracker does on them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from topview.records import Camera, InputError
from topview_lab.sim.actions import Angles, Hand, Side, Style
from topview_lab.sim.actions.act import SIDES, outwards
from topview_lab.sim.appearance import random_appearance
from topview_lab.sim.bodies import build_body
from topview_lab.sim.furniture import WOODS, chair, furnished
from topview_lab.sim.held import HeldPose, Holding
from topview_lab.sim.light import Light
from topview_lab.sim.scene import Actor, Box, Furniture, Scene
from topview_lab.sim.scenes.stage import (
    TO_CAMERA,
    TO_LEFT,
    TO_RIGHT,
    TO_WALL,
    seat_under,
    varied_room,
)

START_DIRECTIONS: Final[dict[str, float]] = {
    "front": TO_CAMERA, "left": TO_LEFT, "right": TO_RIGHT, "back": TO_WALL,
}  # fmt: skip
"""Where the front of the upright body points: to the camera, its left, its right, and away."""
START_FRAMES: Final = 30
"""One second."""
Hands = dict[Side, Hand]


def _both(angles: Mapping[str, tuple[float, float, float]]) -> Angles:
    """The same angles for left and right; segments of the trunk as they are."""
    trunk = ("pelvis", "abdomen", "chest", "neck", "head")
    return {
        name: value
        for stem, value in angles.items()
        for name in ((stem,) if stem in trunk or stem[-2:] in ("_l", "_r") else _sides(stem))
    }


def _sides(stem: str) -> tuple[str, str]:
    return f"{stem}_l", f"{stem}_r"


def _palms(left: float, up: float, front: float, elbow: tuple[float, float, float]) -> Hands:
    """Both palms at mirrored places, shares of the stature from the mid spine."""
    return {
        side: Hand(
            (outwards(side) * left, up, front), (outwards(side) * elbow[0], elbow[1], elbow[2])
        )
        for side in SIDES
    }


_STANDING: Final[Angles] = {
    "pelvis": (2, 0, 0), "chest": (3, 0, 0), "neck": (6, 0, 0), "head": (-4, 0, 0),
    "upper_arm": (3, 9, 12), "forearm": (15, 0, 20),
}  # fmt: skip
_SITTING: Final[Angles] = {
    "pelvis": (-5, 0, 0), "abdomen": (8, 0, 0), "chest": (6, 0, 0), "neck": (4, 0, 0),
    "thigh": (85, 6, 0), "calf": (85, 0, 0), "upper_arm": (28, 10, 14), "forearm": (58, 0, 25),
}  # fmt: skip


def _pose(name: str, angles: Angles, hands: Hands | None = None) -> HeldPose:
    return HeldPose(name, _both(angles), hands or {})


START_POSES: Final[dict[str, HeldPose]] = {
    pose.name: pose
    for pose in (
        _pose("lying_on_back", {
            "pelvis": (-90, 0, 0), "neck": (8, 0, 0), "upper_arm": (4, 25, 0),
            "forearm": (15, 0, 20), "thigh": (4, 8, -10), "calf": (6, 0, 0), "foot": (-25, 0, 0),
        }),
        _pose("lying_on_side", {
            "pelvis": (0, 90, 0), "abdomen": (8, 0, 0), "chest": (8, 0, 0), "neck": (5, -10, 0),
            "upper_arm_l": (95, 5, 0), "forearm_l": (40, 0, 0),
            "upper_arm_r": (55, 0, 20), "forearm_r": (45, 0, 20),
            "thigh_l": (25, 0, 0), "calf_l": (35, 0, 0),
            "thigh_r": (55, 0, 0), "calf_r": (65, 0, 0), "foot": (-15, 0, 0),
        }),
        _pose("lying_on_front", {
            "pelvis": (90, 0, 0), "neck": (-8, 0, 35), "head": (-5, 0, 35),
            "upper_arm": (115, 50, 0), "forearm": (75, 0, 0), "thigh": (0, 8, 0),
            "calf": (5, 0, 0), "foot": (-48, 0, 0),
        }),
        _pose("on_all_fours", {
            "pelvis": (70, 0, 0), "abdomen": (3, 0, 0), "chest": (3, 0, 0), "neck": (-22, 0, 0),
            "head": (-18, 0, 0), "upper_arm": (74, 4, 0), "forearm": (4, 0, 0),
            "hand": (-30, 0, 0), "thigh": (70, 4, 0), "calf": (88, 0, 0), "foot": (-45, 0, 0),
        }),
        _pose("kneeling", {
            "pelvis": (2, 0, 0), "chest": (3, 0, 0), "neck": (8, 0, 0), "upper_arm": (8, 9, 12),
            "forearm": (25, 0, 20), "thigh": (3, 6, 0), "calf": (88, 0, 0), "foot": (-45, 0, 0),
        }),
        _pose("on_one_knee", {
            "pelvis": (8, 0, 0), "abdomen": (8, 0, 0), "chest": (6, 0, 0), "neck": (6, 0, 0),
            "upper_arm_l": (40, 8, 14), "forearm_l": (45, 0, 20),
            "upper_arm_r": (12, 10, 14), "forearm_r": (25, 0, 20),
            "thigh_l": (92, 6, 0), "calf_l": (84, 0, 0),
            "thigh_r": (8, 4, 0), "calf_r": (86, 0, 0), "foot_r": (-40, 0, 0),
        }),
        _pose("squatting", {
            "pelvis": (18, 0, 0), "abdomen": (12, 0, 0), "chest": (10, 0, 0), "neck": (-12, 0, 0),
            "head": (-10, 0, 0), "upper_arm": (62, 8, 10), "forearm": (40, 0, 20),
            "thigh": (122, 12, -10), "calf": (134, 0, 0), "foot": (30, 0, 0),
        }),
        _pose("sitting_on_floor", {
            "pelvis": (-12, 0, 0), "abdomen": (10, 0, 0), "chest": (6, 0, 0), "neck": (6, 0, 0),
            "upper_arm": (-38, 18, 0), "forearm": (12, 0, 0), "hand": (-30, 0, 0),
            "thigh": (76, 8, 0), "calf": (8, 0, 0), "foot": (-5, 0, 0),
        }),
        _pose("cross_legged", {
            "pelvis": (-2, 0, 0), "abdomen": (12, 0, 0), "chest": (8, 0, 0), "neck": (4, 0, 0),
            "upper_arm": (25, 14, 10), "forearm": (50, 0, 20),
            "thigh": (92, 58, -88), "calf": (138, 0, 0), "foot": (-20, 0, 0),
        }),
        _pose("sitting_on_chair", _SITTING),
        _pose("sitting_bent", _SITTING | {
            "pelvis": (25, 0, 0), "abdomen": (18, 0, 0), "chest": (12, 0, 0), "neck": (-10, 0, 0),
            "head": (-8, 0, 0), "thigh": (113, 10, 0), "calf": (82, 0, 0), "foot": (-5, 0, 0),
            "upper_arm": (52, 4, 20), "forearm": (78, 0, 25),
        }),
        _pose("bent", {
            "pelvis": (58, 0, 0), "abdomen": (24, 0, 0), "chest": (14, 0, 0), "neck": (4, 0, 0),
            "upper_arm": (92, 6, 8), "forearm": (12, 0, 20), "thigh": (66, 5, 0),
            "calf": (6, 0, 0), "foot": (-4, 0, 0),
        }),
        _pose("arms_up", _STANDING | {"upper_arm": (164, 14, -8), "forearm": (12, 0, 10)}),
        _pose("arms_crossed", _STANDING, {
            "r": Hand((0.088, 0.055, 0.094), (-0.6, -1.0, 0.15), palm_deg=20.0),
            "l": Hand((-0.060, 0.068, 0.150), (0.7, -1.0, 0.25), palm_deg=20.0),
        }),
        _pose("hands_on_hips", _STANDING, _palms(0.105, -0.075, 0.015, (1.0, 0.1, -0.4))),
        _pose("hands_behind_head", _STANDING, _palms(0.03, 0.285, -0.045, (1.0, 0.3, 0.1))),
        _pose("one_leg_up", _STANDING | {
            "thigh_r": (92, 4, 0), "calf_r": (88, 0, 0), "upper_arm_l": (5, 55, 0),
            "upper_arm_r": (5, 55, 0),
        }),
        _pose("lunge", {
            "pelvis": (6, 0, 0), "chest": (4, 0, 0), "neck": (4, 0, 0),
            "upper_arm_l": (-20, 10, 0), "forearm_l": (45, 0, 0),
            "upper_arm_r": (45, 8, 0), "forearm_r": (60, 0, 0),
            "thigh_l": (68, 4, 0), "calf_l": (62, 0, 0),
            "thigh_r": (-18, 2, 0), "calf_r": (28, 0, 0), "foot_r": (10, 0, 0),
        }),
        _pose("half_behind_furniture", _STANDING),
        _pose("cut_by_the_edge", _STANDING),
    )
}  # fmt: skip
"""By name; the last two stand, one behind a desk and one where the image ends."""

ON_CHAIR: Final = ("sitting_on_chair", "sitting_bent")
LONG: Final = ("lying_on_back", "lying_on_side", "lying_on_front", "sitting_on_floor", *ON_CHAIR)
"""Poses that reach far ahead or back on the floor."""
AWAY_M, LONG_AWAY_M = 2.8, 3.2
"""How far away the hips are (ours); from the second on the camera sees the floor before them."""
DESK: Final = Box((0.0, 2.25, 0.5), (1.1, 0.35, 1.0), WOODS[2])
"""Hides the legs and the hips of who stands behind it."""
EDGE_SHARE: Final = 0.96
"""Where in the image's width the hips are of whoever its edge cuts: less than half is outside."""


def start_scene(pose: str, direction: str, seed: int, camera: Camera) -> Scene:
    """Somebody who holds a pose from the first frame on, alone in a room.

    Args:
        pose: one of `START_POSES`.
        direction: one of `START_DIRECTIONS`.
        seed: of the body, the room and the noise.
        camera: intrinsics.

    Raises:
        InputError: there is no such pose or direction, or the seed is negative.
    """
    for what, name, known in (
        ("pose", pose, START_POSES),
        ("direction", direction, START_DIRECTIONS),
    ):
        if name not in known:
            raise InputError(f"{what} is {name!r}; it must be one of {', '.join(known)}")
    if seed < 0:
        raise InputError(f"seed is {seed}; it must be 0 or more")
    rng = np.random.default_rng((seed, *f"{pose} {direction}".encode()))
    body, style = build_body(random_appearance(rng)), Style.sample(rng)
    room, mount = varied_room(rng)
    away_m = LONG_AWAY_M if pose in LONG else AWAY_M
    aside_m = float(rng.uniform(-0.15, 0.15))
    if pose == "cut_by_the_edge":
        column = EDGE_SHARE * camera.width
        aside_m = (column - camera.cx) / camera.fx * away_m
    place = (aside_m, away_m)
    holding = Holding.at(START_POSES[pose], place, START_DIRECTIONS[direction], style)
    return Scene(
        name=f"{pose}_{direction}_{seed}",
        seed=seed,
        frames=START_FRAMES,
        camera=camera,
        mount=mount,
        room=room,
        furniture=(*furnished(rng, room), *_furniture(pose, Actor(body, holding))),
        actors=(Actor(body, holding),),
        light=Light.sample(rng),
    )


def _furniture(pose: str, actor: Actor) -> tuple[Furniture, ...]:
    """What the pose needs: the chair that fits, or the desk."""
    if pose in ON_CHAIR:
        at_first = actor.performance.pose(actor.body, 0.0)
        x, y, _ = at_first.root_room.tolist()
        return chair((x, y), at_first.heading_rad, seat_under(actor.body, at_first), WOODS[0])
    return (DESK,) if pose == "half_behind_furniture" else ()
