"""Surfaces in a depth image: where they end, what is bulky, and how far it is along them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.kernels.scene import find_cores
from topview.kernels.segmentation import geodesic_distance

# Depths of neighbouring pixels on one surface differ by up to this, plus three standard deviations
# of the noise of both (`depth_noise_m`); ours: a hand on a hip is further away from what is behind.
JUMP_M = 0.04
JUMP_PER_SQUARE_M = 0.0035


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
    inset_m = np.empty_like(cloud.depth_m)
    is_core = np.empty(inset_m.shape, np.bool_)
    core_m2 = find_cores(
        np.asarray(cv2.distanceTransform(is_inner, cv2.DIST_L2, 3), np.float32),
        cloud.depth_m,
        cloud.camera.fx,
        bulk_radius_m,
        inset_m,
        is_core,
    )
    is_bulky = _within(cloud, is_allowed, is_core, bulk_radius_m)
    if core_m2 <= huge_core_m2:
        return inset_m, is_bulky, np.zeros_like(is_bulky)
    _, numbers = cv2.connectedComponents(is_core.view(np.uint8), connectivity=4)
    labels = np.asarray(numbers, np.int32)
    pixel_m = cloud.depth_m / np.float32(cloud.camera.fx)
    area_m2 = np.bincount(labels.ravel(), (pixel_m * pixel_m).ravel())
    area_m2[0] = 0.0
    is_huge_core = (area_m2 > huge_core_m2)[labels]
    return inset_m, is_bulky, _within(cloud, is_allowed, is_huge_core, bulk_radius_m)


def _within(
    cloud: Cloud, is_allowed: NDArray[np.bool_], is_seed: NDArray[np.bool_], limit_m: float
) -> NDArray[np.bool_]:
    """[h, w] what can be reached from the seeds over the allowed surface."""
    if not is_seed.any():
        return np.zeros_like(is_seed)
    start_m = np.where(is_allowed, np.float32(np.inf), np.float32(-np.inf))
    start_m[is_seed] = 0.0
    return np.isfinite(surface_distance(cloud, start_m, limit_m))


def surface_distance(
    cloud: Cloud, start_m: NDArray[np.float32], limit_m: float
) -> NDArray[np.float32]:
    """[h, w] length of the shortest way over the surface from where `start_m` [h, w] is finite,
    added to it; infinity where there is none up to `limit_m`, none leads where it is minus
    infinity. `start_m` is replaced by it."""
    geodesic_distance(cloud.depth_m, cloud.camera.fx, JUMP_M, JUMP_PER_SQUARE_M, limit_m, start_m)
    return start_m
