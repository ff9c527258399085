"""Is there a person under a head? Measures of the body that hangs together with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HEAD_HALF_HEIGHT_M, HeadCandidate
from topview.kernels.bodies import measure_body, share_within
from topview.people.scene import Scene
from topview.people.surfaces import jump_of


@dataclass(frozen=True, slots=True)
class PersonLimits:
    """What the visible body of a person measures at most and at least.

    From the sizes of grown people up to 2.1 m and children from 1.1 m (NASA-STD-3000; Table 3.1),
    ours where not said.

    Attributes:
        top_over_floor_m: the head's top, from one who sits on the floor to the tallest.
        bust_m2: the visible area within 30 cm of the head's centre over the surface: a head alone
            shows 0.025 m^2, head and shoulders 0.09 m^2; a wall 0.28 m^2.
        above_m2: what is higher than the head: two raised arms show 0.09 m^2.
        area_m2: the whole; a big person in front view shows 0.8 m^2.
        below_top_m: how far down the body must be seen at least.
        bust_edges: pixels there that lie on upper or left depth edges or on holes, over the root
            of all its pixels: the outline of a disc has 1.8, of head and shoulders up to 3, leaves
            have more.
        torso_radius_m: of a disc that must fit into the torso, seen from the side; a hanger with
            clothes, a lamp or a plant is thinner.
        border_m: how much of the picture there must be at both sides of the head.
        aside_m: 90 % of the body is this near to the head, seen from above.
        low_m: furniture is mostly lower; of grown people only some who sit are, and nobody is
            lower than the first but who sits on the floor.
        flat_m: relief of head and chest, besides what the noise leaves; a person's is 2 cm at
            least and 3 cm mostly, a board's none.
    """

    top_over_floor_m: tuple[float, float] = (0.6, 2.2)
    bust_m2: tuple[float, float] = (0.035, 0.14)
    bust_edges: tuple[float, float] = (3.4, 5.0)
    torso_radius_m: tuple[float, float] = (0.055, 0.09)
    border_m: float = 0.1
    above_m2: float = 0.1
    area_m2: float = 1.2
    below_top_m: float = 0.4
    aside_m: float = 0.8
    low_m: tuple[float, float] = (1.0, 1.25)
    flat_m: float = 0.002


# How far over the surface from the head's centre the bust and the chest reach; ours.
BUST_M = 0.3
TORSO_M = 0.55
# What is so far over the head's top is higher than the head; ours.
ABOVE_HEAD_M = 0.1
# Smaller jumps than between limbs count as roughness; ours.
EDGE_M = 0.03
# How far below the top a head and a chest are at their broadest; ours.
HEAD_BELOW_TOP_M = (0.05, 0.20)
CHEST_BELOW_TOP_M = (0.25, 0.50)
# A column's or a board's chest is 1 times as broad as its head, a person's 2.5 times from the front
# and 1.3 times from the side: the farther away, the less exactly it is measured. Ours, per metre
# of a reading's noise.
SLIM_PER_M = 20.0
# Share of a reading's noise that is left of it in the mean of 3 x 3 pixels, as neighbours err
# alike; ours, from recordings and the simulator.
NOISE_LEFT = 0.55
# Fewer pixels say nothing about relief; ours.
LEAST_PIXELS = 8
# Ours: under a head beyond doubt a body may be rougher and larger by this factor: what stands
# close to it, a wall say, may hang together with it.
SURE = 0.95
UNSURE = 0.8
LENIENCE = 1.4
# Ours: what is so much nearer hides a body, if it is along this share of the outline.
NEARER_M = 0.15
HALF_HIDDEN = 0.2
# Ours: what goes on at so nearly the same depth, besides so much noise, is one thing. Of simulated
# people, sitting ones too, less than 0.13 of the outline does in 99 of 100 frames, 0.36 of one who
# was in part taken for the room; of a piece of furniture that somebody had hidden 0.9. Lower than
# feet are high it is the floor.
SAME_M, SAME_NOISE, TORN_OUT, FEET_M = 0.05, 2.5, 0.5, 0.25


@dataclass(frozen=True, slots=True)
class _Measures:
    """What is compared with `PersonLimits`, and named as there.

    Attributes:
        top_m: of the head.
        area_m2: of the whole body.
        above_m2: of what is higher than the head.
        bust_m2: of head and shoulders.
        bottom_m: the lowest height.
        bust_edges: how rough head and shoulders are.
        torso_radius_m: of the largest disc that fits into head and chest.
    """

    top_m: float
    area_m2: float
    above_m2: float
    bust_m2: float
    bottom_m: float
    bust_edges: float
    torso_radius_m: float

    @classmethod
    def of(cls, scene: Scene, head: HeadCandidate, distance_m: NDArray[np.float32]) -> _Measures:
        """Of a body (`body_distance`, [h, w]) under a head."""
        top_m = scene.height_of(head.center_camera) + HEAD_HALF_HEIGHT_M
        return cls(
            top_m,
            *measure_body(
                distance_m,
                scene.cloud.depth_m,
                scene.heights_m,
                scene.inset_m,
                scene.cloud.camera.fx,
                top_m + ABOVE_HEAD_M,
                BUST_M,
                TORSO_M,
                jump_of(scene.cloud.camera.noise, EDGE_M),
            ),
        )


def looks_like_person(
    scene: Scene,
    head: HeadCandidate,
    distance_m: NDArray[np.float32],
    limits: PersonLimits,
) -> bool:
    """Whether the body found from a head (`body_distance`, [h, w]) measures like a person's."""
    return unlike_person(scene, head, distance_m, limits) is None


def unlike_person(
    scene: Scene,
    head: HeadCandidate,
    distance_m: NDArray[np.float32],
    limits: PersonLimits,
) -> str | None:
    """What of the body found from a head (`body_distance`, [h, w]) does not measure like a
    person's, in a few words; None if all does."""
    body = _Measures.of(scene, head, distance_m)
    if not body.area_m2:
        return "no body below"
    lenience = LENIENCE if head.confidence > SURE else 1.0
    x, _, z = head.center_camera.tolist()
    camera = scene.cloud.camera
    column = x / z * camera.fx + camera.cx
    border_px = limits.border_m / z * camera.fx
    low_m, high_m = limits.top_over_floor_m
    right, forward = scene.overview_of(head.center_camera).tolist()
    is_body = distance_m < np.inf
    near = share_within(scene.overview_m, is_body, right, forward, limits.aside_m)
    is_good = {
        "too low or too high": scene.floor is None or low_m < body.top_m < high_m,
        "head and chest too small": body.bust_m2 > limits.bust_m2[0],
        "head and chest too large": body.bust_m2 < lenience * limits.bust_m2[1],
        "cut off by the border": border_px < column < camera.width - border_px,
        "rough outline": body.bust_edges < limits.bust_edges[1],
        "no torso": body.torso_radius_m > limits.torso_radius_m[0],
        "too much above": body.above_m2 < lenience**3 * limits.above_m2,
        "too large": body.area_m2 < lenience * limits.area_m2,
        "too short": body.top_m - body.bottom_m > limits.below_top_m,
        "too spread out": near > 0.9,
    }
    return next((fault for fault, good in is_good.items() if not good), None)


def is_doubtful(
    scene: Scene,
    head: HeadCandidate,
    distance_m: NDArray[np.float32],
    limits: PersonLimits,
    least: int,
) -> bool:
    """Whether what measures like a person may as well be a plant, a shelf or a door: it is at
    `least` so many of low, very low, slim, flat and not quite like a head. A person is seldom two
    of them; most furniture is."""
    if head.torso_is_unread:
        return False
    body = _Measures.of(scene, head, distance_m)
    lenience = LENIENCE if head.confidence > SURE else 1.0
    if (
        body.bust_edges > lenience * limits.bust_edges[0]
        or body.torso_radius_m < limits.torso_radius_m[1]
    ):
        return True
    top_m = body.top_m
    noise_m = float(scene.cloud.camera.noise.sigma_m(head.center_camera[2]))
    is_very_low, is_low = (scene.floor is not None and top_m < low_m for low_m in limits.low_m)
    below_top_m = np.where(np.isfinite(distance_m), top_m - scene.heights_m, np.float32(-1.0))
    chest_m, head_m = (
        _breadth(scene, below_top_m, band) for band in (CHEST_BELOW_TOP_M, HEAD_BELOW_TOP_M)
    )
    is_slim = chest_m < (1.0 + SLIM_PER_M * noise_m) * head_m
    is_flat = _relief_m(scene, distance_m < TORSO_M) < limits.flat_m + NOISE_LEFT * noise_m
    is_unsure = head.by_shape < UNSURE
    return sum((is_very_low, is_low, is_slim, is_flat, is_unsure)) >= least


def is_half_hidden(scene: Scene, distance_m: NDArray[np.float32]) -> bool:
    """Whether at much of a body's (`body_distance`, [h, w]) outline something nearer begins, behind
    which there may be more of it."""
    beside = nearer = 0
    for is_next, back_m in _outline(scene, distance_m < np.inf):
        beside += np.count_nonzero(is_next)
        nearer += np.count_nonzero(is_next & (back_m < -NEARER_M))
    return bool(nearer > HALF_HIDDEN * beside)


def is_torn_out(scene: Scene, distance_m: NDArray[np.float32]) -> bool:
    """Whether at much of a body's (`body_distance`, [h, w]) outline, but for the feet, what is
    known to be the room's goes on at its depth: it is a piece of that, and somebody stood before
    it."""
    beside = same = 0
    is_high = scene.heights_m > FEET_M
    cloud = scene.cloud
    near_m = SAME_M + SAME_NOISE * cloud.camera.noise.sigma_m(cloud.depth_m)
    for is_next, back_m in _outline(scene, distance_m < np.inf):
        beside += np.count_nonzero(is_next & is_high)
        is_on = is_next & is_high & ~scene.is_free_standing & (np.abs(back_m) < near_m)
        same += np.count_nonzero(is_on)
    return bool(same > TORN_OUT * beside)


def _outline(
    scene: Scene, is_body: NDArray[np.bool_]
) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.float32]]]:
    """For each side: which pixels, [h, w], are beside a body there, and by how much they are
    further back than it, metres; infinitely where there is no reading."""
    depth_m = scene.cloud.depth_m
    for axis in (0, 1):
        for step in (1, -1):
            is_next = np.roll(is_body, step, axis) & ~is_body
            back_m = np.where(depth_m > 0.0, depth_m - np.roll(depth_m, step, axis), np.inf)
            yield is_next, back_m


def _breadth(scene: Scene, below_top_m: NDArray[np.float32], band_m: tuple[float, float]) -> float:
    """Mean breadth of what is seen in a band of heights; metres."""
    is_band = (band_m[0] < below_top_m) & (below_top_m < band_m[1])
    area_m2 = (scene.cloud.depth_m[is_band] / scene.cloud.camera.fx) ** 2
    return float(area_m2.sum()) / (band_m[1] - band_m[0])


def _relief_m(scene: Scene, is_body: NDArray[np.bool_]) -> float:
    """Standard deviation from the plane that fits best, in the mean of 3 x 3 pixels; metres.

    The depth's inverse is linear over a plane's image. The outline is left out.
    """
    rows, columns = (np.flatnonzero(is_body.any(axis)) for axis in (1, 0))
    if not len(rows):
        return 0.0
    window = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    is_own = cv2.copyMakeBorder(
        is_body[window].astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0
    )
    is_inner = cv2.erode(is_own, np.ones((3, 3), np.uint8))[1:-1, 1:-1] > 0
    if np.count_nonzero(is_inner) < LEAST_PIXELS:
        return 0.0
    depth_m = scene.cloud.depth_m[window]
    v, u = np.nonzero(is_inner)
    seen = depth_m[is_inner].astype(np.float64)
    design = np.stack([u, v, np.ones(len(u))], axis=1)
    plane, *_ = np.linalg.lstsq(design, 1.0 / seen)
    off_m = np.zeros(is_inner.shape)
    off_m[is_inner] = (1.0 / seen - design @ plane) * seen**2
    around = cv2.blur(off_m, (3, 3)) / np.maximum(
        cv2.blur(is_inner.astype(np.float64), (3, 3)), 0.1
    )
    return float(around[is_inner].std())
