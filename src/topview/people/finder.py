"""From depth frames to users: who is there, where the head is, and which points are whose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.detect.cloud import Cloud
from topview.detect.detectors import SkinHeads, head_detector
from topview.detect.faces_and_hands import Sight
from topview.detect.following import HeadView, follow_head
from topview.detect.heads import (
    HEAD_HALF_HEIGHT_M,
    HeadCandidate,
    HeadDetector,
    Hints,
    refine_center,
)
from topview.people.background import Background
from topview.people.colors import hands_in, skin_share
from topview.people.doubts import (
    BRIEFLY_S,
    COVERED,
    PROVEN_M,
    is_anothers,
    is_undoubted,
    may_be_an_arm,
    slips,
)
from topview.people.floor import FloorPlane, FloorTracker
from topview.people.height import PRIOR_HEIGHT_M, measured_height
from topview.people.identity import KnownUser, assign
from topview.people.looks import tell_apart
from topview.people.pieces import Pieces
from topview.people.present import SAME_HEAD_M, SUSPECT, Present, Refusal, reached
from topview.people.scene import Scene
from topview.people.segmentation import Memory, body_distance, full_pixels, split_users
from topview.people.settings import PeopleSettings
from topview.people.users import HandCandidate, User
from topview.people.validation import HALF_HIDDEN, hidden_outline, is_doubtful, looks_like_person
from topview.records import Frame, InputError, JointState, Person
from topview.timing import StageClock

__all__ = ["PeopleFinder", "PeopleSettings"]

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Ours: a head that scores this (`KnownUser.score`) is not doubted.
SURE_SCORE = 0.75
# Ours: a tracked body whose head is further from the expected one has been lost itself.
STRAYED_M = 0.5
# Ours: a tracked body tells where its hidden head is if this share of its joints is seen.
KNOWING_SHARE = 0.3
HEAD_JOINT = JOINT_NAMES.index("head")
# Ours: a limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S = 1.5
# Ours: a head that is in view, but is not made out, of one who stoops say, is the highest of the
# body so near to where it was seen last, from above.
STOOPED, STOOPING_M = 0.65, 0.25
# Ours: of one who was hidden for longer the head's looks of then are no more followed.
FOLLOWED_S = 0.5
# Ours: what may be furniture and has not moved for so long is.
DOUBTED_S = 5.0
# Ours: somebody who was in no doubt, but is since, and has not moved in so many frames, is in doubt.
PROBATION_FRAMES = 45
MOVED_FRAMES = 3
# Ours: how much more confidence makes a head out of something else on a body.
MUCH_MORE = 0.12
# Ours: a head is this near to the height that its stature gives, and what is so much lower was not.
UPRIGHT_M, SUNK_M = 0.1, 0.25
# Ours: a head that is not where it was expected may be so much lower.
LOWER_M = 0.3
# Why heads are refused, besides what their bodies lack.
OWN_HEAD, NEW, UNMOVED = "may be a user's own", "just come", "has not moved, as furniture"


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """All that is found in one frame, with what it is found by.

    Attributes:
        scene: what the depth shows.
        sight: what the colours tell, None where they are not looked at.
        users: nearest first.
        refusals: heads that have not been made users, and why.
    """

    scene: Scene
    sight: Sight | None
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
        self._refusals: list[Refusal] = []
        self._detector = detector or head_detector(self.settings.detector, self.clock)
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

    @property
    def sight(self) -> Sight | None:
        """What the last frame's colours told, None where they are not looked at."""
        return self._detector.sight if isinstance(self._detector, SkinHeads) else None

    @property
    def hands(self) -> tuple[HandCandidate, ...]:
        """The hands that the last frame's colours show, whosesoever they are."""
        return hands_in(self.sight)

    def update(self, frame: Frame, tracked: Sequence[Person] = ()) -> list[User]:
        """The people in the next frame, nearest first; `tracked` as they were in the last one."""
        time_s = frame.timestamp_s
        with self.clock.stage("scene"):
            scene = self._look(frame)
        with self.clock.stage("heads"):
            heads = self._detect(scene, time_s)
        with self.clock.stage("users"):
            self._heed(tracked)
            heads, bodies = self._find_again(scene, heads, time_s)
            tell_apart(scene, self._known, time_s, self.sight is not None)
            heads = self._correct(scene, heads, bodies, time_s)
            self._doubt(scene, bodies, time_s)
            self._welcome(scene, heads, bodies, time_s)
            self._is_first_frame = False
            users = self._users(scene, bodies, tracked, time_s)
            self._dismiss(scene, time_s)
        self._learn_room(scene, users)
        self.found = Found(scene, self.sight, tuple(users), tuple(self._refusals))
        self.clock.end_frame()
        return users

    def _look(self, frame: Frame) -> Scene:
        cloud = Cloud.from_frame(frame)
        is_background = self._background.is_seen_in(cloud.depth_m)
        return Scene.of(cloud, self._floor.update(cloud), is_background, self.settings.scene)

    def _heed(self, tracked: Sequence[Person]) -> None:
        """Where a head was not seen in the last frame, a body of which enough was seen knows
        better."""
        known = {user.id: user for user in self._known if user.confidence_now == 0.0}
        for person in tracked:
            user = known.get(person.id)
            given = person.joint_state[person.joint_state != JointState.ABSENT]
            seen = (given == JointState.VISIBLE).mean()
            if user is None or seen < KNOWING_SHARE:
                continue
            head_camera = person.joints_camera[HEAD_JOINT]
            if np.linalg.norm(head_camera - user.head_camera) < STRAYED_M:
                user.head_camera = np.array(head_camera)

    def _detect(self, scene: Scene, time_s: float) -> list[HeadCandidate]:
        """Detected heads, centred on their points, best first; those whose torso has no reading
        come last, if they stand on legs."""
        needs_color = self.settings.detector in ("skin", "cascade")
        if self._is_first_frame and needs_color and scene.cloud.frame.color is None:
            raise InputError(
                f"detector is {self.settings.detector}, but the recording has no colour; "
                'it must be "auto" or "depth"'
            )
        expected = [user.predicted(time_s) for user in self._known]
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

    def _find_again(
        self, scene: Scene, heads: list[HeadCandidate], time_s: float
    ) -> tuple[list[HeadCandidate], list[Distance]]:
        """Tell every known user where the head is now; gives the detected heads that nobody took,
        and the users' bodies."""
        known, options = self._known, list(heads)
        scores = [user.scores(heads, scene.up_camera, time_s) for user in known]
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
        table = np.array(scores).reshape(len(known), len(options))
        taken: set[int] = set()
        bodies: dict[int, Distance] = {}
        present = Present()
        claims: list[Vector] = []  # places of heads that those who were seen of late did not take
        # Whoever is hidden takes nobody's head who is not; who is in doubt comes last.
        ranks = np.array([self._rank(user, time_s) for user in known])
        turns = [ranks == rank for rank in range(4)]
        for turn in turns:
            near = [
                any(
                    np.linalg.norm(head.center_camera - place) < SAME_HEAD_M
                    for place in (*claims, *present.heads)
                )
                for head in options
            ]
            now = np.where(turn[:, None] & ~np.array(near, np.bool_), table, -np.inf)
            matches = assign(now)
            for index in sorted(
                np.flatnonzero(turn), key=lambda i: -now[i, matches[i]] if i in matches else 0.0
            ):
                user = known[index]
                head = options[matches[index]] if index in matches else None
                if head is None or not self._continues(scene, user, head, present, time_s):
                    if time_s - user.seen_s < FOLLOWED_S:
                        claims.append(user.predicted(time_s))
                    continue
                user.see(head, HeadView.of(scene.cloud, head.center_camera), time_s)
                bodies[index] = self._body_of(scene, user)
                present.add(user.head_camera, bodies[index])
                taken.add(matches[index])
        for index, user in enumerate(known):
            if index not in bodies:
                way_on = self._way_on(scene, user, time_s)
                user.miss(time_s, scene.up_camera, way_on)
                bodies[index] = self._body_of(scene, user)
                stoops = scene.height_of(user.head_camera) < STOOPED * user.height.height_m
                if (
                    stoops
                    and way_on is None
                    and time_s - user.seen_s > BRIEFLY_S
                    and scene.covered_share(user.head_camera) < COVERED
                ):
                    top = scene.top_near(bodies[index] < np.inf, user.head_camera, STOOPING_M)
                    user.head_camera = user.head_camera if top is None else top
        left = [head for i, head in enumerate(heads) if i not in taken]
        return left, [bodies[index] for index in range(len(known))]

    def _rank(self, user: KnownUser, time_s: float) -> int:
        if user.is_suspect:
            return 3
        if user.confidence_now > 0.0:
            return 0
        return 1 if time_s - user.seen_s < FOLLOWED_S else 2

    def _way_on(self, scene: Scene, user: KnownUser, time_s: float) -> Vector | None:
        """[3] how far on from the place where a head is expected, but was not found, something
        hides it; None where it must be in view."""
        place = user.predicted(time_s)
        if scene.is_hidden_at(place) or scene.is_out(place, self.settings.border_m):
            return np.zeros(3)
        return scene.way_to_hidden(place, user.velocity) if scene.is_empty_at(place) else None

    def _continues(
        self,
        scene: Scene,
        user: KnownUser,
        head: HeadCandidate,
        present: Present,
        time_s: float,
    ) -> bool:
        """Whether the best head for a user is the user's."""
        if present.owns(scene, head, self.settings.new_confidence):
            return False
        if time_s - user.seen_s > BRIEFLY_S and (
            present.person_under(scene, head, self.settings) is None
        ):
            return False
        return not slips(scene, user, head, time_s)

    def _body_of(self, scene: Scene, user: KnownUser) -> Distance:
        is_seen = user.seen_s == scene.cloud.frame.timestamp_s
        is_hidden = not is_seen and scene.is_hidden_at(user.head_camera)
        return body_distance(
            scene,
            user.head_camera,
            max(user.height.height_m, PRIOR_HEIGHT_M),
            self.settings.segmentation,
            self._memory(scene, user, FADING_M_PER_S if is_seen else 0.0),
            from_head=is_seen or is_hidden,
        )

    def _memory(self, scene: Scene, user: KnownUser, fading_m_per_s: float) -> Memory | None:
        """The body in the last frame, which seems further away by `fading_m_per_s`: a limb whose
        connection with the body is hidden is out of reach after a while."""
        if user.body_m is None or self._last_depth_m is None:
            return None
        elapsed_s = scene.cloud.frame.timestamp_s - self._last_s
        return Memory(user.body_m, self._last_depth_m, fading_m_per_s * elapsed_s)

    def _correct(
        self, scene: Scene, heads: list[HeadCandidate], bodies: list[Distance], time_s: float
    ) -> list[HeadCandidate]:
        """Where something higher on a user's body looks much more like a head, for several frames,
        than what has been followed: that is the head; somewhat lower too, where the expected place
        is in view and the head is not there. Gives the heads that are left."""
        left = list(heads)
        for index, user in enumerate(self._known):
            sure = [
                (other.head_camera, body)
                for other, body in zip(self._known, bodies, strict=True)
                if other is not user and not other.is_suspect
            ]
            # Heads may be near to each other in a hug, but are no two heads of one.
            others = Present(bodies=[body for _, body in sure])
            is_elsewhere = (
                user.confidence_now == 0.0 and scene.covered_share(user.head_camera) <= COVERED
            )
            lower_m = LOWER_M if is_elsewhere else 0.0
            rivals = [
                head
                for head in left
                if self._is_better(scene, user, head)
                and (head.center_camera - user.head_camera) @ scene.up_camera > -lower_m
                and reached(scene, head.center_camera, bodies[index]) < np.inf
                and all(
                    np.linalg.norm(head.center_camera - other) > SAME_HEAD_M for other, _ in sure
                )
                and others.person_under(scene, head, self.settings) is not None
            ]
            user.rival_frames = user.rival_frames + 1 if rivals else 0
            if user.rival_frames >= self.settings.frames_until_new:
                user.jump(rivals[0], HeadView.of(scene.cloud, rivals[0].center_camera), time_s)
                bodies[index] = self._body_of(scene, user)
                left.remove(rivals[0])
        return left

    def _is_better(self, scene: Scene, user: KnownUser, head: HeadCandidate) -> bool:
        """Whether a head looks much more like a user's than what is followed; not quite as much if
        it is where that of one of this stature would be, and what is followed is far below."""
        up_m = float((head.center_camera - user.head_camera) @ scene.up_camera)
        off_m = scene.height_of(head.center_camera) + HEAD_HALF_HEIGHT_M - user.height.height_m
        if user.height.is_measured and up_m > SUNK_M and abs(off_m) < UPRIGHT_M:
            return head.confidence > SUSPECT
        return head.confidence > max(user.confidence_now + MUCH_MORE, self.settings.new_confidence)

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
        present = Present([user.head_camera for user in self._known], list(bodies))
        # What is hardly like a head takes nobody's place.
        for head in sorted(heads, key=lambda head: head.by_shape < settings.new_confidence):
            center = head.center_camera
            if any(reached(scene, center, body) < np.inf for body in doubtful):
                present.refusals.append(Refusal(head, OWN_HEAD))  # see `_correct`
                continue
            body = present.person_under(scene, head, settings)
            if body is None:
                continue
            own = present.left_of(body)
            present.add(center, body)
            user = self._seen_before(
                head, HeadView.of(scene.cloud, center), scene.up_camera, time_s
            )
            is_sudden = self._is_first_frame and hidden_outline(scene, own) < HALF_HIDDEN
            user.doubted_frames += head.by_shape < settings.new_confidence or is_doubtful(
                scene, head, own, settings.limits, 2 if is_sudden else 1
            )
            if self._is_first_frame or user.frames_seen >= settings.frames_until_new:
                self._known.append(user)
                bodies.append(self._take_out(scene, head, body, own))
                user.watch(scene.cloud.depth_m, np.isfinite(own), time_s)
                user.is_suspect = 2 * user.doubted_frames > user.frames_seen
                if not user.is_suspect:
                    self._name(user)
            else:
                waiting.append(user)
                present.refusals.append(Refusal(head, NEW))
        self._waiting, self._refusals = waiting, present.refusals

    def _name(self, user: KnownUser) -> None:
        user.is_suspect = False
        if not user.id:
            user.id = self._next_id
            self._next_id += 1

    def _doubt(self, scene: Scene, bodies: list[Distance], time_s: float) -> None:
        """Those who may be furniture are people once they move; else they come to be the room's."""
        depth_m = scene.cloud.depth_m
        for user, body in zip(list(self._known), list(bodies), strict=True):
            if user.stillness is None:
                continue
            index = self._known.index(user)
            if user.is_suspect and is_anothers(scene, user, self._known, bodies):
                del self._known[index], bodies[index]
                continue
            is_like = user.seen_s == time_s and is_undoubted(
                scene, user, self._known, bodies, self.settings
            )
            user.moved_frames += user.stillness.is_broken_in(depth_m)
            user.has_moved = user.moved_frames >= MOVED_FRAMES
            if not user.is_suspect:
                is_far = np.linalg.norm(user.head_camera - user.first_camera) > PROVEN_M
                if is_like or (is_far and user.seen_s == time_s):
                    user.stillness = None
                elif user.stillness.telling_frames > PROBATION_FRAMES:
                    user.is_suspect = not user.has_moved
                    user.watch(depth_m, np.isfinite(body), time_s)
                continue
            is_somebody = (user.has_moved or is_like) and not may_be_an_arm(
                scene, user, self._known, bodies
            )
            if user.seen_s == time_s and is_somebody:
                self._name(user)
                user.watch(depth_m, np.isfinite(body), time_s)
            elif time_s - user.watched_s > DOUBTED_S:
                self._background.learn(depth_m, np.isfinite(body))
                del self._known[index], bodies[index]
            elif not user.has_moved and user.stillness.has_grown(np.isfinite(body)):
                user.watch(depth_m, np.isfinite(body), user.watched_s)

    def _take_out(
        self, scene: Scene, head: HeadCandidate, body: Distance, own: Distance
    ) -> Distance:
        """Take a new body out of the background; `own` is what of it is nobody else's.

        If it was only believed for its head, as it hangs together with a wall, say, the rest of it
        is held for the room's until it moves, save for what stands right under the head.
        """
        is_body = np.isfinite(body)
        unsure = HeadCandidate(head.center_camera, 0.0)
        if not head.torso_is_unread and not looks_like_person(
            scene, unsure, own, self.settings.limits
        ):
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
        """Forget who has been away for too long: soon if he went out of the picture, but not
        while he stands so near that only the head is out of it."""
        settings = self.settings
        staying: list[KnownUser] = []
        for user in self._known:
            has_body = user.body_m is not None and bool(np.isfinite(user.body_m).any())
            is_out = scene.is_out(user.head_camera, settings.border_m)
            grace_s = settings.out_s if is_out and not has_body else settings.grace_s
            stands_near = has_body and scene.is_above(user.head_camera)
            if stands_near or time_s - user.seen_s <= grace_s:
                staying.append(user)
        self._known = staying

    def _with_pieces(self, scene: Scene, bodies: list[Distance], time_s: float) -> list[Distance]:
        """The bodies with the limbs that are cut off from them; the rest is learnt as the room's,
        if it is steady."""
        is_somebodys = np.zeros(scene.cloud.depth_m.shape, np.bool_)
        for body in bodies:
            is_somebodys |= np.isfinite(body)
        pieces = Pieces.of(scene, is_somebodys, self.settings.pieces)
        whole = [
            pieces.joined_to(body, user.head_camera, max(user.height.height_m, PRIOR_HEIGHT_M))
            if user.seen_s == time_s
            else body
            for user, body in zip(self._known, bodies, strict=True)
        ]
        for body in whole:
            is_somebodys |= np.isfinite(body)
        self._background.update(scene.cloud.depth_m, is_somebodys)
        return whole

    def _learn_room(self, scene: Scene, users: Sequence[User]) -> None:
        """Tell the eye for colours what is nobody's."""
        if not isinstance(self._detector, SkinHeads) or not self._detector.learns_room:
            return
        is_somebodys = np.zeros(scene.cloud.frame.depth_m.shape, np.bool_)
        for user in users:
            is_somebodys.ravel()[user.pixels] = True
        self._detector.learn_room(is_somebodys)

    def _for_somebody_first(self, bodies: list[Distance]) -> list[Distance]:
        """The bodies; of those who may be furniture, or an arm, only what nobody else reaches."""
        somebodys = [
            body for user, body in zip(self._known, bodies, strict=True) if not user.is_suspect
        ]
        if not somebodys:
            return bodies
        is_somebodys = np.isfinite(np.minimum.reduce(somebodys))
        return [
            body if not user.is_suspect else np.where(is_somebodys, np.float32(np.inf), body)
            for user, body in zip(self._known, bodies, strict=True)
        ]

    def _frontal(self, frame: Frame) -> KnownUser | None:
        """One whose face a detector of faces finds; those are looked at in turn whose skin does not
        tell yet."""
        if not isinstance(self._detector, SkinHeads):
            return None
        asked = [
            user
            for user in self._known
            if user.seen_s == frame.timestamp_s and not user.face.is_known
        ]
        told = self._detector.look_round(frame, [user.head_camera for user in asked])
        return asked[told[0]] if told is not None and told[1] else None

    def _users(
        self,
        scene: Scene,
        bodies: list[Distance],
        tracked: Sequence[Person],
        time_s: float,
    ) -> list[User]:
        """What the tracker is told; loose limbs (`whole`, not `bodies`) are not remembered."""
        whole = self._with_pieces(scene, bodies, time_s)
        joints = {person.id: person.joints_camera for person in tracked}
        masks = split_users(
            scene,
            self._for_somebody_first(whole),
            [joints.get(user.id) for user in self._known],
            self.settings.segmentation,
        )
        for user, body, is_users in zip(self._known, bodies, masks, strict=True):
            user.body_m = np.where(is_users, body, np.float32(np.inf))
        self._last_depth_m, self._last_s = scene.cloud.depth_m, time_s
        users: list[User] = []
        frontal = self._frontal(scene.cloud.frame)
        for user, is_users in zip(self._known, masks, strict=True):
            if user.is_suspect:
                suspect = HeadCandidate(user.head_camera, user.confidence_now)
                self._refusals.append(Refusal(suspect, UNMOVED))
                continue
            is_seen = user.seen_s == time_s
            skin: float | None = None
            if is_seen:
                user.height.add(measured_height(scene, user.head_camera, is_users))
                skin = skin_share(self.sight, scene.cloud.frame, user.head_camera)
            users.append(
                User(
                    user.id,
                    user.head_camera.copy(),
                    is_seen,
                    user.height.height_m,
                    user.height.is_measured,
                    full_pixels(scene, is_users),
                    user.face.update(skin, user is frontal, time_s),
                )
            )
        return sorted(users, key=lambda user: (float(user.head_camera[2]), user.id))
