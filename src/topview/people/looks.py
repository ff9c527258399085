"""What people look like: their clothes tell who is who after two met, the colours of a head where
it is (ours; the thesis knows users by place, and skin alone)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.detect.head_colors import HeadColors
from topview.people.height import sunk_m
from topview.people.identity import KnownUser, distance_m, nearest_m
from topview.people.roll import Roll
from topview.people.scene import Scene

Vector = NDArray[np.float64]
Colors = NDArray[np.float32]

# All ours. The clothes that are looked at: so far below the head's centre, and so far aside; in a
# window that is as wide.
CHEST_BELOW_M, CHEST_ASIDE_M, WINDOW_M = (0.2, 0.65), 0.16, 0.4
# Less of them tells nothing.
LEAST_M2 = 0.02
# Lightness and chromaticities (red and green of all) in so many steps each, and their ranges.
STEPS, RANGES = (6, 16, 16), (0.0, 256.0, 0.0, 1.0, 0.0, 1.0)
# Whose heads are this near to each other may be taken for one another; until they are so far apart
# again. They are compared where they are no nearer than the third, and their clothes are learnt
# while nobody is nearer than the last.
TOGETHER_M, PARTED_M, JUDGED_M, APART_M = 0.5, 1.4, 0.3, 0.7
# New looks go into the remembered ones by this share, so many seconds one after the other.
RATE, EVERY_S = 0.3, 1 / 6
# By so much two must be less like themselves than like each other, to have been exchanged.
CLEARLY = 0.4
# From this confidence on, and so near to where the stature puts it, a head is taken for what it is.
SURE_HEAD, NEAR_STATURE_M = 0.75, 0.12


def colors_under(
    scene: Scene, head_camera: Vector, others_camera: Sequence[Vector]
) -> Colors | None:
    """Histogram, of sum 1, of the colours of the clothes under a head [3]; None where too few of
    them are seen. What is nearer to `others_camera`, [3] each, is not looked at."""
    cloud = scene.cloud
    every = cloud.color
    if every is None:
        return None
    window = _window(scene, head_camera)
    if window is None:
        return None
    aside_m = scene.aside_of(head_camera, window)
    below_m = scene.height_of(head_camera) - scene.heights_m[window]
    is_chest = (aside_m < CHEST_ASIDE_M) & (cloud.depth_m[window] > 0.0)
    is_chest &= (below_m > CHEST_BELOW_M[0]) & (below_m < CHEST_BELOW_M[1])
    for other in others_camera:
        is_chest &= aside_m <= scene.aside_of(other, window)
    if np.count_nonzero(is_chest) * cloud.pixel_m(head_camera) ** 2 < LEAST_M2:
        return None
    return _histogram(every[window][is_chest].astype(np.float32))


def _histogram(rgb: NDArray[np.float32]) -> Colors:
    """Of [N, 3] colours."""
    total = rgb.sum(1) + 1.0
    channels = [total / 3.0, rgb[:, 0] / total, rgb[:, 1] / total]
    counts = cv2.calcHist(
        [np.ascontiguousarray(channel[:, None]) for channel in channels],
        [0, 1, 2], None, list(STEPS), list(RANGES),
    )  # fmt: skip
    return np.asarray(counts / max(float(counts.sum()), 1.0), np.float32)


def _window(scene: Scene, head_camera: Vector) -> tuple[slice, slice] | None:
    """The pixels among which the clothes under a head are, None if they are out of view."""
    camera, (x, y, z) = scene.cloud.camera, head_camera.tolist()
    if z <= 0.1:
        return None
    column, row = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    aside_px, down_px = WINDOW_M * camera.fx / z, CHEST_BELOW_M[1] * camera.fy / z
    top, bottom = max(int(row), 0), min(int(row + down_px) + 2, camera.height)
    left, right = max(int(column - aside_px), 0), min(int(column + aside_px) + 2, camera.width)
    return np.s_[top:bottom, left:right] if top < bottom and left < right else None


def unlikeness(one: Colors, other: Colors) -> float:
    """0 of like colours, 1 of such that have nothing in common (Bhattacharyya's coefficient)."""
    return 1.0 - float(np.sqrt(one * other).sum())


def tell_apart(
    scene: Scene, known: Sequence[KnownUser], sees_color: bool, is_time: bool = True
) -> None:
    """Remember what everybody wears, if it is time to; who met, and wear each other's clothes now,
    are exchanged."""
    users = [user for user in known if not user.is_suspect]
    _note_company(users)
    if not sees_color or not (is_time or any(user.company for user in users)):
        return
    worn = {
        user: colors_under(
            scene, user.head_camera, [other.head_camera for other in users if other is not user]
        )
        for user in users
        if user.seen_s == scene.time_s
    }
    for one, other in combinations(worn, 2):
        if other in one.company and distance_m(one, other) > JUDGED_M:
            _judge(one, worn[one], other, worn[other])
    if is_time:
        _learn_clothes(users, worn)


def _learn_clothes(users: Sequence[KnownUser], worn: Mapping[KnownUser, Colors | None]) -> None:
    for user, colors in worn.items():
        if colors is not None and not user.company and nearest_m(user, users) > APART_M:
            before = colors if user.colors is None else user.colors
            user.colors = np.asarray(before + RATE * (colors - before), np.float32)


def learn_heads(roll: Roll, scene: Scene, is_time: bool = True) -> None:
    """Remember the colours of heads that are seen for sure, and not bent, if it is time to; of
    those who may be furniture, as they were at first."""
    sure = [user for user in roll.known if not user.is_suspect]
    for user, body in roll:
        if _shows_head(user, scene, is_time) and nearest_m(user, sure) > APART_M:
            now = HeadColors.of(scene.cloud, user.head_camera, body)
            if now is not None:
                before = user.head_colors
                user.head_colors = now if before is None else before.learn(now)


def _shows_head(user: KnownUser, scene: Scene, is_time: bool) -> bool:
    """Whether it is time to look at a head, and it is what it seems to be."""
    is_new = user.head_colors is None
    is_wanted = is_new or (is_time and not user.is_suspect)
    if not is_wanted or user.confidence_now < SURE_HEAD:
        return False
    below_m = sunk_m(scene, user.head_camera, user.height)
    return below_m is None or abs(below_m) < NEAR_STATURE_M


def colors_of_head(roll: Roll, scene: Scene, user: KnownUser) -> HeadColors | None:
    """What colours a user's head has, and neither the own body nor people near by; None while that
    is not known."""
    if user.head_colors is None or scene.cloud.frame.color is None:
        return None
    near = [
        other.head_colors
        for other in roll.known
        if other is not user and other.head_colors is not None and distance_m(user, other) < APART_M
    ]
    return user.head_colors.against(near)


def _note_company(users: Sequence[KnownUser]) -> None:
    """Who may be taken for one another: those who are close together while one is not seen."""
    for user in users:
        user.company &= set(users)
    for one, other in combinations(users, 2):
        apart_m = distance_m(one, other)
        if apart_m < TOGETHER_M and 0.0 in (one.confidence_now, other.confidence_now):
            one.company.add(other)
            other.company.add(one)
        elif apart_m > PARTED_M:
            _part(one, other)


def _part(one: KnownUser, other: KnownUser) -> None:
    one.company.discard(other)
    other.company.discard(one)


def _judge(one: KnownUser, ones: Colors | None, other: KnownUser, others: Colors | None) -> None:
    if ones is None or others is None or one.colors is None or other.colors is None:
        return
    as_are = unlikeness(one.colors, ones) + unlikeness(other.colors, others)
    exchanged = unlikeness(one.colors, others) + unlikeness(other.colors, ones)
    if as_are - exchanged > CLEARLY:
        one.exchange(other)
    if abs(as_are - exchanged) > CLEARLY:
        _part(one, other)
