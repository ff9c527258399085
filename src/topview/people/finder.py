"""From depth frames to users: who is there, where the head is, and which points are whose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.cloud import Cloud
from topview.detect.detectors import head_detector
from topview.detect.faces_and_hands import SkinDetections
from topview.detect.heads import HeadCandidate, Hints, refine_center
from topview.detect.protocol import HeadDetector
from topview.filter.over_time import Turns
from topview.people.association import correct, find_again
from topview.people.background import Background
from topview.people.colors import hands_in, skin_share
from topview.people.floor import FloorPlane, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M, measured_height
from topview.people.identity import PAUSE_S, KnownUser
from topview.people.looks import EVERY_S, learn_heads, tell_apart
from topview.people.newcomers import UNMOVED, Newcomers
from topview.people.pieces import Pieces
from topview.people.present import Present, Refusal
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.segmentation import full_pixels, split_by_overview, split_users
from topview.people.settings import PeopleSettings
from topview.people.users import HandCandidate, User, by_depth
from topview.records import Frame, InputError, Person
from topview.timing import StageClock

__all__ = ["PeopleFinder", "PeopleSettings"]

Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]
Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """All that is found in one frame, with what it is found by.

    Attributes:
        scene: what the depth shows.
        skin_detections: None if colour is not used.
        users: nearest first.
        refusals: heads that have not been made users, and why.
    """

    scene: Scene
    skin_detections: SkinDetections | None
    users: tuple[User, ...]
    refusals: tuple[Refusal, ...]


class PeopleFinder:
    """Finds people in one frame after the other, and knows them again.

    Attributes:
        settings: what it was made with.
        clock: seconds spent in each stage of each frame.
        found: all about the last frame; None before the first.
    """

    def __init__(
        self, settings: PeopleSettings | None = None, detector: HeadDetector | None = None
    ) -> None:
        self.settings = settings or PeopleSettings()
        self.clock = StageClock()
        self.found: Found | None = None
        self._detector = detector or head_detector(self.settings.detector, self.clock)
        # What looks at colours, if the detector does.
        self._skin = self._detector.colors
        self._floor = FloorTracker(self.settings.floor)
        self._background = Background()
        self._roll = Roll(self.settings)
        self._newcomers = Newcomers(self.settings, self._background)
        self._looks = Turns(EVERY_S)

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

    def update(self, image: Pyramid, tracked: Sequence[Person] = ()) -> list[User]:
        """The people in the next frame; `tracked` as they were in the last one."""
        roll = self._roll
        with self.clock.stage("scene"):
            scene = self._look(image)
        with self.clock.stage("heads"):
            heads = self._detect(scene)
        with self.clock.stage("users"):
            heads = find_again(roll, scene, heads)
            sees_color, is_time = (
                self.skin_detections is not None,
                self._looks.due(scene.time_s) > 0,
            )
            if sees_color:
                learn_heads(roll, scene, is_time)
            tell_apart(scene, roll.known, sees_color, is_time)
            heads = correct(roll, scene, heads)
            self._newcomers.judge(roll, scene)
            self._newcomers.welcome(roll, scene, heads)
            users, suspects = self._users(scene, tracked)
            roll.dismiss(scene)
        self._learn_room(scene, users)
        refusals = (*self._newcomers.refusals, *suspects)
        self.found = Found(scene, self.skin_detections, tuple(by_depth(users)), refusals)
        self.clock.end_frame()
        return users

    def _look(self, image: Pyramid) -> Scene:
        cloud = Cloud.of(image)
        is_background = self._background.is_seen_in(cloud.depth_m, cloud.camera.noise)
        return Scene.of(cloud, self._floor.update(cloud), is_background, self.settings.scene)

    def _detect(self, scene: Scene) -> list[HeadCandidate]:
        """Detected heads, centred on their points, best first; those whose torso has no reading
        come last, if they stand on legs."""
        if self.found is None and self._detector.needs_color and scene.cloud.frame.color is None:
            raise InputError(
                f"detector is {self.settings.detector}, but the recording has no colour; "
                'it must be "auto" or "depth"'
            )
        expected = [user.predicted(scene.time_s) for user in self._roll.known]
        hints = Hints(expected, scene.is_free_standing)
        candidates = self._detector.detect(scene.cloud, scene.up_camera, hints)
        nobody = Present()
        centers = [
            refine_center(scene.cloud, candidate.center_camera, scene.up_camera)
            for candidate in candidates
        ]
        heads = [
            replace(candidate, center_camera=center)
            for center, candidate in zip(centers, candidates, strict=True)
            if center is not None
        ]
        return [
            head
            for head in heads
            if not head.torso_is_unread
            or nobody.person_under(scene, head, self.settings) is not None
        ]

    def _with_pieces(self, scene: Scene) -> list[Distance]:
        """The bodies with the limbs that are cut off from them; the rest is learnt as the room's,
        if it is steady."""
        is_somebodys = np.zeros(scene.cloud.depth_m.shape, np.bool_)
        for body in self._roll.bodies:
            is_somebodys |= np.isfinite(body)
        pieces = Pieces.of(scene, is_somebodys, self.settings.pieces)
        whole = [
            pieces.joined_to(body, user.head_camera, max(user.height.height_m, PRIOR_HEIGHT_M))
            if user.seen_s == scene.time_s
            else body
            for user, body in self._roll
        ]
        for body in whole:
            is_somebodys |= np.isfinite(body)
        cloud = scene.cloud
        self._background.update(cloud.depth_m, is_somebodys, scene.time_s, cloud.camera.noise)
        return whole

    def _split(self, scene: Scene, joints_camera: Sequence[Vector | None]) -> list[Mask]:
        """[h, w] per known user: whose each pixel is."""
        known, settings = self._roll.known, self.settings.segmentation
        bodies = self._for_somebody_first(self._with_pieces(scene))
        if not settings.by_overview:
            return split_users(scene, bodies, joints_camera, settings)
        radii_m = [
            settings.core_radius * max(user.height.height_m, PRIOR_HEIGHT_M) for user in known
        ]
        return split_by_overview(scene, bodies, [user.head_camera for user in known], radii_m)

    def _learn_room(self, scene: Scene, users: Sequence[User]) -> None:
        """Tell the eye for colours what is nobody's."""
        if self._skin is None or not self._skin.background_is_due:
            return
        is_somebodys = np.zeros(scene.cloud.frame.depth_m.shape, np.bool_)
        for user in users:
            is_somebodys.ravel()[user.pixels] = True
        self._skin.update_background(is_somebodys)

    def _for_somebody_first(self, bodies: list[Distance]) -> list[Distance]:
        """The bodies; of those who may be furniture, or an arm, only what nobody else reaches."""
        known = self._roll.known
        somebodys = [body for user, body in zip(known, bodies, strict=True) if not user.is_suspect]
        if not somebodys:
            return bodies
        is_somebodys = np.isfinite(np.minimum.reduce(somebodys))
        return [
            body if not user.is_suspect else np.where(is_somebodys, np.float32(np.inf), body)
            for user, body in zip(known, bodies, strict=True)
        ]

    def _frontal(self, frame: Frame) -> list[KnownUser]:
        """Those whose face a detector of faces finds; who is looked at in turn is whose skin does
        not tell yet."""
        if self._skin is None:
            return []
        asked = [
            user
            for user in self._roll.known
            if user.seen_s == frame.timestamp_s and not user.face.is_known
        ]
        told = self._skin.check_faces_in_turn(frame, [user.head_camera for user in asked])
        return [asked[index] for index, is_frontal in told if is_frontal]

    def _users(self, scene: Scene, tracked: Sequence[Person]) -> tuple[list[User], list[Refusal]]:
        """What the tracker is told, and who is in doubt; loose limbs are not remembered."""
        roll, frame = self._roll, scene.cloud.frame
        is_pause = roll.elapsed_s(scene) > PAUSE_S
        joints = {person.id: person.joints_camera for person in tracked if not is_pause}
        masks = self._split(scene, [joints.get(user.id) for user in roll.known])
        roll.remember(scene, masks)
        frontal = self._frontal(frame)
        users: list[User] = []
        suspects: list[Refusal] = []
        for user, is_users in zip(roll.known, masks, strict=True):
            is_seen = user.seen_s == scene.time_s
            if is_seen:
                user.height.add(measured_height(scene, user.head_camera, is_users), scene.time_s)
            if user.is_suspect:
                head = HeadCandidate(user.head_camera, user.confidence_now)
                suspects.append(Refusal(head, UNMOVED))
                continue
            skin = skin_share(self.skin_detections, frame, user.head_camera) if is_seen else None
            users.append(
                User(
                    user.id,
                    user.head_camera.copy(),
                    is_seen,
                    user.height.height_m,
                    user.height.is_measured,
                    full_pixels(scene, is_users),
                    user.face.update(skin, user in frontal, scene.time_s),
                )
            )
        return users, suspects
