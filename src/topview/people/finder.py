"""From depth frames to users: who is there, where the head is, and which points are whose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.following import HeadView, follow_head
from topview.detect.heads import (
    HEAD_HALF_HEIGHT_M,
    DepthHeadDetector,
    HeadCandidate,
    HeadDetector,
    refine_center,
)
from topview.people.floor import FloorSettings, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.identity import KnownUser, assign
from topview.people.segmentation import (
    JUMP_M,
    JUMP_PER_SQUARE_M,
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
Distance = NDArray[np.float32]

# Ours: a head that scores this (`KnownUser.score`) is not doubted.
SURE_SCORE = 0.75
# Ours: what is this near to somebody's head over the surface is that person's, if it is not
# clearly another head.
OWN_HEAD_M = 0.4
# Ours: a limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S = 1.5


@dataclass(frozen=True, slots=True)
class PeopleSettings:
    """How people are found.

    Attributes:
        first_confidence: a head's, from which it makes a user in the very first frame.
        new_confidence: a head's, from which it makes a user once it was seen often enough.
        frames_until_new: consecutive frames in which a new head must be seen.
        least_apart_m: two heads, seen from above; a shoulder is nearer to its own head.
        grace_s: how long a user who is hidden is waited for.
        floor: which planes may be a floor.
        segmentation: which points are whose.
        limits: what a person measures.
    """

    first_confidence: float = 0.75
    new_confidence: float = 0.65
    frames_until_new: int = 4
    least_apart_m: float = 0.33
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
        self._waiting: list[KnownUser] = []
        self._next_id = 1
        self._is_first_frame = True
        self._last_depth_m: NDArray[np.float32] | None = None
        self._last_s = 0.0

    def update(self, frame: Frame, tracked: Sequence[Person] = ()) -> list[User]:
        """The people in the next frame, nearest first; `tracked` as they were in the last one."""
        time_s = frame.timestamp_s
        cloud = Cloud.from_frame(frame)
        scene = Scene.of(cloud, self._floor.update(cloud), self.settings.segmentation)
        heads = self._detect(scene)
        heads, bodies = self._find_again(scene, heads, time_s)
        heads = self._correct(scene, heads, bodies, time_s)
        self._welcome(scene, heads, bodies, time_s)
        self._is_first_frame = False
        users = self._users(scene, bodies, time_s)
        self._dismiss(time_s)
        return users

    def _detect(self, scene: Scene) -> list[HeadCandidate]:
        """Detected heads, centred on their points, best first."""
        candidates = self._detector.detect(scene.cloud, scene.up_camera)
        centers = [
            refine_center(scene.cloud, candidate.center_camera, scene.up_camera)
            for candidate in candidates
        ]
        return [
            HeadCandidate(center, candidate.confidence)
            for center, candidate in zip(centers, candidates, strict=True)
            if center is not None
        ]

    def _find_again(
        self, scene: Scene, heads: list[HeadCandidate], time_s: float
    ) -> tuple[list[HeadCandidate], list[Distance]]:
        """Tell every known user where the head is now; gives the detected heads that nobody took,
        and the users' bodies."""
        known, options = self._known, list(heads)
        scores = [[user.score(head, time_s) for head in heads] for user in known]
        for index, user in enumerate(known):
            if max(scores[index], default=-np.inf) > SURE_SCORE:
                continue
            head = follow_head(scene.cloud, user.view, user.predicted(time_s), scene.up_camera)
            if head is not None:
                options.append(head)
                for other, row in enumerate(scores):
                    row.append(user.score(head, time_s) if other == index else -np.inf)
        for row in scores:
            row.extend([-np.inf] * (len(options) - len(row)))
        matches = assign(np.array(scores))

        bodies: dict[int, Distance] = {}
        by_score = sorted(matches, key=lambda i: -scores[i][matches[i]])
        for index in by_score:
            user, head = known[index], options[matches[index]]
            if head.confidence < self.settings.first_confidence and any(
                _reached(scene, head.center_camera, body) < OWN_HEAD_M for body in bodies.values()
            ):
                continue  # It is the shoulder of one who stands in front.
            user.see(head, HeadView.of(scene.cloud, head.center_camera), time_s)
            bodies[index] = self._body_of(scene, user)
        for index, user in enumerate(known):
            if index not in bodies:
                user.miss(time_s)
                bodies[index] = self._body_of(scene, user)
        left = [head for i, head in enumerate(heads) if i not in matches.values()]
        return left, [bodies[index] for index in range(len(known))]

    def _body_of(self, scene: Scene, user: KnownUser) -> Distance:
        return body_distance(
            scene,
            user.head_camera,
            max(user.height.height_m, PRIOR_HEIGHT_M),
            scene.is_free_standing,
            self._remembered(scene, user),
            self.settings.segmentation,
        )

    def _remembered(self, scene: Scene, user: KnownUser) -> Distance | None:
        """[h, w] the distances of the last frame where the depth has stayed; they fade."""
        if user.body_m is None or self._last_depth_m is None:
            return None
        depth_m = scene.cloud.depth_m
        stays = np.abs(depth_m - self._last_depth_m) < JUMP_M + JUMP_PER_SQUARE_M * depth_m**2
        elapsed_s = scene.cloud.frame.timestamp_s - self._last_s
        return np.where(stays, user.body_m + np.float32(FADING_M_PER_S * elapsed_s), np.inf)

    def _correct(
        self, scene: Scene, heads: list[HeadCandidate], bodies: list[Distance], time_s: float
    ) -> list[HeadCandidate]:
        """Where something on a user's body looks much more like a head, for several frames, than
        what has been followed: that is the head. The heads that are left."""
        left: list[HeadCandidate] = list(heads)
        for index, user in enumerate(self._known):
            if user.confidence > 0.6:
                user.rival_frames = 0
                continue
            rivals = [
                head
                for head in left
                if head.confidence > max(user.confidence + 0.25, self.settings.first_confidence)
                and scene.height_of(head.center_camera - user.head_camera) > 0.0
                and self._is_head_of(scene, head, bodies[index])
            ]
            user.rival_frames = user.rival_frames + 1 if rivals else 0
            if user.rival_frames >= 2:
                user.jump(rivals[0], HeadView.of(scene.cloud, rivals[0].center_camera), time_s)
                bodies[index] = self._body_of(scene, user)
                left.remove(rivals[0])
        return left

    def _is_head_of(self, scene: Scene, head: HeadCandidate, body: Distance) -> bool:
        """Whether a head lies on a body, and the body seen from there is a person's."""
        if not np.isfinite(_reached(scene, head.center_camera, body)):
            return False
        own = body_distance(
            scene,
            head.center_camera,
            PRIOR_HEIGHT_M,
            scene.is_free_standing,
            None,
            self.settings.segmentation,
        )
        return looks_like_person(scene, head.center_camera, own, self.settings.limits)

    def _welcome(
        self, scene: Scene, heads: list[HeadCandidate], bodies: list[Distance], time_s: float
    ) -> None:
        """Make users of new heads that stand over a person's body, once they are sure; their
        bodies are added to `bodies`."""
        settings = self.settings
        waiting: list[KnownUser] = []
        others = list(bodies)
        other_heads = [user.head_camera for user in self._known]
        for head in heads:
            center = head.center_camera
            is_touching = any(_reached(scene, center, body) < np.inf for body in others)
            least = settings.first_confidence if is_touching else settings.new_confidence
            if head.confidence < least or any(
                scene.aside_m(center, other) < settings.least_apart_m for other in other_heads
            ):
                continue
            body = body_distance(
                scene, center, PRIOR_HEIGHT_M, scene.is_free_standing, None, settings.segmentation
            )
            own = np.where(np.minimum.reduce([body, *others]) < body, np.float32(np.inf), body)
            if not looks_like_person(scene, center, own, settings.limits):
                continue
            others.append(body)
            other_heads.append(center)
            user = self._seen_before(head, HeadView.of(scene.cloud, center), time_s)
            if user.frames_seen >= settings.frames_until_new or (
                self._is_first_frame and head.confidence >= settings.first_confidence
            ):
                user.id = self._next_id
                self._next_id += 1
                self._known.append(user)
                bodies.append(body)
            else:
                waiting.append(user)
        self._waiting = waiting

    def _seen_before(self, head: HeadCandidate, view: HeadView, time_s: float) -> KnownUser:
        for user in self._waiting:
            moved_m = np.linalg.norm(user.predicted(time_s) - head.center_camera)
            if moved_m < user.gate_m(time_s):
                self._waiting.remove(user)
                user.see(head, view, time_s)
                return user
        return KnownUser(0, head, view, time_s)

    def _dismiss(self, time_s: float) -> None:
        self._known = [
            user for user in self._known if time_s - user.seen_s <= self.settings.grace_s
        ]

    def _users(self, scene: Scene, bodies: list[Distance], time_s: float) -> list[User]:
        masks = split_users(bodies, self.settings.segmentation)
        for user, body, is_users in zip(self._known, bodies, masks, strict=True):
            user.body_m = np.where(is_users, body, np.float32(np.inf))
        self._last_depth_m, self._last_s = scene.cloud.depth_m, time_s
        users: list[User] = []
        for user, is_users in zip(self._known, masks, strict=True):
            is_seen = user.seen_s == time_s
            if is_seen and scene.floor is not None:
                user.height.add(scene.height_of(user.head_camera) + HEAD_HALF_HEIGHT_M)
            users.append(
                User(
                    user.id,
                    user.head_camera.copy(),
                    is_seen,
                    user.height.height_m,
                    full_pixels(scene, is_users, self.settings.segmentation),
                )
            )
        return sorted(users, key=lambda user: (float(user.head_camera[2]), user.id))


def _reached(scene: Scene, point_camera: Vector, body: Distance) -> float:
    """How far over the surface what is seen at a point is from a body's head."""
    row, column, in_view = scene.cloud.pixel_of(point_camera)
    return float(body[row, column]) if in_view else np.inf
