"""Who is there: one recursion over tracks, from depth frames to people with their pixels.

Each frame: predict, detect, associate, update or coast, spawn, segment, confirm, end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from topview.camera.pyramid import Pyramid
from topview.detect.cloud import Cloud
from topview.detect.detectors import head_detector
from topview.detect.faces_and_hands import SkinDetections
from topview.detect.heads import HeadCandidate, Hints, refine_center
from topview.detect.protocol import HeadDetector
from topview.filter.over_time import Turns
from topview.kernels.pieces import fill_at
from topview.people.appearance import EVERY_S, with_appearance
from topview.people.association import associate, is_apart
from topview.people.bodies import nearest_body, own_mask, split, union_of, with_pieces
from topview.people.clusters import Clusters, give_what_emerges, track_of_cluster
from topview.people.colors import hands_in
from topview.people.existence import CONFIRMED, Refusal
from topview.people.output import Found, doubtful_of, frontal_of, users_of
from topview.people.rest import is_at_rest, left_as_they_were
from topview.people.returning import ReturningPeople
from topview.people.settings import PeopleSettings
from topview.people.spawning import free_of, is_free, rejoined, room_left_of, under_higher
from topview.people.step import ShapeOdds, Step
from topview.people.told import NOTHING_TOLD, Told
from topview.people.track import Track
from topview.people.users import HandCandidate, User, by_depth
from topview.records import InputError
from topview.room.background import Background
from topview.room.floor import FloorPlane, FloorTracker
from topview.room.scene import Scene
from topview.timing import StageClock

__all__ = ["PeopleFinder", "PeopleSettings"]


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
        self._steady = Background(np.inf)  # of all that is seen, people too
        self._clusters = Clusters()
        self._existence = ReturningPeople(self.settings.people, self.settings.reidentify)
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
            step = Step(scene, last, told, self.settings, self._existence.likelihood, before)
            by_shape = ShapeOdds(step, self._existence)
            told_heads = [head for head, _ in step.heads_of_doubtful.values()]
            is_time = self._looks.due(scene.time_s) > 0
            at_rest = {t.key for t in before if is_at_rest(t, scene, step.likelihood)}
            resting = [t for t in before if t.key in at_rest and not (is_time or told.tells_of(t))]
            active = [track for track in before if track not in resting]
            taken, left = associate(active, scene, heads, by_shape, told_heads)
            left = [head for head in left if is_apart(head, [track.head for track in resting])]
            tracks = [*step.moved(active, taken), *left_as_they_were(resting, scene, last)]
            tracks, left = rejoined(tracks, step, left, self._existence)
            known = {t.key for t in tracks if t.id and not is_time} | {t.key for t in resting}
            tracks = step.with_evidence(tracks, known)
            tracks, refusals = self._spawned(tracks, step, left)
            tracks = self._with_cluster(tracks, step)
            tracks = with_appearance(tracks, scene, is_time)
            tracks = self._segmented(tracks, step)
            free = free_of(tracks, scene, told)
            tracks = self._existence.confirmed(tracks, scene, free, told.has_network)
            tracks = self._ended(tracks, scene)
        with self.clock.stage("pixels"):
            frontal = frontal_of(tracks, self._skin, scene.cloud.frame)
            users = users_of(tracks, scene, self.skin_detections, frontal, self._existence)
            self.doubtful = ()
            if told.has_network:
                cluster = self._clusters.next
                self.doubtful = doubtful_of(tracks, scene, step.likelihood, cluster, at_rest)
            self._clusters.tell(self.doubtful)
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
        noise, nobody = cloud.camera.noise, np.zeros(cloud.depth_m.shape, np.bool_)
        self._steady.update(cloud.depth_m, nobody, scene.time_s, noise)
        scene = replace(scene, steady=self._steady)
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

    def _spawned(
        self, tracks: Sequence[Track], step: Step, heads: Sequence[HeadCandidate]
    ) -> tuple[list[Track], list[Refusal]]:
        """The tracks and those of new heads; and the heads that have none."""
        scene, after = step.scene, list(tracks)
        nearest = nearest_body(scene, after)
        refusals = []
        for head in sorted(heads, key=lambda head: -head.confidence):
            reason = is_free(scene, head, after, step.told)
            features = step.features_under(head, nearest) if reason is None else None
            if features is not None and self._existence.may_be(features):
                track = Track.born(self._next_key, scene.cloud, head, features)
                body = step.body_under(head).copy()
                is_rest = room_left_of(step, track, body, after)
                if self._existence.existence_of(track) > CONFIRMED:
                    is_rest[:] = False
                is_room = is_rest & ~under_higher(scene, head, heads)
                self._background.learn(scene.cloud.depth_m, is_room)
                body[is_rest] = np.inf
                self._background.forget(body < np.inf)
                np.minimum(nearest, body, out=nearest)
                after.append(self._existence.taken_up(replace(track, body_m=body), scene))
                self._next_key += 1
            elif features is not None:
                reason = self._existence.likelihood.worst_of(features)
            if reason is not None:
                refusals.append(Refusal(head, reason))
        return after, refusals

    def _with_cluster(self, tracks: list[Track], step: Step) -> list[Track]:
        """The tracks, and that of the cluster which the network has taken for a person's."""
        asked = self._clusters.asked
        found = track_of_cluster(step, asked, tracks, self._next_key, self._existence)
        if found is None:
            return tracks
        self._background.forget(own_mask(step.scene, found))
        self._next_key += 1
        return [*tracks, found]

    def _segmented(self, tracks: Sequence[Track], step: Step) -> list[Track]:
        """The tracks, each with the pixels that are its own; the rest is learnt as the room's, if
        it is steady."""
        scene, cloud = step.scene, step.scene.cloud
        # What is behind a body may be a curtain, of which a network would be asked with it.
        behind = not step.told.has_network
        bodies_m = with_pieces(scene, tracks, self.settings, behind=behind)
        give_what_emerges(scene, tracks, bodies_m, step.told)
        is_somebodys = np.minimum.reduce(bodies_m, initial=np.inf) < np.inf
        if step.told.has_network:
            is_somebodys |= self._clusters.update(scene, is_somebodys, step.elapsed_s)
        self._background.update(cloud.depth_m, is_somebodys, scene.time_s, cloud.camera.noise)
        split(scene, tracks, bodies_m, step.told, self.settings.segmentation)
        return [replace(track, body_m=own) for track, own in zip(tracks, bodies_m, strict=True)]

    def _ended(self, tracks: Sequence[Track], scene: Scene) -> list[Track]:
        """Those that go on; what is probably furniture is learnt as the room's."""
        room = [track for track in tracks if self._existence.is_room(track, scene)]
        others = [track for track in tracks if track not in room]
        people = [track for track in others if track.id]
        if room:
            is_room = union_of(scene, room) & ~union_of(scene, people)
            self._background.learn(scene.cloud.depth_m, is_room)
        return self._existence.going_on(others, scene)

    def _learn_room(self, scene: Scene, users: Sequence[User]) -> None:
        """Tell the eye for colours what is nobody's."""
        if self._skin is None or not self._skin.background_is_due:
            return
        is_somebodys = np.zeros(scene.cloud.frame.depth_m.shape, np.bool_)
        for user in users:
            fill_at(user.pixels, 1, is_somebodys)
        self._skin.update_background(is_somebodys)
