"""Scenes in which one of two to four people is hidden entirely for some time, and comes back.

Who hides walks behind a board or behind somebody who stands near the camera, waits there, and comes
out on the same side or on the other one. The scenes were written down before any tracker was
measured on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Final, Literal, cast, get_args

import numpy as np

from topview.records import Camera, InputError
from topview_lab.sim.furniture import WOODS, furnished
from topview_lab.sim.light import Light
from topview_lab.sim.paths import Route
from topview_lab.sim.scene import Actor, Box, Furniture, Mount, Scene
from topview_lab.sim.scenes.several import Go, Place, route
from topview_lab.sim.scenes.stage import SETTLE_S, TO_CAMERA, Casting, clip, stands, varied_room

Hider = Literal["furniture", "person"]
HIDERS: Final[tuple[Hider, ...]] = get_args(Hider)
WHO_HIDES: Final = 0
"""Index of the person who is hidden, in the truth."""
LONGEST_HIDDEN_S: Final = 60.0

# All ours. Places are metres in the room; slopes are x over y of a place, as the camera sees it.
HIDING_MOUNT: Final = Mount(1.2, radians(5))
SEEN_FIRST_S: Final = 2.0  # before who hides sets out
SEEN_AFTER_S: Final = 4.0  # from when who hid sets out again
ASIDE_SLOPE: Final = 0.31  # of who hides, before and after, from the middle of what hides
OTHERS_SLOPE: Final = 0.5
BOARD_M: Final = (0.95, 0.35, 2.1)


@dataclass(frozen=True, slots=True)
class Cover:
    """What hides, and the lane behind it.

    Attributes:
        away_m: y of what hides.
        lane_m: y of who is hidden.
        reach_m: who is so near to the middle of the lane's hidden stretch is hidden entirely.
    """

    away_m: float
    lane_m: float
    reach_m: float


COVERS: Final[dict[Hider, Cover]] = {
    "furniture": Cover(2.4, 3.4, 0.30),
    "person": Cover(1.7, 3.7, 0.15),
}


def hiding_scene(behind: str, hidden_s: float, seed: int, camera: Camera) -> Scene:
    """Somebody comes to be hidden entirely and comes back; people and room depend on the seed and
    on what hides alone.

    Args:
        behind: one of `HIDERS`.
        hidden_s: for how long.
        seed: of people, room and noise.
        camera: intrinsics.

    Raises:
        InputError: nothing of that name hides, or a number is out of range.
    """
    if behind not in HIDERS:
        raise InputError(f"behind is {behind!r}; it must be one of {', '.join(HIDERS)}")
    if not 1.0 <= hidden_s <= LONGEST_HIDDEN_S:
        raise InputError(f"seconds is {hidden_s:g}; it must be 1 to {LONGEST_HIDDEN_S:g}")
    if seed < 0:
        raise InputError(f"seed is {seed}; it must be 0 or more")
    rng = np.random.default_rng((seed, *f"hiding {behind}".encode()))
    casting, cover = Casting(rng), COVERS[cast(Hider, behind)]
    middle = float(rng.uniform(-0.04, 0.04))
    comes_from, goes_to = rng.choice([-1.0, 1.0], 2).tolist()
    way, leaves_s = _in_and_out(cover, middle, (comes_from, goes_to), hidden_s)
    actors = [casting.actor(way)]
    room, _ = varied_room(rng)
    hiders: tuple[Furniture, ...] = ()
    if behind == "person":
        act = clip(("looking_around", "crossed_arms")[int(rng.integers(2))], SETTLE_S)
        actors.append(casting.actor(stands(middle * cover.away_m, cover.away_m), (act,)))
    else:
        width, thickness, height = BOARD_M
        place = middle * cover.away_m, cover.away_m, height / 2
        hiders = (Box(place, (width, thickness, height), WOODS[int(rng.integers(len(WOODS)))]),)
    actors += _others(casting, int(rng.integers(2, 5)) - len(actors))
    return Scene(
        name=f"{behind}_{hidden_s:g}s_{seed}",
        seed=seed,
        frames=round(30.0 * (leaves_s + SEEN_AFTER_S)),
        camera=camera,
        mount=HIDING_MOUNT,
        room=room,
        furniture=(*furnished(rng, room), *hiders),
        actors=tuple(actors),
        light=Light.sample(rng),
    )


def _in_and_out(
    cover: Cover, middle: float, sides: tuple[float, float], hidden_s: float
) -> tuple[Route, float]:
    """The way in and out of the hidden stretch, whose middle has a slope, from one side and to one,
    and when it goes out again."""
    lane_m = cover.lane_m
    inside = middle * lane_m, lane_m
    first, last = ((middle + side * ASIDE_SLOPE) * lane_m for side in sides)
    goes_in = Go(SEEN_FIRST_S, (inside,))
    arrives_s = _crosses_s(route((first, lane_m), TO_CAMERA, goes_in), inside, cover.reach_m)
    out = route(inside, TO_CAMERA, Go(0.0, ((last, lane_m),)))
    gone_s = _crosses_s(out, inside, cover.reach_m)
    leaves_s = arrives_s + hidden_s - gone_s
    return route((first, lane_m), TO_CAMERA, goes_in, Go(leaves_s, ((last, lane_m),))), leaves_s


def _crosses_s(way: Route, place: Place, reach_m: float) -> float:
    """The first time at which a way comes or goes past a distance from a place."""
    times_s = np.arange(0.0, SEEN_FIRST_S + SEEN_AFTER_S, 0.01)
    away_m = np.array([np.hypot(*(way.state_at(t).position_room - place)) for t in times_s])
    is_near = away_m <= reach_m
    return float(times_s[np.argmax(is_near != is_near[0])])


def _others(casting: Casting, count: int) -> list[Actor]:
    """People who stand to the sides and gesture; a third one stands in front of what hides."""
    rng = casting.rng
    gestures = [str(name) for name in rng.permutation(["waving_one_hand", "clapping", "leaning"])]
    slopes = [*(rng.choice([-1.0, 1.0]) * np.array([OTHERS_SLOPE, -OTHERS_SLOPE])), 0.0]
    actors = []
    for slope, gesture in zip(slopes[:count], gestures, strict=False):
        y = float(rng.uniform(2.5, 2.9)) if slope else 1.9
        actors.append(casting.actor(stands(float(slope) * y, y), (clip(gesture, SETTLE_S),)))
    return actors
