"""Track a known head into the next frame, by a template of its depth."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import NEAREST_READING_M, Cloud
from topview.detect.heads import (
    CENTER_BEHIND_SURFACE_M,
    HEAD_HALF_HEIGHT_M,
    TILT_PENALTY,
    HeadCandidate,
    head_confidences,
    median_near,
    tilted_ups,
)
from topview.kernels.heads import lowest, relief_about

Vector = NDArray[np.float64]
Patch = NDArray[np.float32]

# All ours. The template shows the head, its outline and the neck.
PATCH_RADIUS_M: Final = 0.17
# Depths relative to the head's centre are clipped at this.
RELIEF_M: Final = 0.25
# Mean square difference of two templates of one head, a frame apart; a greater one than the second
# is another object's.
LIKE_M2: Final = 0.006
UNLIKE_M2: Final = 0.025
# Standard deviation of a head's motion from the predicted one: in any frame, and added for each
# second since the frame before; and how many of them are searched.
MOTION_M: Final = 0.06
MOTION_M_PER_S: Final = 1.2
SEARCH_SIGMAS: Final = 2.0
# The places of least cost whose likeness to a head is computed.
CANDIDATES: Final = 32
# Of these so many are compared with a head first, those that cost least.
AT_FIRST: Final = 6
# Greatest change of depth from the predicted one, in any frame; each second adds `MOTION_M_PER_S`.
DEPTH_CHANGE_M: Final = 0.11
# A known head may lean further than a new one.
TRACKED_TILTS_RAD: Final = np.array([-1.2, -0.6, 0.0, 0.6, 1.2])
# It may hang down, if no upright place has this confidence; the penalty of a tilt is at most this.
HANGING_RAD: Final = np.array([-2.4, -1.8, 1.8, 2.4, np.pi])
UPRIGHT_CONFIDENCE: Final = 0.5
MOST_PENALTY: Final = 0.3
# How much a tilted head counts.
TRACKED_UPRIGHT, HANGING = (
    1.0 - np.minimum(TILT_PENALTY * np.abs(tilts_rad), MOST_PENALTY)
    for tilts_rad in (TRACKED_TILTS_RAD, HANGING_RAD)
)
# Weight in the cost, where motion and template count 1 at their scales, of the confidence that it
# is a head.
CONFIDENCE_WEIGHT: Final = 3.0
# Less confident places are no head.
LEAST_CONFIDENCE: Final = 0.15
# Fewer points do not tell the depth of a surface.
LEAST_SURFACE_COUNT: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class HeadTemplate:
    """The depth image of a head.

    Attributes:
        relief_m: [n, n] depths relative to its centre, clipped at `RELIEF_M`.
    """

    relief_m: Patch

    @classmethod
    def of(cls, cloud: Cloud, center_camera: Vector) -> HeadTemplate:
        radius_px = _radius_px(cloud, center_camera, PATCH_RADIUS_M)
        return cls(_relief(cloud, center_camera, radius_px))


def _radius_px(cloud: Cloud, center_camera: Vector, radius_m: float) -> int:
    return ceil(radius_m * cloud.camera.fx / max(float(center_camera[2]), NEAREST_READING_M))


def _relief(cloud: Cloud, center_camera: Vector, radius_px: int) -> Patch:
    side = 2 * radius_px + 1
    relief_m = np.empty((side, side), np.float32)
    row, column = _nearest_pixel(cloud, center_camera)
    relief_about(cloud.depth_m, row, column, float(center_camera[2]), RELIEF_M, relief_m)
    return relief_m


def _nearest_pixel(cloud: Cloud, center_camera: Vector) -> tuple[int, int]:
    row, column, _ = cloud.pixel_at(center_camera)
    return row, column


def track_head(
    cloud: Cloud,
    template: HeadTemplate,
    predicted_camera: Vector,
    up_camera: Vector,
    elapsed_s: float,
) -> HeadCandidate | None:
    """Find a head near `predicted_camera` [3], `elapsed_s` seconds after its template was taken.

    The place of least cost is taken: by the template, the motion and the confidence that it is a
    head. So it also finds heads that do not stand out from the surface behind or above
    them (bent forward, an arm over the head). None where nothing is like the template.
    """
    radius_px = _radius_px(cloud, predicted_camera, PATCH_RADIUS_M)
    motion_m = MOTION_M + MOTION_M_PER_S * elapsed_s
    search_px = _radius_px(cloud, predicted_camera, SEARCH_SIGMAS * motion_m)
    window = _relief(cloud, predicted_camera, radius_px + search_px)
    side = 2 * radius_px + 1
    patch = template.relief_m
    if patch.shape != (side, side):
        patch = cv2.resize(patch, (side, side), interpolation=cv2.INTER_NEAREST)
    unlike = cv2.matchTemplate(window, patch, cv2.TM_SQDIFF) / side**2
    pixel_m = cloud.pixel_m(predicted_camera)
    offset_m = (np.arange(2 * search_px + 1) - search_px) * pixel_m
    moved_m2 = offset_m[:, None] ** 2 + offset_m**2
    cost = unlike / LIKE_M2 + moved_m2 / motion_m**2
    row, column = _nearest_pixel(cloud, predicted_camera)
    best = lowest(cost, CANDIDATES)
    down, across = best // cost.shape[1], best % cost.shape[1]
    camera = cloud.camera
    rows, columns = row + down - search_px, column + across - search_px
    height, width = cloud.depth_m.shape
    rows_inside = np.minimum(np.maximum(rows, 0), height - 1)
    depth_m = cloud.depth_m[rows_inside, np.minimum(np.maximum(columns, 0), width - 1)]
    depth_m = depth_m.astype(np.float64) + CENTER_BEHIND_SURFACE_M
    depth_change_m = DEPTH_CHANGE_M + MOTION_M_PER_S * elapsed_s
    is_off = np.abs(depth_m - predicted_camera[2]) > depth_change_m
    depth_m[is_off] = predicted_camera[2]
    centers = np.empty((len(best), 3))
    centers[:, 0] = (columns - camera.cx) / camera.fx * depth_m
    centers[:, 1] = (rows - camera.cy) / camera.fy * depth_m
    centers[:, 2] = depth_m
    deeper_m = depth_m - float(predicted_camera[2])
    chosen, confidence = _most_likely(
        cloud, centers, cost.ravel()[best] + (deeper_m / motion_m) ** 2, up_camera
    )
    if confidence < LEAST_CONFIDENCE or unlike.ravel()[best[chosen]] > UNLIKE_M2:
        return None
    center = _settle(cloud, centers[chosen], up_camera)
    return None if center is None else HeadCandidate(center, confidence)


def _most_likely(
    cloud: Cloud, centers_camera: Vector, costs: NDArray[np.float64], up_camera: Vector
) -> tuple[int, float]:
    """Which of [N, 3] places of [N] costs is the head's, and the confidence that it is one. Places
    that cost too much to win by the greatest confidence are not compared with a head."""
    order = np.argsort(costs, kind="stable")
    confidence, total = np.zeros(len(costs)), costs.copy()
    for tilts_rad, upright in ((TRACKED_TILTS_RAD, TRACKED_UPRIGHT), (HANGING_RAD, HANGING)):
        ups, most = tilted_ups(up_camera, tilts_rad), CONFIDENCE_WEIGHT * float(upright.max())
        for some in (order[:AT_FIRST], order[AT_FIRST:]):
            asked = some[costs[some] - most < total.min()]
            if len(asked):
                found = head_confidences(cloud, centers_camera[asked], ups, upright)
                confidence[asked] = np.maximum(confidence[asked], found)
                total[asked] = costs[asked] - CONFIDENCE_WEIGHT * confidence[asked]
        if confidence.max() >= UPRIGHT_CONFIDENCE:
            break
    chosen = int(np.argmin(total))
    return chosen, float(confidence[chosen])


def _settle(cloud: Cloud, center_camera: Vector, up_camera: Vector) -> Vector | None:
    """[3] in the same direction, at the depth of the surface there."""
    median, count = median_near(cloud, center_camera, up_camera, HEAD_HALF_HEIGHT_M)
    if count < LEAST_SURFACE_COUNT:
        return None
    depth_m = float(median[2]) + CENTER_BEHIND_SURFACE_M
    return center_camera * (depth_m / center_camera[2])
