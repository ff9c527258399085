"""A user's stature, from the moments in which he stands upright."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from math import ceil, floor, isnan

import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HEAD_HALF_HEIGHT_M
from topview.kernels.bodies import lowest_of, share_within
from topview.room.scene import Scene

# Mean stature of adults, women and men together, in countries that have depth cameras
# (NCD-RisC 2016: 1.59 m and 1.71 m over the world, 1.66 m and 1.79 m there).
PRIOR_HEIGHT_M = 1.72
MIN_HEIGHT_M, MAX_HEIGHT_M = 1.0, 2.1
# Ours: of one who stands upright, arms down or before him, 90 % are within this share of the
# stature from the head's vertical axis; of one who sits or bends it is a fourth and more.
UPRIGHT_ASIDE = 0.2
# Ours: what is seen of one who stands upright fills no more than this share of the square of the
# stature, of rendered people (seeds 0 to 13) in 99.8 % of the measurements; who sits with the head
# over the lap is broader for that height.
UPRIGHT_AREA = 0.27
# Ours: 80 % of the measurements are below the estimate, as knees and necks are never quite
# straight; noise is above it.
QUANTILE = 0.8
# Ours: for so many seconds of standing upright; what lies between two measurements counts for no
# more than so many.
HEIGHT_MEMORY_S, LONGEST_UPRIGHT_S = 10.0, 0.2
# Of one who stands on the floor an ankle is no higher: 4 % of the tallest stature (NASA-STD-3000),
# and what the noise of the floor hides of it (ours).
ANKLE_M = 0.12
# Ours: what is nearer by more than this hides the feet.
HIDES_M = 0.1
# Ours. Nobody becomes taller: a head above the stature, besides an error, by so much is unlikely.
TALLER_M = 0.04


class HeightEstimate:
    """What has been measured of one user; the mean of all people before that."""

    def __init__(self) -> None:
        self._measured: deque[tuple[float, float]] = deque()
        self._in_order_m: list[float] = []
        self._upright_s = self._last_s = 0.0
        self.height_m = PRIOR_HEIGHT_M

    @property
    def is_measured(self) -> bool:
        """True once the user was seen to stand upright."""
        return bool(self._measured)

    def add(self, height_m: float | None, time_s: float) -> None:
        """What `measured_height` gave for a frame taken at a time."""
        if height_m is None:
            return
        elapsed_s = min(max(time_s - self._last_s, 0.0), LONGEST_UPRIGHT_S)
        self._last_s = time_s
        self._upright_s += elapsed_s
        self._measured.append((self._upright_s, height_m))
        insort(self._in_order_m, height_m)
        while self._upright_s - self._measured[0][0] >= HEIGHT_MEMORY_S:
            oldest = bisect_left(self._in_order_m, self._measured.popleft()[1])
            del self._in_order_m[oldest]
        place = QUANTILE * (len(self._in_order_m) - 1)
        lower, upper = (self._in_order_m[round_(place)] for round_ in (floor, ceil))
        self.height_m = upper - (upper - lower) * (1.0 - place % 1.0)


def sunk_m(scene: Scene, head_camera: NDArray[np.float64], height: HeightEstimate) -> float | None:
    """How far the top of a head at a [3] place is below the stature; None if that or the floor is
    not known."""
    if not height.is_measured or scene.floor is None:
        return None
    return height.height_m - scene.height_of(head_camera) - HEAD_HALF_HEIGHT_M


def measured_height(
    scene: Scene, head_camera: NDArray[np.float64], is_body: NDArray[np.bool_]
) -> float | None:
    """From the ground to the head's top, metres, of one who stands upright; else None.

    The ground is the floor, but of one whose feet are seen to be off it, in a jump; or where none
    is in view the lowest of the body's pixels [h, w], if they end by themselves: not at the
    picture's border nor behind something nearer.
    """
    ground_m = lowest_of(is_body, scene.cloud.depth_m, scene.heights_m, HIDES_M)
    if scene.floor is not None:
        ground_m = np.nan if ground_m > ANKLE_M else 0.0
    if isnan(ground_m):
        return None
    height_m = scene.height_of(head_camera) + HEAD_HALF_HEIGHT_M - ground_m
    if not MIN_HEIGHT_M < height_m < MAX_HEIGHT_M:
        return None
    if _area_m2(scene, is_body) > UPRIGHT_AREA * height_m**2:
        return None
    right, forward = scene.overview_of(head_camera).tolist()
    upright = share_within(scene.plan_m, is_body, right, forward, UPRIGHT_ASIDE * height_m)
    return height_m if upright > 0.9 else None


def _area_m2(scene: Scene, is_body: NDArray[np.bool_]) -> float:
    """Of what is seen of a body's pixels [h, w], as if it faced the camera."""
    camera, depth_m = scene.cloud.camera, scene.cloud.depth_m[is_body]
    return float(np.square(depth_m, dtype=np.float64).sum()) / (camera.fx * camera.fy)
