"""Which points are each track's body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.kernels.pieces import clusters_of
from topview.people.height import MAX_HEIGHT_M, PRIOR_HEIGHT_M
from topview.people.likelihood import EVIDENCE_MEMORY_S, Likelihood
from topview.people.pieces import Pieces
from topview.people.places import HEADS_APART_M
from topview.people.segmentation import (
    LIMB_STEP_M,
    Memory,
    SegmentationSettings,
    body_distance,
    split_by_overview,
    split_users,
)
from topview.people.settings import PeopleSettings
from topview.people.told import Told
from topview.people.track import Track
from topview.room.scene import Scene
from topview.room.surfaces import jump_of

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]

# All ours. A limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S: Final = 1.5
# What stands under a head that something hides is its body, where the place is as certain.
CERTAIN: Final = 0.8
# Of whom more than the first is seen is there, though the head is hidden. More than the second is
# not seen of anybody, be it a large person with the chair.
SHOWN_M2, LARGEST_M2 = 0.03, 1.2
# To the right, forward and up: arms stretched beyond the head make who lies longer by a quarter.
LONGEST_M: Final = np.array([1.25, 1.25, 1.0]) * MAX_HEIGHT_M
# What hangs together, and is all farther than the first from the box round somebody's joints, is
# not the body. A head goes no farther in one step than the second.
OFF_BODY_M, HEAD_STEP_M = 0.5, 0.25
# What stands right under a head is the person's, even if the rest hangs together with a wall.
UNDER_HEAD_M: Final = 0.26
# Who is out of the picture with this probability shows at its sides or top at most, each of which
# is so broad a share of it.
OUT, BORDER = 0.9, 0.05


def stature_m(track: Track) -> float:
    """The stature for which a body is searched: reach costs nothing."""
    return max(track.height.height_m, PRIOR_HEIGHT_M)


def body_of(
    scene: Scene,
    track: Track,
    settings: SegmentationSettings,
    last: Scene | None,
    told_camera: Vector | None = None,
    others_camera: Sequence[Vector] = (),
) -> Distance:
    """[h, w] how far each pixel of a track's body is from the head (`body_distance`); from the one
    [3] that the network tells where none is seen, if it is not one of others [3]."""
    if told_camera is not None and (track.is_seen or _is_near(told_camera, others_camera)):
        told_camera = None
    memory = None
    if track.body_m is not None and last is not None:
        faded_m = FADING_M_PER_S * max(scene.time_s - last.time_s, 0.0) * track.is_seen
        memory = Memory(track.body_m, last.cloud.depth_m, faded_m)
    is_sure = track.certainty > CERTAIN
    is_hidden = not track.is_seen and is_sure and scene.is_hidden_at(track.place_camera)
    body_m = body_distance(
        scene,
        track.place_camera if told_camera is None else told_camera,
        stature_m(track),
        settings,
        memory,
        from_head=track.is_seen or is_hidden or told_camera is not None,
        jump=jump_of(scene.cloud.camera.noise, LIMB_STEP_M) if track.by_body else None,
    )
    if track.places is not None and track.places.outside > OUT:
        _leave_out_inner(scene, body_m)
    return _right_under(scene, track, body_m) if track.is_narrow else body_m


def without_room(scene: Scene, track: Track, likelihood: Likelihood) -> Track:
    """A track that the network was just asked about. Where it knows no person, though the shape is
    one's, a curtain or a wall may hang together with the body: so for a while that is only what
    stands right under the head, and the network is asked anew; it may know no person there
    either."""
    own, is_recent = track.evidence, scene.time_s - track.narrowed_s < EVIDENCE_MEMORY_S
    is_known = own.network >= 0.0
    if track.is_narrow:
        return replace(track, is_narrow=is_known and is_recent)
    is_shaped = track.is_seen and likelihood.log_odds_of_shape(own.shape) > 0.0
    if is_known or is_recent or own.by_body or not is_shaped or track.body_m is None:
        return track
    narrow_m = _right_under(scene, track, track.body_m)
    narrow = replace(track, body_m=narrow_m, is_narrow=True, narrowed_s=scene.time_s)
    rest_m2 = area_m2(scene, track) - area_m2(scene, narrow)
    return narrow.asked_anew(scene.time_s) if rest_m2 > SHOWN_M2 else track


def _right_under(scene: Scene, track: Track, body_m: Distance) -> Distance:
    """[h, w] what of a track's body stands right under the head."""
    is_under = scene.is_under(track.place_camera, UNDER_HEAD_M)
    return np.where(is_under, body_m, np.float32(np.inf))


def _leave_out_inner(scene: Scene, body_m: Distance) -> None:
    """Take from the body, [h, w], of one who is out of the picture the pieces that are at none of
    its sides, nor at its top."""
    rows, columns = (max(round(BORDER * size), 1) for size in body_m.shape)
    is_border = np.ones(body_m.shape, np.bool_)
    is_border[rows:, columns:-columns] = False
    _keep_together(scene, body_m, is_border)


def _keep_together(scene: Scene, body_m: Distance, is_kept: Mask) -> None:
    """Leave to a body, [h, w], what is kept, [h, w], and what hangs together with that."""
    cloud, is_own = scene.cloud, body_m < np.inf
    labels = np.empty(body_m.shape, np.int32)
    clusters_of(scene.standing_px, ~is_own, cloud.depth_m, cloud.camera.fx, LIMB_STEP_M, labels)
    kept = np.unique(labels[is_own & is_kept])
    hangs_together = (labels > 0) & np.isin(labels, kept)
    body_m[is_own & ~is_kept & ~hangs_together] = np.inf


def _is_near(head_camera: Vector, others_camera: Sequence[Vector]) -> bool:
    """Whether a head at [3] and one of the others cannot both be heads."""
    return any(np.linalg.norm(head_camera - other) < HEADS_APART_M for other in others_camera)


def area_m2(scene: Scene, track: Track) -> float:
    """Of what is seen of a track's body."""
    if track.body_m is None:
        return 0.0
    return np.count_nonzero(track.body_m < np.inf) * scene.cloud.pixel_m(track.place_camera) ** 2


def is_short(scene: Scene, is_own: Mask) -> bool:
    """Whether what is seen is no higher than a person, and no longer on the floor than one who lies
    with the arms stretched beyond the head."""
    places_m = np.column_stack([scene.overview_m[is_own], scene.heights_m[is_own]])
    return bool(len(places_m) and (np.ptp(places_m, axis=0) < LONGEST_M).all())


def nearest_body(scene: Scene, tracks: Sequence[Track]) -> Distance:
    """[h, w] how far each pixel is from the nearest head of those whose body it is, infinity where
    it is nobody's."""
    bodies_m = [track.body_m for track in tracks if track.body_m is not None]
    if not bodies_m:
        return np.full(scene.cloud.depth_m.shape, np.inf, np.float32)
    nearest_m = bodies_m[0].copy()
    for body_m in bodies_m[1:]:
        np.minimum(nearest_m, body_m, out=nearest_m)
    return nearest_m


def with_pieces(
    scene: Scene, tracks: Sequence[Track], settings: PeopleSettings, *, behind: bool
) -> Distance:
    """[N, h, w] the tracks' bodies with the limbs that the image cuts off from them, those `behind`
    a body, too, or only those before it."""
    pieces = Pieces.of(scene, union_of(scene, tracks), settings.pieces)
    whole_m = np.empty((len(tracks), *scene.cloud.depth_m.shape), np.float32)
    for index, track in enumerate(tracks):
        whole_m[index] = track.body_m
        if track.is_seen:
            pieces.join_to(whole_m[index], track.place_camera, stature_m(track), behind=behind)
    return whole_m


def own_mask(scene: Scene, track: Track) -> Mask:
    """[h, w] what is a track's body."""
    if track.body_m is None:
        return np.zeros(scene.cloud.depth_m.shape, np.bool_)
    return track.body_m < np.inf


def union_of(scene: Scene, tracks: Sequence[Track]) -> Mask:
    """[h, w] what is anybody's."""
    return nearest_body(scene, tracks) < np.inf


def split(
    scene: Scene,
    tracks: Sequence[Track],
    bodies_m: Distance,
    told: Told,
    settings: SegmentationSettings,
) -> None:
    """Leave to each track those pixels of its body, [N, h, w], that are its own."""
    is_persons = [track.id > 0 for track in tracks]
    if settings.by_overview:
        is_anothers = ~np.array(is_persons, np.bool_)[:, None, None]
        bodies_m[is_anothers & union_of(scene, [t for t in tracks if t.id])] = np.inf
        radii_m = [settings.core_radius * stature_m(track) for track in tracks]
        heads_camera = [track.place_camera for track in tracks]
        split_by_overview(scene, bodies_m, heads_camera, radii_m)
        return
    joints_camera = [told.joints_of(track.id) for track in tracks]
    for track, body_m, joints in zip(tracks, bodies_m, joints_camera, strict=True):
        if joints is not None:
            _leave_out_far(scene, track, body_m, joints)
    heights_m = [track.height.height_m for track in tracks]
    split_users(scene, bodies_m, is_persons, joints_camera, heights_m, settings)


def _leave_out_far(scene: Scene, track: Track, body_m: Distance, joints_camera: Vector) -> None:
    """Take from a track's body, [h, w], the pieces that are far from where the tracked joints
    [J, 3] were, if the head is still there."""
    low, high = np.nanmin(joints_camera, axis=0), np.nanmax(joints_camera, axis=0)
    place = track.place_camera
    if (place < low - HEAD_STEP_M).any() or (place > high + HEAD_STEP_M).any():
        return
    cloud, is_own = scene.cloud, body_m < np.inf
    points_camera = cloud.points_camera[is_own]
    off_m = np.maximum(low - points_camera, points_camera - high).max(axis=1)
    is_far = off_m > OFF_BODY_M
    if is_far.any():
        is_kept = np.zeros(body_m.shape, np.bool_)
        is_kept[is_own] = ~is_far
        _keep_together(scene, body_m, is_kept)
