"""Where the head is of somebody whose head is not seen, by what is seen of the body."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.people.bodies import LARGEST_M2, SHOWN_M2, area_m2, own_mask, split
from topview.people.settings import PeopleSettings
from topview.people.told import Told
from topview.people.track import Track
from topview.room.scene import Scene

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]

# All ours. The trunk is between these shares of the stature; so much of it, in columns as high,
# tells where the head is, but for so much.
TRUNK, TRUNK_M2, COLUMN_M, TRUNK_SIGMA_M = (0.5, 0.85), 0.03, 0.3, 0.12
# Where so much of the body is seen the head that the joint network tells is followed as if seen.
TOLD_M2: Final = 0.08
# Where nothing hides a head that is not made out, for so long, nobody is there.
BENT_S: Final = 3.0


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
    the joint network told, or else by its trunk. Its own is what is nobody's whose head is seen,
    but for what the network takes for no person's."""
    if told.is_nobodys(track):
        nothing = np.full(scene.cloud.depth_m.shape, np.inf, np.float32)
        return replace(track, body_m=nothing, body_m2=0.0)
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
    sigma_m = told.sigma_of(track)
    if told_camera is not None and shown_m2 > TOLD_M2:
        return track.told_at(scene, told_camera, sigma_m, elapsed_s)
    if told_camera is None:
        told_camera = told.head_of(track, seen, elapsed_s, roughly=True)
    if told_camera is not None:
        place, height_m = scene.overview_of(told_camera), scene.height_of(told_camera)
    else:
        place, height_m, sigma_m = _trunk(scene, track, body), None, TRUNK_SIGMA_M
    if place is None:
        return track
    return track.placed(scene, places.drawn_to(place, height_m, sigma_m, elapsed_s))


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
