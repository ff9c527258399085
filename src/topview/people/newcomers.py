"""New heads become users, once they are sure to be people's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from topview.detect.head_template import HeadTemplate
from topview.detect.heads import HeadCandidate
from topview.people.background import Background
from topview.people.doubts import (
    has_come,
    is_anothers,
    is_proven,
    is_undoubted,
    looks_doubtful,
    may_be_an_arm,
)
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.identity import KnownUser, nearest_m
from topview.people.present import Present, Refusal, reached
from topview.people.roll import Roll
from topview.people.scene import Scene
from topview.people.settings import PeopleSettings
from topview.people.validation import is_doubtful, is_half_hidden, is_torn_out, looks_like_person

Distance = NDArray[np.float32]

# Ours: what may be furniture and has not moved for so long is.
DOUBTED_S = 5.0
# Ours: who was in no doubt at first, but of whom nothing has moved in so many looks, and who is in
# doubt since, is a suspect.
PROBATION_LOOKS = 15.5
# Ours: one who sits quietly has one of the marks of furniture (`is_doubtful`), furniture has more.
DEEP_DOUBT = 2
# Ours: of whoever has somebody so near, limbs may be mixed with his.
MIXED_M = 1.2
# Why heads are refused, besides what their bodies lack.
OWN_HEAD, NEW, UNMOVED = "may be a user's own", "just come", "has not moved, as furniture"


class Newcomers:
    """Makes users of new heads, and keeps an eye on those who may be furniture.

    Attributes:
        refusals: heads of the last frame that have not been made users, and why.
    """

    def __init__(self, settings: PeopleSettings, background: Background) -> None:
        self.refusals: list[Refusal] = []
        self._settings = settings
        self._background = background
        self._waiting: list[KnownUser] = []
        self._next_id = 1
        self._is_first_frame = True

    def judge(self, roll: Roll, scene: Scene) -> None:
        """Those who may be furniture are people once they move; else they come to be the room's."""
        for user, body in roll:
            if user.stillness is None:
                continue
            if user.is_suspect and is_anothers(scene, user, roll):
                roll.strike_out(user)
                continue
            if not user.stillness.is_due(scene.time_s):
                continue
            looks = user.stillness.look(scene.cloud.depth_m, scene.time_s)
            is_seen = user.seen_s == scene.time_s
            is_like = is_seen and is_undoubted(scene, user, body, roll, looks)
            if user.is_suspect:
                self._judge_suspect(roll, scene, user, body, is_like)
            elif is_like or is_proven(user, scene.time_s):
                user.stillness = None
            elif user.stillness.telling_looks > PROBATION_LOOKS:
                is_still = not user.stillness.is_broken
                user.is_suspect = is_still and looks_doubtful(scene, user, body, roll, DEEP_DOUBT)
                user.watch(scene.cloud, np.isfinite(body), scene.time_s)

    def _judge_suspect(
        self, roll: Roll, scene: Scene, user: KnownUser, body: Distance, is_like: bool
    ) -> None:
        assert user.stillness is not None
        depth_m, is_body = scene.cloud.depth_m, np.isfinite(body)
        user.stillness.is_mixed |= nearest_m(user, roll.known) < MIXED_M
        walks_off = user.stillness.has_left and not is_torn_out(scene, body)
        is_somebody = user.stillness.is_broken or is_like or walks_off
        is_there = user.seen_s == scene.time_s or has_come(scene, user)
        if is_there and is_somebody and not may_be_an_arm(scene, user, body, roll):
            self._name(user)
            user.watch(scene.cloud, is_body, scene.time_s)
        elif user.stillness.watched_s > DOUBTED_S:
            self._background.learn(depth_m, is_body)
            roll.strike_out(user)
        elif not user.stillness.is_broken and user.stillness.has_grown(is_body):
            user.watch(scene.cloud, is_body, scene.time_s, user.stillness.watched_s)

    def _name(self, user: KnownUser) -> None:
        user.is_suspect = False
        if not user.id:
            user.id = self._next_id
            self._next_id += 1

    def welcome(self, roll: Roll, scene: Scene, heads: Sequence[HeadCandidate]) -> None:
        """Make users of new heads that stand over a person's body, once they are sure."""
        settings = self._settings
        doubtful = [body for user, body in roll if user.confidence_now < settings.new_confidence]
        waiting: list[KnownUser] = []
        present = Present([user.head_camera for user in roll.known], list(roll.bodies))
        # What is hardly like a head takes nobody's place.
        for head in sorted(heads, key=lambda head: head.by_shape < settings.new_confidence):
            center = head.center_camera
            if any(reached(scene, center, body) < np.inf for body in doubtful):
                present.refusals.append(Refusal(head, OWN_HEAD))  # see `association.correct`
                continue
            body = present.person_under(scene, head, settings)
            if body is None:
                continue
            own = present.left_of(body)
            present.add(center, body)
            user = self._seen_before(head, scene)
            user.doubted_frames += self._doubts(scene, head, own)
            if self._is_first_frame or scene.time_s - user.found_s >= settings.new_s:
                roll.add(user, self._take_out(scene, head, body, own))
                user.is_suspect = 2 * user.doubted_frames > user.frames_seen
                user.watch(scene.cloud, np.isfinite(own), scene.time_s)
                if not user.is_suspect:
                    self._name(user)
            else:
                waiting.append(user)
                present.refusals.append(Refusal(head, NEW))
        self._waiting, self.refusals = waiting, present.refusals
        self._is_first_frame = False

    def _doubts(self, scene: Scene, head: HeadCandidate, own: Distance) -> bool:
        """Whether a new head may be furniture's. Who is there in the first frame, and in full
        view, has some credit."""
        if head.by_shape < self._settings.new_confidence:
            return True
        has_credit = self._is_first_frame and not is_half_hidden(scene, own)
        return is_doubtful(scene, head, own, self._settings.limits, 2 if has_credit else 1)

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
            scene, unsure, own, self._settings.limits
        ):
            reach_m = self._settings.segmentation.core_radius * PRIOR_HEIGHT_M
            is_rest = is_body & ~scene.is_under(head.center_camera, reach_m)
            self._background.learn(scene.cloud.depth_m, is_rest)
            is_body &= ~is_rest
        self._background.forget(is_body)
        return np.where(is_body, body, np.float32(np.inf))

    def _seen_before(self, head: HeadCandidate, scene: Scene) -> KnownUser:
        view = HeadTemplate.of(scene.cloud, head.center_camera)
        for user in self._waiting:
            if user.score(head, scene.up_camera, scene.time_s) > -np.inf:
                self._waiting.remove(user)
                user.see(head, view, scene.time_s)
                return user
        return KnownUser(0, head, view, scene.time_s)
