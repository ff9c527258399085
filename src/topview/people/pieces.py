"""Limbs that the depth image cuts off from their body: a hand stretched out at the camera hides
its own forearm."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.people.scene import Scene

Distance = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PieceSettings:
    """Which loose pieces may be limbs; ours.

    Attributes:
        area_m2: a fist shows 0.008 m^2, and a forearm with its hand 0.06 m^2.
        gap_m: how far it is before the body beside it in the picture; a forearm with its hand is
            0.45 m long.
        reach: from the head's centre, in statures, to the toes of a stretched leg.
    """

    area_m2: tuple[float, float] = (0.002, 0.07)
    gap_m: float = 0.45
    reach: float = 1.0


def with_pieces(
    scene: Scene,
    head_camera: NDArray[np.float64],
    height_m: float,
    body: Distance,
    is_somebodys: NDArray[np.bool_],
    settings: PieceSettings,
) -> Distance:
    """A body [h, w] and the loose pieces before it that touch it in the picture and are small and
    near enough; they are as far from the head as the straight line.

    `is_somebodys` [h, w] is everybody's body: no pieces.
    """
    is_body = np.isfinite(body)
    is_piece = scene.is_free_standing & ~is_somebodys & ~scene.is_bulky
    beside = cv2.dilate(is_body.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    if not (is_piece & beside).any():
        return body
    count, numbers = cv2.connectedComponents(is_piece.astype(np.uint8), connectivity=8)
    labels = np.asarray(numbers, np.int32)
    labels[~is_piece] = 0
    depth = scene.cloud.depth_m
    area_m2 = np.bincount(labels.ravel(), (depth**2).ravel(), count) / scene.cloud.camera.fx**2
    is_small = (settings.area_m2[0] < area_m2) & (area_m2 < settings.area_m2[1])
    is_small[0] = False

    # The body's mean depth around each pixel.
    body_depth = np.where(is_body, depth, np.float32(0.0))
    around = cv2.blur(body_depth, (3, 3)) / np.maximum(
        cv2.blur(is_body.astype(np.float32), (3, 3)), 1e-6
    )
    is_before = (depth < around) & (depth > around - settings.gap_m)
    touches = np.bincount(labels[is_piece & beside & is_before], minlength=count) > 0

    offset = scene.cloud.points_camera - head_camera.astype(np.float32)
    from_head_m = np.sqrt(np.einsum("ijk,ijk->ij", offset, offset))
    too_far = np.bincount(labels[from_head_m > settings.reach * height_m], minlength=count) > 0
    is_limb = (is_small & touches & ~too_far)[labels]
    return np.where(is_limb, from_head_m, body)
