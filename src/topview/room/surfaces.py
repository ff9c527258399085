"""Surfaces in a depth image: where they end, what is bulky, and how far it is along them."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.kernels.noise import Law
from topview.kernels.scene import find_cores
from topview.kernels.segmentation import geodesic_distance
from topview.records import KINECT1_NOISE, DepthNoise

# Depths of neighbouring pixels on one surface differ by up to this, plus what the second is for a
# Kinect, 1/m, and in proportion to the noise for other sensors; ours: a hand on a hip is further
# away from what is behind.
JUMP_M = 0.04
JUMP_PER_SQUARE_M = 0.0035


@lru_cache(maxsize=16)
def jump_of(noise: DepthNoise, constant_m: float = JUMP_M) -> Law:
    """By how much neighbours on one surface differ, as the kernels take it."""
    a, b, c = (x / KINECT1_NOISE.per_square_m * JUMP_PER_SQUARE_M for x in noise.times(1.0))
    return constant_m + a, b, c


def bulky_surfaces(
    cloud: Cloud,
    is_allowed: NDArray[np.bool_],
    is_inner: NDArray[np.uint8],
    bulk_radius_m: float,
    huge_core_m2: float,
) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_]]:
    """[h, w] metres from each pixel to the nearest depth edge, hole or forbidden pixel, which are
    not `is_inner`; what a disc of `bulk_radius_m` fits into between them (a morphological opening);
    and what of it is part of something larger than any person."""
    inset_m, start_m = np.empty_like(cloud.depth_m), np.empty_like(cloud.depth_m)
    core_m2 = find_cores(
        np.asarray(cv2.distanceTransform(is_inner, cv2.DIST_L2, 3), np.float32),
        cloud.depth_m,
        is_allowed,
        cloud.camera.fx,
        bulk_radius_m,
        inset_m,
        start_m,
    )
    if core_m2 == 0.0:
        nowhere = np.zeros_like(is_allowed)
        return inset_m, nowhere, nowhere
    huge_start_m = _only_huge(cloud, start_m, huge_core_m2) if core_m2 > huge_core_m2 else None
    is_bulky = np.isfinite(surface_distance(cloud, start_m, bulk_radius_m))
    if huge_start_m is None:
        return inset_m, is_bulky, np.zeros_like(is_bulky)
    return inset_m, is_bulky, np.isfinite(surface_distance(cloud, huge_start_m, bulk_radius_m))


def _only_huge(
    cloud: Cloud, start_m: NDArray[np.float32], huge_core_m2: float
) -> NDArray[np.float32] | None:
    """[h, w] `start_m` without the cores that are not huge; None if none is left."""
    is_core = start_m == 0.0
    _, numbers = cv2.connectedComponents(is_core.view(np.uint8), connectivity=4)
    labels = np.asarray(numbers, np.int32)
    pixel_m = cloud.depth_m / np.float32(cloud.camera.fx)
    area_m2 = np.bincount(labels.ravel(), (pixel_m * pixel_m).ravel())
    area_m2[0] = np.inf
    is_small_core = (area_m2 <= huge_core_m2)[labels]
    if np.array_equal(is_small_core, is_core):
        return None
    return np.where(is_small_core, np.float32(np.inf), start_m)


def surface_distance(
    cloud: Cloud, start_m: NDArray[np.float32], limit_m: float
) -> NDArray[np.float32]:
    """[h, w] length of the shortest way over the surface from where `start_m` [h, w] is finite,
    added to it; infinity where there is none up to `limit_m`, none leads where it is minus
    infinity. `start_m` is replaced by it."""
    camera = cloud.camera
    geodesic_distance(cloud.depth_m, camera.fx, jump_of(camera.noise), limit_m, start_m)
    return start_m
