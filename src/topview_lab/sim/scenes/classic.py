"""Short scenes in the same room every time."""

from __future__ import annotations

from topview_lab.sim.motions import Clip
from topview_lab.sim.paths import Path
from topview_lab.sim.scenes.stage import (
    TO_CAMERA,
    TO_RIGHT,
    Cast,
    Casting,
    SceneKind,
    Staging,
    stands,
)


def _pass_by(casting: Casting) -> Staging:
    first = casting.actor(
        stands(casting.rng.uniform(-0.05, 0.05), 3.25),
        (Clip("wave", -1.0, 1.75), Clip("box", 1.6, 1e3)),
        sex="man",
    )
    way = Path(
        ((-1.0, 2.3), (0.74, 2.3)), TO_CAMERA, TO_CAMERA, start_s=0.25, speed_mps=0.75
    )  # fmt: skip
    second = casting.actor(way, (Clip("wave", 3.0, 1e3, side="l"),), sex="woman")
    return Staging([first, second])


def _stand_in_front(casting: Casting) -> Staging:
    first = casting.actor(stands(0.0, 3.3), (Clip("raise_arms", 0.5, 1e3),))
    way = Path(
        ((-1.0, 2.3), (-0.12, 2.35)), TO_RIGHT, TO_CAMERA, start_s=0.3, speed_mps=0.9
    )  # fmt: skip
    return Staging([first, casting.actor(way)])


def _walk(casting: Casting) -> Staging:
    way = Path(((-1.0, 3.8), (0.3, 3.3), (0.7, 2.6), (-0.5, 2.4)), TO_RIGHT, TO_CAMERA, 0.3, 1.1)
    return Staging([casting.actor(way)])


def _alone(*actions: str) -> Cast:
    """One person before the camera, each action for two seconds in turn."""

    def build(casting: Casting) -> Staging:
        clips = tuple(
            Clip(action, 0.4 + 2.0 * k, 2.4 + 2.0 * k if k + 1 < len(actions) else 1e3)
            for k, action in enumerate(actions)
        )
        return Staging([casting.actor(stands(0.0, casting.rng.uniform(2.5, 2.9)), clips)])

    return build


def _kind(about: str, cast: Cast) -> SceneKind:
    return SceneKind(about, cast, group="short, in one room", has_varied_room=False)


CLASSIC: dict[str, SceneKind] = {
    "pass_by": _kind("one waves and boxes, another walks past in front and waves", _pass_by),
    "stand_in_front": _kind("one raises the arms, another steps in front", _stand_in_front),
    "walk": _kind("walks a curve towards the camera and across", _walk),
    "stand": _kind("stands", _alone()),
    "wave": _kind("waves", _alone("wave")),
    "box": _kind("boxes", _alone("box")),
    "raise_arms": _kind("raises the arms", _alone("raise_arms")),
    "reach": _kind("reaches forward", _alone("reach")),
    "all_actions": _kind(
        "waves, boxes, raises the arms, reaches", _alone("wave", "box", "raise_arms", "reach")
    ),
}
