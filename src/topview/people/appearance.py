"""What people look like: the colours of their clothes (ours; the thesis knows people by place, and
by skin alone)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import dist
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.kernels.colors import count_clothes
from topview.people.track import Track
from topview.room.scene import Scene

Vector = NDArray[np.float64]
Colors = NDArray[np.float32]

# All ours. The clothes that are looked at: so far below the head's centre, and so far aside; in a
# window that is as wide.
CHEST_BELOW_M, CHEST_ASIDE_M, WINDOW_M = (0.2, 0.65), 0.16, 0.4
# Less of them tells nothing.
LEAST_M2: Final = 0.02
# Lightness and chromaticities (red and green of all) in so many steps each.
STEPS: Final = (6, 16, 16)
# Whose heads are this near to each other may be taken for one another, until they are so far apart
# again; they are compared where they are no nearer than the third.
TOGETHER_M, PARTED_M, JUDGED_M = 0.5, 1.4, 0.3
# Appearance is learnt while nobody is nearer.
APART_M: Final = 0.7
# A new look goes into the remembered one by this share, so many seconds one after the other.
RATE, EVERY_S = 0.3, 1 / 6
# By so much two must be less like themselves than like each other, to have been exchanged.
CLEARLY: Final = 0.4


def clothes_under(
    scene: Scene, head_camera: Vector, others_camera: Sequence[Vector]
) -> Colors | None:
    """Histogram, of sum 1, of the colours of the clothes under a head [3]; None where too few of
    them are seen. What is nearer to `others_camera`, [3] each, is not looked at."""
    cloud = scene.cloud
    color, box = cloud.frame.color, _window(scene, head_camera)
    if color is None or box is None:
        return None
    counts = np.zeros(STEPS, np.float32)
    pixels = count_clothes(
        color, cloud.stride, cloud.depth_m, scene.plan_m, scene.heights_m, box,
        np.array([scene.overview_of(head) for head in (head_camera, *others_camera)]),
        scene.height_of(head_camera),
        CHEST_BELOW_M, CHEST_ASIDE_M, counts,
    )  # fmt: skip
    if pixels * cloud.pixel_m(head_camera) ** 2 < LEAST_M2:
        return None
    return np.asarray(counts / max(pixels, 1), np.float32)


def _window(scene: Scene, head_camera: Vector) -> tuple[int, int, int, int] | None:
    """Left, top, right and bottom (both outside) of the pixels among which the clothes under a head
    are, None if they are out of view."""
    camera, (x, y, z) = scene.cloud.camera, head_camera.tolist()
    if z <= 0.1:
        return None
    column, row = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    aside_px, down_px = WINDOW_M * camera.fx / z, CHEST_BELOW_M[1] * camera.fy / z
    top, bottom = max(int(row), 0), min(int(row + down_px) + 2, camera.height)
    left, right = max(int(column - aside_px), 0), min(int(column + aside_px) + 2, camera.width)
    return (left, top, right, bottom) if top < bottom and left < right else None


def unlikeness(one: Colors, other: Colors) -> float:
    """0 of like colours, 1 of such that have nothing in common (Bhattacharyya's coefficient)."""
    return 1.0 - float(np.sqrt(one * other).sum())


def with_appearance(tracks: Sequence[Track], scene: Scene, is_time: bool) -> list[Track]:
    """The tracks, with what they look like if it is time to learn that; those who met, and wear
    each other's clothes now, exchange their identities."""
    if scene.cloud.frame.color is None:
        return list(tracks)
    people = [track for track in tracks if track.id]
    known = {track.key: track for track in _with_company(people)}
    if is_time or any(track.company for track in known.values()):
        worn = {
            key: clothes_under(
                scene,
                track.place_camera,
                [other.place_camera for other in known.values() if other.key != key],
            )
            for key, track in known.items()
            if track.is_seen
        }
        for one, other in combinations(worn, 2):
            _resolve(known, one, other, worn)
        if is_time:
            _learn_clothes(known, worn)
    return [known.get(track.key, track) for track in tracks]


def apart_m(one: Track, other: Track) -> float:
    """Between two heads."""
    return dist(one.place_camera.tolist(), other.place_camera.tolist())


def nearest_m(track: Track, others: Sequence[Track]) -> float:
    """To the nearest other head."""
    apart = (apart_m(track, other) for other in others if other.key != track.key)
    return min(apart, default=np.inf)


def _learn_clothes(known: dict[int, Track], worn: Mapping[int, Colors | None]) -> None:
    people = list(known.values())
    for key, colors in worn.items():
        track = known[key]
        if colors is not None and not track.company and nearest_m(track, people) > APART_M:
            before = colors if track.clothes is None else track.clothes
            clothes = np.asarray(before + RATE * (colors - before), np.float32)
            known[key] = replace(track, clothes=clothes)


def _with_company(people: Sequence[Track]) -> list[Track]:
    """Who may be taken for one another: those who are close together while one is not seen."""
    company = {track.key: set(track.company) & {o.key for o in people} for track in people}
    for one, other in combinations(people, 2):
        away_m = apart_m(one, other)
        if away_m < TOGETHER_M and not (one.is_seen and other.is_seen):
            company[one.key].add(other.key)
            company[other.key].add(one.key)
        elif away_m > PARTED_M:
            company[one.key].discard(other.key)
            company[other.key].discard(one.key)
    return [replace(track, company=frozenset(company[track.key])) for track in people]


def _resolve(
    known: dict[int, Track], one_key: int, other_key: int, worn: Mapping[int, Colors | None]
) -> None:
    """Exchange two who wear each other's clothes; part them where the clothes tell."""
    one, other = known[one_key], known[other_key]
    ones, others = worn[one_key], worn[other_key]
    if other_key not in one.company or apart_m(one, other) < JUDGED_M:
        return
    if ones is None or others is None or one.clothes is None or other.clothes is None:
        return
    as_are = unlikeness(one.clothes, ones) + unlikeness(other.clothes, others)
    exchanged = unlikeness(one.clothes, others) + unlikeness(other.clothes, ones)
    if abs(as_are - exchanged) < CLEARLY:
        return
    one = replace(one, company=one.company - {other_key})
    other = replace(other, company=other.company - {one_key})
    if as_are > exchanged:
        one, other = one.as_person(other), other.as_person(one)
    known[one_key], known[other_key] = one, other
