"""A person whose torso has no reading: black cloth swallows the infrared light of a depth camera.

What is left of such a person is a head that floats over a pair of legs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HEAD_HALF_HEIGHT_M, HeadCandidate
from topview.people.height import measured_height
from topview.room.scene import Scene

# Heights in shares of the stature (Drillis & Contini 1966): from over the ankles to under the
# crotch there are but legs; from over the hips to under the armpits there is but a torso.
LEGS = (0.08, 0.45)
SHANKS = (0.08, 0.28)
TORSO = (0.55, 0.80)
# Mean breadth of what is seen of the legs, in statures: from a single shank, 0.06, with one leg
# behind the other, to the hips, 0.2, and clothing (same source; ours).
LEGS_BREADTH = (0.05, 0.24)
# A torso is 0.2 statures broad; ours: what is read of it shows at most a fourth of that.
TORSO_BREADTH = 0.05
# Ours: of this many slices across the legs so many show something; creases may have no reading.
SLICES = 10
SLICES_SEEN = 0.8
# Ours: two shanks side by side may be as broad as a child's torso somewhere, but not mostly.
BULKY_SHARE = 0.5


def stands_on_legs(scene: Scene, head: HeadCandidate, distance_m: NDArray[np.float32]) -> bool:
    """Whether the body found from a head (`body_distance`, [h, w]) is a pair of legs right under
    it, with next to nothing between, that reach from the ground as far up as legs do."""
    is_body = np.isfinite(distance_m)
    stature_m = measured_height(scene, head.center_camera, is_body)
    if stature_m is None:
        return False
    heights_m = scene.heights_m[is_body]
    top_m = scene.height_of(head.center_camera) + HEAD_HALF_HEIGHT_M
    height = 1.0 - (top_m - heights_m) / stature_m
    area = (scene.cloud.depth_m[is_body] / scene.cloud.camera.fx) ** 2 / stature_m**2

    def breadth(band: tuple[float, float]) -> float:
        return float(area[_within(height, band)].sum()) / (band[1] - band[0])

    slices = np.histogram(height, SLICES, LEGS)[0]
    return bool(
        np.count_nonzero(slices) >= SLICES_SEEN * SLICES
        and LEGS_BREADTH[0] < breadth(LEGS) < LEGS_BREADTH[1]
        and breadth(TORSO) < TORSO_BREADTH
        and scene.is_bulky[is_body][_within(height, SHANKS)].mean() < BULKY_SHARE
    )


def _within(height: NDArray[np.floating], band: tuple[float, float]) -> NDArray[np.bool_]:
    return (band[0] < height) & (height < band[1])
