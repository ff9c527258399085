"""From depth frames to users: who is there, where the head is, and which points are whose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.detect.cloud import Cloud
from topview.detect.following import HeadView, follow_head
from topview.detect.heads import (
    HEAD_RADIUS_M,
    DepthHeadDetector,
    HeadCandidate,
    HeadDetector,
    head_evidence,
    refine_center,
)
from topview.people.background import Background
from topview.people.floor import FloorPlane, FloorSettings, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M, measured_height
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
# Ours: a tracked body whose head is further from the expected one has been lost itself.
STRAYED_M = 0.5
HEAD_JOINT = JOINT_NAMES.index("head")
# Ours: a limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S = 1.5
# Ours: closer together are no two heads' centres.
SAME_HEAD_M = 0.2
# Ours: one who was hidden for longer must look like a person again; and for longer yet, the head's
# looks of then are no more followed.
BRIEFLY_S = 0.15
FOLLOWED_S = 0.5
# Ours: how much more confidence makes a head out of something else on a body.
MUCH_MORE = 0.12


@dataclass(frozen=True, slots=True)
class PeopleSettings:
    """How people are found.

    Attributes:
        new_confidence: a head's, from which it makes a user: at once in the very first frame, else
            once it was seen often enough.
        upright_confidence: that a new head stands upright; furniture often seems to lean.
        frames_until_new: consecutive frames in which a new head must be seen.
        least_apart_m: two heads, seen from above; a shoulder is nearer to its own head.
        grace_s: how long a user who is hidden is waited for.
        out_s: the same for one who went out of the picture.
        border_m: a head this near to the border may have gone out of the picture.
        floor: which planes may be a floor.
        segmentation: which points are whose.
        limits: what a person measures.
    """

    new_confidence: float = 0.75
    upright_confidence: float = 0.55
    frames_until_new: int = 3
    least_apart_m: float = 0.33
    grace_s: float = 5.0
    out_s: float = 0.5
    border_m: float = 0.15
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
        self._background = Background()
        self._known: list[KnownUser] = []
        self._waiting: list[KnownUser] = []
        self._next_id = 1
        self._is_first_frame = True
        self._last_depth_m: NDArray[np.float32] | None = None
        self._last_s = 0.0

    @property
    def floor(self) -> FloorPlane | None:
        """The floor as far as it is known, None where it was not in view."""
        return self._floor.plane

    def update(self, frame: Frame, tracked: Sequence[Person] = ()) -> list[User]:
        """The people in the next frame, nearest first; `tracked` as they were in the last one."""
        time_s = frame.timestamp_s
        cloud = Cloud.from_frame(frame)
        is_background = self._background.is_seen_in(cloud.depth_m)
        floor = self._floor.update(cloud)
        scene = Scene.of(cloud, floor, is_background, self.settings.segmentation)
        joints = {person.id: person.joints_camera for person in tracked}
        self._heed(joints)
        heads = self._detect(scene)
        heads, bodies = self._find_again(scene, heads, time_s)
        heads = self._correct(scene, heads, bodies, time_s)
        self._welcome(scene, heads, bodies, time_s)
        self._is_first_frame = False
        users = self._users(scene, bodies, joints, time_s)
        is_somebodys = np.zeros(cloud.depth_m.shape, np.bool_)
        for body in bodies:
            is_somebodys |= np.isfinite(body)
        self._background.update(cloud.depth_m, is_somebodys)
        self._dismiss(scene, time_s)
        return users

    def _heed(self, joints: dict[int, Vector]) -> None:
        """Where a head was not seen in the last frame, the tracked body knows better."""
        for user in self._known:
            if user.confidence_now == 0.0 and user.id in joints:
                head_camera = joints[user.id][HEAD_JOINT]
                if np.linalg.norm(head_camera - user.head_camera) < STRAYED_M:
                    user.head_camera = np.array(head_camera)

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
        scores = [[user.score(head, scene.up_camera, time_s) for head in heads] for user in known]
        for index, user in enumerate(known):
            is_lost = time_s - user.seen_s > FOLLOWED_S
            if is_lost or max(scores[index], default=-np.inf) > SURE_SCORE:
                continue
            head = follow_head(scene.cloud, user.view, user.predicted(time_s), scene.up_camera)
            if head is not None:
                options.append(head)
                for other, row in enumerate(scores):
                    row.append(
                        user.score(head, scene.up_camera, time_s) if other == index else -np.inf
                    )
        for row in scores:
            row.extend([-np.inf] * (len(options) - len(row)))
        matches = assign(np.array(scores))

        bodies: dict[int, Distance] = {}
        for index in sorted(matches, key=lambda i: -scores[i][matches[i]]):
            user, head = known[index], options[matches[index]]
            others = list(bodies.values())
            other_heads = [known[other].head_camera for other in bodies]
            if self._is_taken(scene, head, others, other_heads):
                continue
            if time_s - user.seen_s > BRIEFLY_S and (
                self._person_under(scene, head, others, other_heads) is None
            ):
                continue
            user.see(head, HeadView.of(scene.cloud, head.center_camera), time_s)
            bodies[index] = self._body_of(scene, user)
        for index, user in enumerate(known):
            if index not in bodies:
                user.miss(time_s, is_empty=_is_empty(scene, user.predicted(time_s)))
                bodies[index] = self._body_of(scene, user)
        taken = {matches[index] for index in matches if known[index].seen_s == time_s}
        left = [head for i, head in enumerate(heads) if i not in taken]
        return left, [bodies[index] for index in range(len(known))]

    def _is_taken(
        self,
        scene: Scene,
        head: HeadCandidate,
        others: list[Distance],
        other_heads: list[Vector],
    ) -> bool:
        """Whether a head is another's head already, or the shoulder of one who stands in front."""
        center = head.center_camera
        if any(np.linalg.norm(center - other) < SAME_HEAD_M for other in other_heads):
            return True
        return head.confidence < self.settings.new_confidence and any(
            _reached(scene, center, body) < OWN_HEAD_M for body in others
        )

    def _person_under(
        self,
        scene: Scene,
        head: HeadCandidate,
        others: list[Distance],
        other_heads: list[Vector],
    ) -> Distance | None:
        """The body that a new head stands over, if what of it is nobody else's measures like a
        person's and the head is far enough from other heads."""
        settings = self.settings
        center = head.center_camera
        if head.confidence < settings.new_confidence or any(
            np.linalg.norm(scene.overview_of(center - other)) < settings.least_apart_m
            for other in other_heads
        ):
            return None
        upright = head_evidence(scene.cloud, center[None], scene.up_camera).confidence[0]
        if upright < settings.upright_confidence:
            return None
        body = body_distance(scene, center, PRIOR_HEIGHT_M, settings.segmentation)
        own = np.where(np.minimum.reduce([body, *others]) < body, np.float32(np.inf), body)
        return body if looks_like_person(scene, head, own, settings.limits) else None

    def _body_of(self, scene: Scene, user: KnownUser) -> Distance:
        is_seen = user.seen_s == scene.cloud.frame.timestamp_s
        is_hidden = not is_seen and _is_hidden(scene, user.head_camera)
        return body_distance(
            scene,
            user.head_camera,
            max(user.height.height_m, PRIOR_HEIGHT_M),
            self.settings.segmentation,
            self._remembered(scene, user, FADING_M_PER_S if is_seen else 0.0),
            from_head=is_seen or is_hidden,
        )

    def _remembered(self, scene: Scene, user: KnownUser, fading_m_per_s: float) -> Distance | None:
        """[h, w] the distances of the last frame where the depth has stayed.

        They grow by `fading_m_per_s`: a limb whose connection with the body is hidden is out of
        reach after a while.
        """
        if user.body_m is None or self._last_depth_m is None:
            return None
        is_body = np.isfinite(user.body_m)
        depth_m, last_m = scene.cloud.depth_m[is_body], self._last_depth_m[is_body]
        stays = np.abs(depth_m - last_m) < JUMP_M + JUMP_PER_SQUARE_M * depth_m**2
        faded_m = fading_m_per_s * (scene.cloud.frame.timestamp_s - self._last_s)
        remembered_m = np.full_like(user.body_m, np.inf)
        remembered_m[is_body] = np.where(stays, user.body_m[is_body] + faded_m, np.inf)
        return remembered_m

    def _correct(
        self, scene: Scene, heads: list[HeadCandidate], bodies: list[Distance], time_s: float
    ) -> list[HeadCandidate]:
        """Where something higher on a user's body looks much more like a head, for several frames,
        than what has been followed: that is the head. Gives the heads that are left."""
        left = list(heads)
        for index, user in enumerate(self._known):
            others = [body for i, body in enumerate(bodies) if i != index]
            other_heads = [u.head_camera for i, u in enumerate(self._known) if i != index]
            rivals = [
                head
                for head in left
                if head.confidence
                > max(user.confidence_now + MUCH_MORE, self.settings.new_confidence)
                and (head.center_camera - user.head_camera) @ scene.up_camera > 0.0
                and _reached(scene, head.center_camera, bodies[index]) < np.inf
                and self._person_under(scene, head, others, other_heads) is not None
            ]
            user.rival_frames = user.rival_frames + 1 if rivals else 0
            if user.rival_frames >= self.settings.frames_until_new:
                user.jump(rivals[0], HeadView.of(scene.cloud, rivals[0].center_camera), time_s)
                bodies[index] = self._body_of(scene, user)
                left.remove(rivals[0])
        return left

    def _welcome(
        self, scene: Scene, heads: list[HeadCandidate], bodies: list[Distance], time_s: float
    ) -> None:
        """Make users of new heads that stand over a person's body, once they are sure; their
        bodies are added to `bodies`."""
        settings = self.settings
        doubtful = [
            body
            for user, body in zip(self._known, bodies, strict=True)
            if user.confidence_now < settings.new_confidence
        ]
        waiting: list[KnownUser] = []
        others = list(bodies)
        other_heads = [user.head_camera for user in self._known]
        for head in heads:
            center = head.center_camera
            if any(_reached(scene, center, body) < np.inf for body in doubtful):
                continue  # It may be that user's own head, see `_correct`.
            body = self._person_under(scene, head, others, other_heads)
            if body is None:
                continue
            others.append(body)
            other_heads.append(center)
            user = self._seen_before(
                head, HeadView.of(scene.cloud, center), scene.up_camera, time_s
            )
            if self._is_first_frame or user.frames_seen >= settings.frames_until_new:
                user.id = self._next_id
                self._next_id += 1
                self._known.append(user)
                bodies.append(self._take_out(scene, head, body, others[:-1]))
            else:
                waiting.append(user)
        self._waiting = waiting

    def _take_out(
        self, scene: Scene, head: HeadCandidate, body: Distance, others: list[Distance]
    ) -> Distance:
        """Take a new body out of the background.

        If it was only believed for its head, as it hangs together with a wall, say, the rest of it
        is held for the room's until it moves, save for what stands right under the head.
        """
        is_body = np.isfinite(body)
        unsure = HeadCandidate(head.center_camera, 0.0)
        own = np.where(np.minimum.reduce([body, *others]) < body, np.float32(np.inf), body)
        if not looks_like_person(scene, unsure, own, self.settings.limits):
            reach_m = self.settings.segmentation.core_radius * PRIOR_HEIGHT_M
            is_rest = is_body & ~scene.is_under(head.center_camera, reach_m)
            self._background.learn(scene.cloud.depth_m, is_rest)
            is_body &= ~is_rest
        self._background.forget(is_body)
        return np.where(is_body, body, np.float32(np.inf))

    def _seen_before(
        self, head: HeadCandidate, view: HeadView, up_camera: Vector, time_s: float
    ) -> KnownUser:
        for user in self._waiting:
            if user.score(head, up_camera, time_s) > -np.inf:
                self._waiting.remove(user)
                user.see(head, view, time_s)
                return user
        return KnownUser(0, head, view, time_s)

    def _dismiss(self, scene: Scene, time_s: float) -> None:
        """Forget who has been away for too long: soon if he went out of the picture."""
        settings = self.settings
        staying: list[KnownUser] = []
        for user in self._known:
            away_s = time_s - user.seen_s
            is_out = scene.is_out(user.head_camera, settings.border_m)
            if is_out and user.body_m is not None and np.isfinite(user.body_m).any():
                is_out = False
            if away_s <= (settings.out_s if is_out else settings.grace_s):
                staying.append(user)
        self._known = staying

    def _users(
        self, scene: Scene, bodies: list[Distance], joints: dict[int, Vector], time_s: float
    ) -> list[User]:
        masks = split_users(
            scene,
            bodies,
            [joints.get(user.id) for user in self._known],
            self.settings.segmentation,
        )
        for user, body, is_users in zip(self._known, bodies, masks, strict=True):
            user.body_m = np.where(is_users, body, np.float32(np.inf))
        self._last_depth_m, self._last_s = scene.cloud.depth_m, time_s
        users: list[User] = []
        for user, is_users in zip(self._known, masks, strict=True):
            is_seen = user.seen_s == time_s
            if is_seen:
                user.height.add(measured_height(scene, user.head_camera, is_users))
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


def _is_empty(scene: Scene, point_camera: Vector) -> bool:
    """Whether a point is seen to be in free space."""
    depth_m, in_view = scene.cloud.lookup(point_camera)
    return bool(in_view and (depth_m == 0.0 or depth_m > point_camera[2] + 2 * HEAD_RADIUS_M))


def _is_hidden(scene: Scene, point_camera: Vector) -> bool:
    """Whether something nearer hides a point."""
    depth_m, in_view = scene.cloud.lookup(point_camera)
    return bool(in_view and 0.0 < depth_m < point_camera[2] - 2 * HEAD_RADIUS_M)


def _reached(scene: Scene, point_camera: Vector, body: Distance) -> float:
    """How far over the surface what is seen at a point is from a body's head."""
    row, column, in_view = scene.cloud.pixel_of(point_camera)
    return float(body[row, column]) if in_view else np.inf
