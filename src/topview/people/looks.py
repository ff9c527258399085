"""Who is who after two people met: clothes tell, and statures."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.people.identity import KnownUser
from topview.people.scene import Scene

Vector = NDArray[np.float64]
Colors = NDArray[np.float32]

# All ours. The clothes that are looked at: so far below the head's centre, and so far aside.
CHEST_BELOW_M, CHEST_ASIDE_M = (0.2, 0.65), 0.16
# Less of them tells nothing.
LEAST_M2 = 0.02
# Lightness and chromaticities in so many steps each.
STEPS = (6, 10, 10)
# Whose heads come this near to each other may be taken for one another; whose are further apart
# than the second are looked at by themselves.
TOGETHER_M, APART_M = 0.5, 0.7
# New looks go into the remembered ones by this share.
RATE = 0.1
# Statures that differ by this much tell as much as clothes that have no colour in common.
STATURE_M = 0.2
# By so much two must look more like each other than like themselves, to have been exchanged.
CLEARLY = 0.4


def colors_under(
    scene: Scene, head_camera: Vector, others_camera: Sequence[Vector]
) -> Colors | None:
    """Histogram, of sum 1, of the colours of the clothes under a head [3]; None where too few of
    them are seen. What is nearer to `others_camera`, [3] each, is not looked at."""
    cloud = scene.cloud
    if cloud.frame.color is None:
        return None
    camera, z = cloud.camera, float(head_camera[2])
    if z <= 0.1:
        return None
    row, column = (
        focal * float(head_camera[axis]) / z + center
        for focal, axis, center in ((camera.fy, 1, camera.cy), (camera.fx, 0, camera.cx))
    )
    down_px, aside_px = (reach_m * camera.fy / z for reach_m in (CHEST_BELOW_M[1], 0.4))
    top, bottom = max(int(row), 0), min(int(row + down_px) + 2, camera.height)
    left, right = max(int(column - aside_px), 0), min(int(column + aside_px) + 2, camera.width)
    if bottom <= top or right <= left:
        return None
    window = np.s_[top:bottom, left:right]
    aside_m = _aside_m(scene, window, head_camera)
    below_m = scene.height_of(head_camera) - scene.heights_m[window]
    is_chest = (aside_m < CHEST_ASIDE_M) & (below_m > CHEST_BELOW_M[0])
    is_chest &= (below_m < CHEST_BELOW_M[1]) & (cloud.depth_m[window] > 0.0)
    for other in others_camera:
        is_chest &= aside_m <= _aside_m(scene, window, other)
    area_m2 = np.count_nonzero(is_chest) * (z / camera.fx) * (z / camera.fy)
    if area_m2 < LEAST_M2:
        return None
    stride = cloud.stride
    rgb = cloud.frame.color[::stride, ::stride][window][is_chest].astype(np.float32)
    total = rgb.sum(1) + 1.0
    channels = np.stack([total / 3.0, 256.0 * rgb[:, 0] / total, 256.0 * rgb[:, 1] / total])
    counts = cv2.calcHist(
        [np.ascontiguousarray(channel[:, None]) for channel in channels],
        [0, 1, 2], None, list(STEPS), [0, 256, 25, 153, 25, 153],
    )  # fmt: skip
    return np.asarray(counts / max(float(counts.sum()), 1.0), np.float32)


def _aside_m(scene: Scene, window: tuple[slice, slice], head_camera: Vector) -> NDArray[np.float32]:
    right, forward = scene.overview_of(head_camera)
    overview_m = scene.overview_m[window]
    return np.hypot(overview_m[..., 0] - right, overview_m[..., 1] - forward)


def unlikeness(one: Colors | None, other: Colors | None) -> float:
    """0 of like colours, 1 of such that have nothing in common, 0 where nobody knows."""
    if one is None or other is None:
        return 0.0
    return 1.0 - float(np.sqrt(one * other).sum())


def tell_apart(scene: Scene, known: Sequence[KnownUser], time_s: float, sees_color: bool) -> None:
    """Remember what everybody looks like; who met and look like each other now are exchanged."""
    users = [user for user in known if not user.is_suspect]
    for one, other in combinations(users, 2):
        near_m = float(np.linalg.norm(one.head_camera - other.head_camera))
        if near_m < TOGETHER_M and 0.0 in (one.confidence_now, other.confidence_now):
            one.company.add(other.id)
            other.company.add(one.id)
        elif near_m > 2 * APART_M:
            one.company.discard(other.id)
            other.company.discard(one.id)
    heads = [user.head_camera for user in users]
    looks: dict[int, Colors | None] = {}
    for user in users:
        if user.seen_s != time_s:
            continue
        others = [head for head in heads if head is not user.head_camera]
        looks[user.id] = colors_under(scene, user.head_camera, others) if sees_color else None
        nearest_m = min(
            (float(np.linalg.norm(user.head_camera - head)) for head in others), default=9.0
        )
        look = looks[user.id]
        if nearest_m > APART_M and not user.company and look is not None:
            before = look if user.colors is None else user.colors
            user.colors = before + np.float32(RATE) * (look - before)
    for one, other in combinations(users, 2):
        if other.id not in one.company or one.id not in looks or other.id not in looks:
            continue
        if (
            any(x is None for x in (one.colors, other.colors, looks[one.id], looks[other.id]))
            or np.linalg.norm(one.head_camera - other.head_camera) < 0.3
        ):
            continue
        keep = _cost(one, looks[one.id], other, looks[other.id], scene, False)
        swap = _cost(one, looks[one.id], other, looks[other.id], scene, True)
        import os

        if os.environ.get("DBG"):
            print(
                "  PAIR",
                round(time_s * 30),
                one.id,
                other.id,
                "keep %.2f swap %.2f" % (keep, swap),
                "near %.2f" % np.linalg.norm(one.head_camera - other.head_camera),
                "h %.2f %.2f" % (one.height.height_m, other.height.height_m),
            )
        if keep - swap > CLEARLY:
            one.exchange(other)
        if abs(keep - swap) > CLEARLY:
            one.company.discard(other.id)
            other.company.discard(one.id)


def _cost(
    one: KnownUser,
    look_one: Colors | None,
    other: KnownUser,
    look_other: Colors | None,
    scene: Scene,
    is_swapped: bool,
) -> float:
    first, second = (other, one) if is_swapped else (one, other)
    cost = unlikeness(first.colors, look_one) + unlikeness(second.colors, look_other)
    for user, place in ((first, one), (second, other)):
        if user.height.is_measured:
            top_m = scene.height_of(place.head_camera) + 0.11
            cost += abs(user.height.height_m - top_m) / STATURE_M * 0.0
    return cost
