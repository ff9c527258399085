"""Where the head is of somebody whose head is not seen, by what is seen of the body."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.people.bodies import LARGEST_M2, SHOWN_M2, area_m2, own_mask, split
from topview.people.height import sunk_m
from topview.people.places import Places
from topview.people.settings import PeopleSettings
from topview.people.told import Told
from topview.people.track import Track
from topview.room.scene import Scene

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]

# All ours. The trunk is between these shares of the stature; so much of it, in columns as high,
# tells where the head is, but for so much.
TRUNK, TRUNK_M2, COLUMN_M, TRUNK_SIGMA_M = (0.5, 0.85), 0.03, 0.3, 0.12
# Where so much of the body is seen the joint network knows the head's place; else it is so exact.
TOLD_M2, FAINT_SIGMA_M = 0.08, 0.17
# Where nothing hides a head that is not made out, for so long, nobody is there.
BENT_S: Final = 3.0
# Who comes to be hidden seems to slide down by so much before the head is missed.
SLID_M: Final = 0.35


def over_body(
    scene: Scene,
    track: Track,
    seen: Sequence[Track],
    told: Told,
    told_camera: Vector | None,
    settings: PeopleSettings,
    elapsed_s: float,
) -> Track:
    """A track whose head is not seen, at the place that its body tells: by the head [3] that
    the joint network told, or else by its trunk. Its own is what is nobody's whose head is seen."""
    people = [track, *(other for other in seen if other.id)]
    bodies_m = np.array([person.body_m for person in people])
    bodies_m[:, ~own_mask(scene, track)] = np.inf
    split(scene, people, bodies_m, told, dataclasses.replace(settings.segmentation, share_m=0.0))
    body = bodies_m[0]
    shown_m2 = area_m2(scene, replace(track, body_m=body))
    is_shown = SHOWN_M2 < shown_m2 < LARGEST_M2
    track = replace(track, body_m2=shown_m2 if is_shown else 0.0)
    places = track.places
    if places is None or not is_shown:
        return track
    height_m = _hidden_height_m(scene, track, places)
    if told_camera is not None:
        told_m, is_hidden = scene.height_of(told_camera), scene.is_hidden_at(told_camera)
        # Of whom less and less is seen the network believes that the head sinks; it may rise.
        may_sink = not (track.evidence.was_upright and is_hidden)
        height_m = told_m if may_sink else max(told_m, height_m)
        if shown_m2 > TOLD_M2:
            return track.told_at(scene, scene.point_at(scene.overview_of(told_camera), height_m))
    else:
        told_camera = told.head_of(track, seen, elapsed_s, roughly=True)
    place, sigma_m = _trunk(scene, track, body), TRUNK_SIGMA_M
    if told_camera is not None:
        place, sigma_m = scene.overview_of(told_camera), FAINT_SIGMA_M
    if place is None:
        return track
    return track.placed(scene, places.drawn_to(place, height_m, sigma_m, elapsed_s))


def _hidden_height_m(scene: Scene, track: Track, places: Places) -> float:
    """Of a head that is not seen: that of before; where something hides it, it has not slid down
    from where the stature puts it."""
    below_m = sunk_m(scene, track.place_camera, track.height) or 0.0
    has_slid = 0.0 < below_m < SLID_M and scene.is_hidden_at(track.place_camera)
    return places.height_m + (below_m if has_slid else 0.0)


def _trunk(scene: Scene, track: Track, body: Distance) -> Vector | None:
    """[2] the middle of what is seen of the trunk, from above; None if that is too little, or not
    what is below the head: that has not been seen for long, and nothing hides it."""
    is_bent = track.unseen_s(scene.time_s) < BENT_S
    if track.places is None or track.places.outside > 0.5:
        return None
    if not is_bent and scene.covered_share(track.place_camera) <= 0.5:
        return None
    low_m, high_m = (share * track.height.height_m for share in TRUNK)
    is_trunk = (body < np.inf) & (scene.heights_m > low_m) & (scene.heights_m < high_m)
    pixel_m = scene.cloud.pixel_m(track.place_camera)
    is_trunk &= np.count_nonzero(is_trunk, axis=0) * pixel_m > COLUMN_M
    if np.count_nonzero(is_trunk) * pixel_m**2 < TRUNK_M2:
        return None
    return np.median(scene.overview_m[is_trunk], axis=0).astype(np.float64)
