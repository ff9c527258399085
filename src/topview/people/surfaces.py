"""Surfaces in a depth image: where they end, what is bulky, and how far it is along them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.kernels.segmentation import geodesic_distance

# Depths of neighbouring pixels on one surface differ by up to this, plus three standard deviations
# of the noise of both (`depth_noise_m`); ours: a hand on a hip is further away from what is behind.
JUMP_M = 0.04
JUMP_PER_SQUARE_M = 0.0035


def inset_of_surfaces(cloud: Cloud, is_allowed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """[h, w] metres from each pixel to the nearest depth edge, hole or forbidden pixel."""
    depth = cloud.depth_m
    jump = JUMP_M + JUMP_PER_SQUARE_M * depth * depth
    is_inner = is_allowed.astype(np.uint8)
    is_inner[:, 1:][np.abs(depth[:, 1:] - depth[:, :-1]) > jump[:, 1:]] = 0
    is_inner[1:][np.abs(depth[1:] - depth[:-1]) > jump[1:]] = 0
    inset_px = cv2.distanceTransform(is_inner, cv2.DIST_L2, 3)
    inset_px = np.minimum(inset_px, max(inset_px.shape))  # without an edge it is all but infinite
    return inset_px * depth / np.float32(cloud.camera.fx)


def bulky_surfaces(
    cloud: Cloud,
    is_allowed: NDArray[np.bool_],
    inset_m: NDArray[np.float32],
    bulk_radius_m: float,
    huge_core_m2: float,
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """[h, w] what a disc of `bulk_radius_m` fits into between depth edges (a morphological
    opening), and what of it is part of something larger than any person."""
    pixel_m = cloud.depth_m / np.float32(cloud.camera.fx)
    is_core = inset_m > bulk_radius_m
    is_bulky = np.isfinite(surface_distance(cloud, is_allowed, _at(is_core), bulk_radius_m))
    _, numbers = cv2.connectedComponents(is_core.astype(np.uint8), connectivity=4)
    labels = np.asarray(numbers, np.int32)
    area_m2 = np.bincount(labels.ravel(), (pixel_m * pixel_m).ravel())
    area_m2[0] = 0.0
    is_huge_core = (area_m2 > huge_core_m2)[labels]
    if not is_huge_core.any():
        return is_bulky, np.zeros_like(is_bulky)
    return is_bulky, np.isfinite(
        surface_distance(cloud, is_allowed, _at(is_huge_core), bulk_radius_m)
    )


def surface_distance(
    cloud: Cloud,
    is_allowed: NDArray[np.bool_],
    start_m: NDArray[np.float32],
    limit_m: float,
) -> NDArray[np.float32]:
    """[h, w] length of the shortest way over the allowed surface from where `start_m` [h, w] is
    finite, added to it; infinity where there is none up to `limit_m`."""
    distance_m = np.where(is_allowed & (start_m <= limit_m), start_m, np.float32(np.inf))
    geodesic_distance(
        cloud.depth_m,
        is_allowed,
        cloud.camera.fx,
        JUMP_M,
        JUMP_PER_SQUARE_M,
        limit_m,
        np.empty(distance_m.size, np.int32),
        np.zeros(distance_m.shape, np.bool_),
        distance_m,
    )
    return distance_m


def _at(is_seed: NDArray[np.bool_]) -> NDArray[np.float32]:
    """[h, w] 0 at the seeds, infinity elsewhere."""
    return np.where(is_seed, np.float32(0.0), np.float32(np.inf))
