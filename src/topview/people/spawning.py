"""Where a new track may begin, and where a track begins anew at another head."""

from __future__ import annotations

from collections.abc import Sequence
from math import dist
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.heads import HeadCandidate
from topview.people.bodies import (
    SHOWN_M2,
    UNDER_HEAD_M,
    area_m2,
    is_short,
    nearest_body,
    union_of,
)
from topview.people.existence import (
    DOUBTED,
    NEW_TRACK_S,
    OWN_HEAD,
    TOO_NEAR,
    Existence,
    is_too_near,
)
from topview.people.features import FEATURE_NAMES
from topview.people.step import Step
from topview.people.told import Told
from topview.people.track import SURE_HEAD, Track
from topview.room.scene import Scene

Mask = NDArray[np.bool_]

# All ours. So much more confidence makes a head of what else is on the body.
MUCH_MORE: Final = 0.12
# A head that is not where it was expected may be so much lower.
LOWER_M: Final = 0.3
SPREAD_FEATURES: Final = tuple(
    FEATURE_NAMES.index(name) for name in ("too large", "too spread out", "too much above the head")
)


def is_free(scene: Scene, head: HeadCandidate, tracks: Sequence[Track], told: Told) -> str | None:
    """Why a head cannot be a new one's, whatever its body looks like; None if it can."""
    if is_too_near(head.center_camera, tracks, scene):
        return TOO_NEAR
    if any(track.confidence < SURE_HEAD and reaches(scene, track, head) for track in tracks):
        return OWN_HEAD  # it may be the track's own (`rejoined`)
    if told.claims(head.center_camera, tracks) or told.is_on_body(head.center_camera):
        return OWN_HEAD
    return None


def free_of(tracks: Sequence[Track], scene: Scene, told: Told) -> set[int]:
    """Keys of those that are not confirmed, and that have a body and a head which may be no part of
    somebody who is."""
    confirmed = [track for track in tracks if track.id]
    return {
        track.key
        for track in tracks
        if not track.id
        and area_m2(scene, track) > SHOWN_M2
        and is_free(scene, track.head, confirmed, told) is None
    }


def reaches(scene: Scene, track: Track, head: HeadCandidate) -> bool:
    """Whether a head is on a track's body."""
    row, column, in_view = scene.cloud.pixel_at(head.center_camera)
    return in_view and track.body_m is not None and bool(track.body_m[row, column] < np.inf)


def room_left_of(
    step: Step, track: Track, body: NDArray[np.float32], others: Sequence[Track]
) -> Mask:
    """[h, w] what of a new track's body, [h, w], is held for the room until it moves: where that is
    no person's, only what stands right under the head is; and nothing that is another's. What is no
    longer than a person may be one who lies or goes on all fours: a network is asked about it."""
    scene, is_spread = step.scene, track.evidence.features[list(SPREAD_FEATURES)].any()
    if not is_spread or (step.told.has_network and is_short(scene, body < np.inf)):
        return np.zeros(body.shape, np.bool_)
    is_rest = (body < np.inf) & ~scene.is_under(track.place_camera, UNDER_HEAD_M)
    return is_rest & ~union_of(scene, others)


def under_higher(scene: Scene, head: HeadCandidate, heads: Sequence[HeadCandidate]) -> Mask:
    """[h, w] what stands right under a higher one of the heads: not the room's, though it is not
    this head's, as that may be a shoulder."""
    height_m = scene.height_of(head.center_camera)
    is_under = np.zeros(scene.cloud.depth_m.shape, np.bool_)
    for other in heads:
        if scene.height_of(other.center_camera) > height_m:
            is_under |= scene.is_under(other.center_camera, UNDER_HEAD_M)
    return is_under


def rejoined(
    tracks: Sequence[Track], step: Step, heads: Sequence[HeadCandidate], existence: Existence
) -> tuple[list[Track], list[HeadCandidate]]:
    """The tracks, and the heads that are left; at another head are those tracks whose body has one
    that looks much more like it, and has had it for long enough if they are people; or, if they
    are not confirmed, one that is likelier a person's. Of a person who follows what is no sure head
    that may be the head of a track that is not confirmed, but rather a person's than not; that
    track ends. None is where the network does not see the track's head.
    """
    scene, after, left = step.scene, [], list(heads)
    doubtful = {
        track.key: track.head
        for track in tracks
        if not track.id and track.is_seen and existence.existence_of(track) > DOUBTED
    }
    ended: set[int] = set()
    for track in tracks:
        others = [other for other in tracks if other.key != track.key and other.id]
        is_lost = track.id and track.confidence < SURE_HEAD
        theirs = {key: head for key, head in doubtful.items() if is_lost and key not in ended}
        rival = next(
            (
                head
                for head in [*left, *theirs.values()]
                if _may_be_its(scene, track, head, others)
                and not step.told.is_elsewhere(head.center_camera, track, tracks, step.elapsed_s)
                and _is_better(step, track, head, others, existence)
            ),
            None,
        )
        since_s = scene.time_s if track.rival_since_s is None else track.rival_since_s
        if rival is None:
            after.append(replace(track, rival_since_s=None))
        elif track.id and scene.time_s - since_s < NEW_TRACK_S:
            after.append(replace(track, rival_since_s=since_s))
        else:
            after.append(track.restarted(scene, rival))
            left = [head for head in left if head is not rival]
            ended |= {key for key, head in theirs.items() if head is rival}
    return [track for track in after if track.key not in ended], left


def _may_be_its(scene: Scene, track: Track, head: HeadCandidate, others: Sequence[Track]) -> bool:
    """Whether a head on a track's body, nearer to none of other people's, is no lower than what is
    followed, but for what that is unlike a head, and looks much more like one; of a track that is
    neither confirmed nor asked about, shape decides (`_is_better`)."""
    if not _is_surer(track, head) and (track.id or track.evidence.asked_s):
        return False
    up_m = float((head.center_camera - track.place_camera) @ scene.up_camera)
    own_m = dist(track.place_camera.tolist(), head.place)
    return (
        up_m > -LOWER_M * (1.0 - track.confidence)
        and reaches(scene, track, head)
        and all(dist(other.place_camera.tolist(), head.place) > own_m for other in others)
    )


def _is_surer(track: Track, head: HeadCandidate) -> bool:
    """Whether a head looks much more like one than what is followed."""
    return head.confidence > max(track.confidence + MUCH_MORE, SURE_HEAD)


def _is_better(
    step: Step, track: Track, head: HeadCandidate, others: Sequence[Track], existence: Existence
) -> bool:
    """Whether a head may be a person's by the shape of what no other person has, and looks much
    more like one than what is followed or is likelier a person's, now and by all until now."""
    nearest = nearest_body(step.scene, others)
    shape = step.features_under(head, nearest)
    if not existence.may_be(shape):
        return False
    if _is_surer(track, head):
        return True
    by_shape = existence.likelihood.log_odds_of_shape
    until_now = by_shape(track.evidence.shape)
    return by_shape(shape) > max(until_now, by_shape(step.features_under(track.head, nearest)))
