"""What tells a person from furniture, in a handful of numbers about a head and the body below it.

Each is about 0 for a person in plain view and has no unit; `Likelihood` weighs them.
"""

from __future__ import annotations

from math import log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HEAD_HALF_HEIGHT_M, HeadCandidate, upright_confidence
from topview.kernels.bodies import measure_body
from topview.people.legs import stands_on_legs
from topview.people.segmentation import left_of
from topview.room.scene import Scene
from topview.room.surfaces import jump_of

Distance = NDArray[np.float32]
Features = NDArray[np.float64]

FEATURE_NAMES: Final = (
    "unlike a head",
    "not upright",
    "head and chest too small",
    "head and chest too large",
    "rough outline",
    "no torso",
    "too low",
    "too high",
    "too much above the head",
    "too large",
    "too short",
    "too spread out",
    "as slim as a post",
    "flat",
    "no torso read",
    "cut by the border",
    "somebody else's",
    "not seen to move",
    "has not moved",
)
"""What is wrong where a feature is large, in their order; those of one frame are `SHAPE`."""
SHAPE: Final = FEATURE_NAMES[:-2]

# Sizes of people: NASA-STD-3000 and Table 3.1, ours where not said. How far over the surface from
# the head's centre the bust and the torso reach.
BUST_REACH_M, TORSO_REACH_M = 0.3, 0.55
# What is so far over the head's top is higher than the head.
OVER_HEAD_M: Final = 0.1
# Smaller jumps than between limbs count as roughness.
ROUGH_M: Final = 0.03
# The visible area of head and shoulders of an adult in front view, and the factor by which children
# and side views differ.
BUST_M2, BUST_FACTOR = 0.085, 1.6
# Pixels on edges over the root of all: of a disc 1.8, of head and shoulders up to 3.
BUST_OUTLINE: Final = 2.6
# A disc of this radius fits into a child's torso, seen from the side.
TORSO_M: Final = 0.09
# From this top of the head down a grown person sits, and up to this top people grow.
LOW_M, HIGH_M, TOP_STEP_M = 1.25, 1.95, 0.15
# Two raised arms, and a big person in front view.
RAISED_M2, LARGE_M2 = 0.09, 0.8
# So far down is the body seen at least, and so much of it is within reach, seen from above.
SHORT_M, ASIDE_M = 0.6, 0.8
# How far below the top a head and a chest are at their broadest.
HEAD_BAND_M, CHEST_BAND_M = (0.05, 0.20), (0.25, 0.50)
# A chest is this many times as broad as its head, from the side 1.3 times.
CHEST_SHARE: Final = 1.6
# Relief of head and chest; the share of the noise that is left in means of 3 x 3 pixels.
PERSON_RELIEF_M, NOISE_LEFT = 0.02, 0.55
# Fewer pixels say nothing about relief.
LEAST_PIXELS: Final = 8
# A head this near to the border may be cut.
BORDER_M: Final = 0.2
# No feature counts for more.
MOST: Final = 4.0


def features_of(scene: Scene, head: HeadCandidate, body: Distance, nearest: Distance) -> Features:
    """[S] `SHAPE` of a head over a body (`body_distance`, [h, w]), as far as no other's head is
    nearer (`nearest`, [h, w])."""
    if head.torso_is_unread and stands_on_legs(scene, head, left_of(body, nearest)):
        return np.zeros(len(SHAPE))
    cloud, center = scene.cloud, head.center_camera
    top_m = scene.height_of(center) + HEAD_HALF_HEIGHT_M
    noise = cloud.camera.noise
    right, forward = scene.overview_of(center).tolist()
    area_m2, above_m2, bust_m2, bottom_m, edges, torso_m, near, chest_m, head_m, kept, seen_m = (
        measure_body(
            scene.standing_px, body, nearest, cloud.depth_m, scene.heights_m, scene.plan_m,
            scene.inset_m, cloud.camera.fx, (right, forward, top_m), OVER_HEAD_M, ASIDE_M,
            (BUST_REACH_M, TORSO_REACH_M), CHEST_BAND_M, HEAD_BAND_M, LEAST_PIXELS,
            jump_of(noise, ROUGH_M),
        )
    )  # fmt: skip
    relief_m = seen_m - NOISE_LEFT * float(noise.sigma_m(float(center[2])))
    upright = upright_confidence(cloud, center, scene.up_camera)
    bust = log(max(bust_m2, 1e-4) / BUST_M2) / log(BUST_FACTOR)
    has_floor = scene.floor is not None
    values = np.array(
        [
            (1.0 - head.confidence) / 0.2,
            (1.0 - upright) / 0.4,
            -bust,
            bust,
            edges - BUST_OUTLINE,
            1.0 - torso_m / TORSO_M,
            (LOW_M - top_m) / TOP_STEP_M * has_floor,
            (top_m - HIGH_M) / TOP_STEP_M * has_floor,
            above_m2 / RAISED_M2,
            log(max(area_m2, 1e-4) / LARGE_M2),
            (SHORT_M - (top_m - bottom_m)) / 0.2 if area_m2 else MOST,
            (1.0 - near) / 0.1,
            (CHEST_SHARE - chest_m / max(head_m, 1e-3)) / 0.3,
            1.0 - relief_m / PERSON_RELIEF_M,
            float(head.torso_is_unread),
            1.0 - _to_border_m(scene, center) / BORDER_M,
            1.0 - kept,
        ]
    )
    return np.minimum(np.maximum(values, 0.0), MOST)


def _to_border_m(scene: Scene, point_camera: NDArray[np.float64]) -> float:
    """From a [3] point to the nearer side of the picture."""
    x, _, z = point_camera.tolist()
    camera = scene.cloud.camera
    column = x / z * camera.fx + camera.cx
    return min(column, camera.width - 1.0 - column) * z / camera.fx
