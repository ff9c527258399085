"""From depth frames to users: who is there, where the head is, and which points are whose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.heads import (
    HEAD_HALF_HEIGHT_M,
    DepthHeadDetector,
    HeadDetector,
    follow_head,
    refine_center,
)
from topview.people.floor import FloorSettings, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.identity import KnownUser, assign
from topview.people.segmentation import (
    Scene,
    SegmentationSettings,
    body_distance,
    full_pixels,
    split_users,
)
from topview.people.users import User
from topview.people.validation import PersonLimits, looks_like_person
from topview.records import Frame, Person

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class PeopleSettings:
    """How people are found.

    Attributes:
        first_confidence: a head's, from which it makes a user in the very first frame.
        new_confidence: a head's, from which it makes a user once it was seen often enough.
        frames_until_new: consecutive frames in which a new head must be seen.
        grace_s: how long a user who is hidden is waited for.
        floor: which planes may be a floor.
        segmentation: which points are whose.
        limits: what a person measures.
    """

    first_confidence: float = 0.75
    new_confidence: float = 0.65
    frames_until_new: int = 4
    grace_s: float = 5.0
    floor: FloorSettings = field(default_factory=FloorSettings)
    segmentation: SegmentationSettings = field(default_factory=SegmentationSettings)
    limits: PersonLimits = field(default_factory=PersonLimits)


class PeopleFinder:
    """Finds people in one frame after the other, and knows them again."""

    def __init__(
        self, settings: PeopleSettings | None = None, detector: HeadDetector | None = None
    ) -> None:
        self.settings = settings or PeopleSettings()
        self._detector = detector or DepthHeadDetector()
        self._floor = FloorTracker(self.settings.floor)
        self._known: list[KnownUser] = []
        self._maybe: list[KnownUser] = []
        self._next_id = 1
        self._is_first_frame = True

    def update(self, frame: Frame, tracked: Sequence[Person] = ()) -> list[User]:
        """The people in the next frame, nearest first; `tracked` as they were in the last one."""
        time_s = frame.timestamp_s
        cloud = Cloud.from_frame(frame)
        scene = Scene.of(cloud, self._floor.update(cloud), self.settings.segmentation)
        heads = [
            (refine_center(cloud, candidate.center_camera, scene.up_camera), candidate.confidence)
            for candidate in self._detector.detect(cloud, scene.up_camera)
        ]
        heads = [(center, confidence) for center, confidence in heads if center is not None]

        matches = assign(self._known, [center for center, _ in heads], time_s)
        for index, user in enumerate(self._known):
            if index in matches:
                user.see(heads[matches[index]][0], time_s)
            else:
                followed = follow_head(cloud, user.predicted(time_s), scene.up_camera)
                if followed is not None:
                    user.see(followed, time_s)
                else:
                    user.miss(time_s)
        taken = set(matches.values())
        distances = self._body_distances(scene)
        self._welcome(
            scene, [head for i, head in enumerate(heads) if i not in taken], distances, time_s
        )
        self._dismiss(time_s)
        self._is_first_frame = False
        return self._users(scene, time_s)

    def _body_distances(self, scene: Scene) -> list[NDArray[np.float32]]:
        return [
            body_distance(
                scene,
                user.head_camera,
                user.height.height_m,
                scene.is_free_standing,
                None,
                self.settings.segmentation,
            )
            for user in self._known
        ]

    def _welcome(
        self,
        scene: Scene,
        heads: list[tuple[Vector, float]],
        distances: list[NDArray[np.float32]],
        time_s: float,
    ) -> None:
        """Make users of new heads that stand over a person's body, once they are sure."""
        settings = self.settings
        still: list[KnownUser] = []
        bodies = list(distances)
        for center, confidence in heads:
            if confidence < settings.new_confidence:
                continue
            if any(np.linalg.norm(user.head_camera - center) < 0.35 for user in self._known):
                continue
            row, column, in_view = scene.cloud.pixel_of(center)
            if any(np.isfinite(body[row, column]) for body in bodies):
                continue
            body = body_distance(
                scene,
                center,
                PRIOR_HEIGHT_M,
                scene.is_free_standing,
                None,
                settings.segmentation,
            )
            if not (in_view and looks_like_person(scene, center, body, settings.limits)):
                continue
            bodies.append(body)
            user = self._seen_before(center, time_s)
            still.append(user)
            is_sure = user.frames_seen >= settings.frames_until_new or (
                self._is_first_frame and confidence >= settings.first_confidence
            )
            if is_sure:
                still.remove(user)
                user.id = self._next_id
                self._next_id += 1
                self._known.append(user)
        self._maybe = still

    def _seen_before(self, center: Vector, time_s: float) -> KnownUser:
        for user in self._maybe:
            if np.linalg.norm(user.predicted(time_s) - center) < user.gate_m(time_s):
                self._maybe.remove(user)
                user.see(center, time_s)
                return user
        return KnownUser(0, center, time_s)

    def _dismiss(self, time_s: float) -> None:
        self._known = [
            user for user in self._known if time_s - user.seen_s <= self.settings.grace_s
        ]

    def _users(self, scene: Scene, time_s: float) -> list[User]:
        self._known.sort(key=lambda user: (float(user.head_camera[2]), user.id))
        masks = split_users(self._body_distances(scene), self.settings.segmentation)
        users: list[User] = []
        for user, is_users in zip(self._known, masks, strict=True):
            is_seen = user.seen_s == time_s
            if is_seen and scene.floor is not None:
                user.height.add(float(scene.height_of(user.head_camera)) + HEAD_HALF_HEIGHT_M)
            users.append(
                User(
                    user.id,
                    user.head_camera.copy(),
                    is_seen,
                    user.height.height_m,
                    full_pixels(scene, is_users, self.settings.segmentation),
                )
            )
        return users
