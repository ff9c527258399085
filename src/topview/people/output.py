"""What is found in a frame, and what a tracker of bodies is told of each track."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.faces_and_hands import SkinDetections
from topview.detect.protocol import ColorDetector
from topview.people.bodies import SHOWN_M2, area_m2, own_mask
from topview.people.clusters import Cluster
from topview.people.colors import skin_share
from topview.people.existence import Existence, Refusal
from topview.people.height import measured_height
from topview.people.likelihood import Likelihood
from topview.people.segmentation import full_pixels
from topview.people.track import Track
from topview.people.users import User
from topview.records import Frame
from topview.room.scene import Scene

Mask = NDArray[np.bool_]

# Ours: so many who may be people are told of; and who is rather one than not is asked about first.
MOST_DOUBTS: Final = 4
LIKELY: Final = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """All that is found in one frame, with what it is found by.

    Attributes:
        scene: what the depth shows.
        skin_detections: None if colour is not used.
        users: nearest first.
        refusals: heads that are nobody's yet, and why.
        tracks: all, after this frame.
    """

    scene: Scene
    skin_detections: SkinDetections | None
    users: tuple[User, ...]
    refusals: tuple[Refusal, ...]
    tracks: tuple[Track, ...]


def users_of(
    tracks: Sequence[Track],
    scene: Scene,
    skin: SkinDetections | None,
    frontal: Set[int],
    existence: Existence,
) -> list[User]:
    """Those whom `existence` puts out, with stature and face as this frame shows them; `frontal`
    are the keys of those whose face is found."""
    users = []
    for track in tracks:
        if not track.id:
            continue
        is_own = own_mask(scene, track)
        share = None
        if track.is_seen:
            track.height.add(measured_height(scene, track.place_camera, is_own), scene.time_s)
            share = skin_share(skin, scene.cloud.frame, track.place_camera)
        face_share = track.face.update(share, track.key in frontal, scene.time_s)
        if existence.is_put_out(track, scene):
            users.append(_user(scene, track, is_own, face_share))
    return users


def doubtful_of(
    tracks: Sequence[Track],
    scene: Scene,
    likelihood: Likelihood,
    next_cluster: Cluster | None,
    at_rest: Set[int],
) -> tuple[User, ...]:
    """Who may be people, has a body, and of whom the network may have news; first who probably is,
    then of whom it was asked least. A cluster, `next_cluster`, has its turn among them; `at_rest`
    are the keys of those of whom the frame tells nothing new."""
    doubts = [
        t
        for t in tracks
        if not t.id
        and t.evidence.is_to_be_asked(scene.time_s, t.key in at_rest)
        and area_m2(scene, t) > SHOWN_M2
    ]
    turns = {t.key: (t.existence(likelihood) <= LIKELY, t.evidence.asked_s) for t in doubts}
    doubts.sort(key=lambda t: (*turns[t.key], -t.existence(likelihood), t.key))
    users = tuple(_user(scene, t, own_mask(scene, t), None) for t in doubts[:MOST_DOUBTS])
    if next_cluster is None or (doubts and turns[doubts[0].key] <= (True, next_cluster.asked_s)):
        return users
    return next_cluster.as_user(scene), *users


def frontal_of(tracks: Sequence[Track], colors: ColorDetector | None, frame: Frame) -> set[int]:
    """Keys of those whose face a detector of faces finds; who is looked at in turn is whose skin
    does not tell yet."""
    if colors is None:
        return set()
    asked = [t for t in tracks if t.id and t.is_seen and not t.face.is_known]
    told = colors.check_faces_in_turn(frame, [track.place_camera for track in asked])
    return {asked[index].key for index, is_frontal in told if is_frontal}


def _user(scene: Scene, track: Track, is_own: Mask, face_share: float | None) -> User:
    return User(
        track.told_as,
        track.place_camera.copy(),
        track.is_seen,
        track.height.height_m,
        track.height.is_measured,
        full_pixels(scene, is_own),
        face_share,
        (track.places or track.motion).sigma_m,
    )
