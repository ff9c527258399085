"""Who is there: one recursion over tracks, from depth frames to people with their pixels.

Each frame: predict, detect, associate, update or coast, spawn, segment, confirm, end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.cloud import Cloud
from topview.detect.detectors import head_detector
from topview.detect.faces_and_hands import SkinDetections
from topview.detect.heads import (
    HeadCandidate,
    Hints,
    head_evidence,
    refine_center,
    torso_is_unread,
)
from topview.detect.protocol import HeadDetector
from topview.filter.over_time import Turns
from topview.people.appearance import EVERY_S, with_appearance
from topview.people.association import associate
from topview.people.background import Background
from topview.people.bodies import body_of, left_of, masks_of, over_body, union_of, with_pieces
from topview.people.colors import hands_in, skin_share
from topview.people.existence import Existence, Refusal, is_put_out
from topview.people.features import Features, features_of
from topview.people.floor import FloorPlane, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M, measured_height
from topview.people.motion import PAUSE_S
from topview.people.scene import Scene
from topview.people.segmentation import body_distance, full_pixels
from topview.people.settings import PeopleSettings
from topview.people.spawning import free_of, is_free, rejoined, room_left_of
from topview.people.told import NOTHING_TOLD, Told
from topview.people.track import Track
from topview.people.users import HandCandidate, User, by_depth
from topview.records import Frame, InputError
from topview.timing import StageClock

__all__ = ["Found", "PeopleFinder", "PeopleSettings"]

Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Ours: a head is in view of which no more than this is hidden.
IN_VIEW = 0.15
# Ours: so many who may be people are told of.
MOST_DOUBTS = 4


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


class PeopleFinder:
    """Tracks people from one frame to the next, and says which pixels are whose.

    Attributes:
        settings: what it was made with.
        clock: seconds spent in each stage of each frame.
        found: all about the last frame; None before the first.
        doubtful: who may be people, with ids below 0; whether the first is, is to be told with the
            next frame.
    """

    def __init__(
        self, settings: PeopleSettings | None = None, detector: HeadDetector | None = None
    ) -> None:
        self.settings = settings or PeopleSettings()
        self.clock = StageClock()
        self.found: Found | None = None
        self.doubtful: tuple[User, ...] = ()
        self._detector = detector or head_detector(self.settings.detector, self.clock)
        # What looks at colours, if the detector does.
        self._skin = self._detector.colors
        self._floor = FloorTracker(self.settings.floor)
        self._background = Background()
        self._existence = Existence(self.settings.people)
        self._looks = Turns(EVERY_S)
        self._next_key = 1

    @property
    def floor(self) -> FloorPlane | None:
        """The floor as far as it is known, None where it was not in view."""
        return self._floor.plane

    @property
    def skin_detections(self) -> SkinDetections | None:
        """The skin detections of the last frame; None if colour is not used."""
        return None if self._skin is None else self._skin.skin_detections

    @property
    def hands(self) -> tuple[HandCandidate, ...]:
        """The hands that the last frame's colours show, whosesoever they are."""
        return hands_in(self.skin_detections)

    def update(self, image: Pyramid, told: Told = NOTHING_TOLD) -> list[User]:
        """The people in the next frame; `told` what is known of the last one's bodies."""
        last = None if self.found is None else self.found.scene
        before = () if self.found is None else self.found.tracks
        with self.clock.stage("scene"):
            scene = self._look(image)
        with self.clock.stage("heads"):
            heads = self._detect(scene, before)
        with self.clock.stage("users"):
            is_time = self._looks.due(scene.time_s) > 0
            log_odds_of = _ShapeOdds(scene, before, self._existence, self.settings)
            taken, left = associate(before, scene, heads, log_odds_of)
            tracks = self._moved(before, taken, scene, last, told)
            tracks, left = rejoined(tracks, scene, left, self._features, self._existence)
            tracks = self._with_evidence(tracks, scene, last, told, is_time)
            tracks, refusals = self._spawned(tracks, scene, left, told)
            tracks = with_appearance(tracks, scene, is_time)
            tracks = self._segmented(tracks, scene, told)
            free = free_of(tracks, scene, told)
            tracks = self._existence.confirmed(tracks, scene, free, told.has_network)
            tracks = self._ended(tracks, scene)
            users = self._users(tracks, scene)
        self._learn_room(scene, users)
        doubts = [self._existence.refusal_of(track) for track in tracks if not track.id]
        self.found = Found(
            scene,
            self.skin_detections,
            tuple(by_depth(users)),
            (*refusals, *doubts),
            tuple(tracks),
        )
        self.clock.end_frame()
        return users

    def _look(self, image: Pyramid) -> Scene:
        cloud = Cloud.of(image)
        is_background = self._background.is_seen_in(cloud.depth_m, cloud.camera.noise)
        scene = Scene.of(cloud, self._floor.update(cloud), is_background, self.settings.scene)
        is_looked_at = self.settings.areas.looked_at(scene)
        if is_looked_at is None:
            return scene
        return replace(scene, is_free_standing=scene.is_free_standing & is_looked_at)

    def _detect(self, scene: Scene, before: Sequence[Track]) -> list[HeadCandidate]:
        """Detected heads, centred on their points, best first."""
        if self.found is None and self._detector.needs_color and scene.cloud.frame.color is None:
            raise InputError(
                f"detector is {self.settings.detector}, but the recording has no colour; "
                'it must be "auto" or "depth"'
            )
        expected = [track.expected(scene.time_s).position_camera for track in before]
        hints = Hints(expected, scene.is_free_standing)
        heads = []
        for head in self._detector.detect(scene.cloud, scene.up_camera, hints):
            center = refine_center(scene.cloud, head.center_camera, scene.up_camera)
            if center is not None and self.settings.areas.hold(scene, center):
                heads.append(replace(head, center_camera=center))
        return heads

    def _moved(
        self,
        before: Sequence[Track],
        taken: Mapping[int, HeadCandidate],
        scene: Scene,
        last: Scene | None,
        told: Told,
    ) -> list[Track]:
        """The tracks in this frame, by the heads that they have taken or by their bodies."""
        after = []
        for index, track in enumerate(before):
            told_camera = told.head_of(track, before, scene.time_s - track.time_s)
            head = taken.get(index)
            if head is not None:
                track = track.updated(scene.cloud, head).corrected(scene.cloud, told_camera)
            else:
                track = track.coasted(scene)
            track = replace(track, body_m=body_of(scene, track, self.settings, last))
            after.append((track, told_camera))
        seen = [track for track, _ in after if track.is_seen]
        elapsed_s = 0.0 if last is None else scene.time_s - last.time_s
        return [
            track if track.is_seen else over_body(scene, track, seen, told_camera, elapsed_s)
            for track, told_camera in after
        ]

    def _features(self, scene: Scene, head: HeadCandidate, tracks: Sequence[Track]) -> Features:
        """Of a head and what of the body below it is nobody else's."""
        body = body_distance(scene, head.center_camera, PRIOR_HEIGHT_M, self.settings.segmentation)
        return features_of(scene, head, body, left_of(body, tracks))

    def _with_evidence(
        self,
        tracks: Sequence[Track],
        scene: Scene,
        last: Scene | None,
        told: Told,
        is_time: bool,
    ) -> list[Track]:
        """The tracks, with what this frame, and the network in the last one, tell of them."""
        elapsed_s = 0.0 if last is None else min(max(scene.time_s - last.time_s, 0.0), PAUSE_S)
        after = []
        for track in tracks:
            evidence = track.evidence
            if is_time or not track.id:
                head = _head_in_view(scene, track)
                others = [other for other in tracks if other.key != track.key]
                if head is not None and track.body_m is not None:
                    own = left_of(track.body_m, others)
                    shape = features_of(scene, head, track.body_m, own)
                    way_m = float(np.linalg.norm(track.place_camera - track.born_camera))
                    evidence = evidence.with_shape(shape, way_m, scene.time_s)
            log_odds = told.log_odds_of(track, tracks)
            if log_odds is not None:
                evidence = evidence.with_network(log_odds, elapsed_s)
            since_s = track.shadow_since_s if track.shadow_since_s is not None else scene.time_s
            is_shadow = told.is_shadow(track, tracks)
            after.append(
                replace(track, evidence=evidence, shadow_since_s=since_s if is_shadow else None)
            )
        return after

    def _spawned(
        self,
        tracks: Sequence[Track],
        scene: Scene,
        heads: Sequence[HeadCandidate],
        told: Told,
    ) -> tuple[list[Track], list[Refusal]]:
        """The tracks and those of new heads; and the heads that have none."""
        after, refusals = list(tracks), []
        for head in sorted(heads, key=lambda head: -head.confidence):
            reason = is_free(scene, head, after, told)
            features = self._features(scene, head, after) if reason is None else None
            if features is not None and self._existence.may_be(features):
                track = Track.born(self._next_key, scene.cloud, head, features)
                body = body_of(scene, track, self.settings, None)
                is_rest = room_left_of(scene, track, body)
                self._background.learn(scene.cloud.depth_m, is_rest)
                body[is_rest] = np.inf
                self._background.forget(body < np.inf)
                after.append(replace(track, body_m=body))
                self._next_key += 1
            elif features is not None:
                reason = self._existence.likelihood.worst_of(features)
            if reason is not None:
                refusals.append(Refusal(head, reason))
        return after, refusals

    def _segmented(self, tracks: Sequence[Track], scene: Scene, told: Told) -> list[Track]:
        """The tracks, each with the pixels that are its own; the rest is learnt as the room's, if
        it is steady."""
        whole = with_pieces(scene, tracks, self.settings)
        cloud = scene.cloud
        self._background.update(
            cloud.depth_m, union_of(scene, whole), scene.time_s, cloud.camera.noise
        )
        masks = masks_of(scene, whole, told, self.settings.segmentation)
        return [
            replace(track, body_m=np.where(is_own, track.body_m, np.float32(np.inf)))
            for track, is_own in zip(whole, masks, strict=True)
        ]

    def _ended(self, tracks: Sequence[Track], scene: Scene) -> list[Track]:
        """Those that go on; what is probably furniture is learnt as the room's."""
        after = []
        for track in tracks:
            if self._existence.is_room(track, scene):
                is_body = union_of(scene, [track])
                self._background.learn(scene.cloud.depth_m, is_body)
            elif not self._existence.has_ended(track, scene):
                after.append(track)
        return after

    def _learn_room(self, scene: Scene, users: Sequence[User]) -> None:
        """Tell the eye for colours what is nobody's."""
        if self._skin is None or not self._skin.background_is_due:
            return
        is_somebodys = np.zeros(scene.cloud.frame.depth_m.shape, np.bool_)
        for user in users:
            is_somebodys.ravel()[user.pixels] = True
        self._skin.update_background(is_somebodys)

    def _frontal(self, tracks: Sequence[Track], frame: Frame) -> set[int]:
        """Keys of those whose face a detector of faces finds; who is looked at in turn is whose
        skin does not tell yet."""
        if self._skin is None:
            return set()
        asked = [track for track in tracks if track.is_seen and not track.face.is_known]
        told = self._skin.check_faces_in_turn(frame, [track.place_camera for track in asked])
        return {asked[index].key for index, is_frontal in told if is_frontal}

    def _turn_of(self, track: Track) -> tuple[float, float, int]:
        """In which order the network is asked: who was not yet, and is likely, first."""
        return track.evidence.asked_s, -track.existence(self._existence.likelihood), track.key

    def _users(self, tracks: Sequence[Track], scene: Scene) -> list[User]:
        """What the tracker of bodies is told; and who is most in doubt."""
        frame = scene.cloud.frame
        confirmed = [track for track in tracks if track.id]
        frontal = self._frontal(confirmed, frame)
        users = []
        for track in confirmed:
            is_users = union_of(scene, [track])
            skin = None
            if track.is_seen:
                measured_m = measured_height(scene, track.place_camera, is_users)
                track.height.add(measured_m, scene.time_s)
                skin = skin_share(self.skin_detections, frame, track.place_camera)
            face_share = track.face.update(skin, track.key in frontal, scene.time_s)
            if is_put_out(track, scene):
                users.append(_user(scene, track, track.id, is_users, face_share))
        doubts = [track for track in tracks if not track.id and track.is_seen]
        doubts.sort(key=self._turn_of)
        self.doubtful = tuple(
            _user(scene, track, track.told_as, union_of(scene, [track]), None)
            for track in doubts[:MOST_DOUBTS]
        )
        return users


def _head_in_view(scene: Scene, track: Track) -> HeadCandidate | None:
    """A track's head as it looks; None where it is not in view."""
    center, confidence = track.place_camera, track.confidence
    if not track.is_seen:
        if scene.covered_share(center) > IN_VIEW:
            return None
        confidence = float(head_evidence(scene.cloud, center[None], scene.up_camera).confidence[0])
    is_unread = torso_is_unread(scene.cloud, center[None], scene.up_camera[None])
    return HeadCandidate(center, confidence, bool(is_unread[0]))


def _user(scene: Scene, track: Track, id: int, is_users: Mask, face_share: float | None) -> User:
    return User(
        id,
        track.place_camera.copy(),
        track.is_seen,
        track.height.height_m,
        track.height.is_measured,
        full_pixels(scene, is_users),
        face_share,
    )


@dataclass(slots=True, eq=False)
class _ShapeOdds:
    """Log-odds, by shape, that what nobody explained in the last frame is a person below a head."""

    scene: Scene
    before: Sequence[Track]
    existence: Existence
    settings: PeopleSettings

    def __call__(self, head: HeadCandidate) -> float:
        body = body_distance(
            self.scene, head.center_camera, PRIOR_HEIGHT_M, self.settings.segmentation
        )
        seen = [track for track in self.before if track.is_seen]
        features = features_of(self.scene, head, body, left_of(body, seen))
        return self.existence.likelihood.log_odds_of(np.append(features, (0.0, 0.0)))
