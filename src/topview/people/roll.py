"""Who is known, and which points of the present frame are whose body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import JOINT_NAMES
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.identity import KnownUser
from topview.people.scene import Scene
from topview.people.segmentation import Memory, body_distance
from topview.people.settings import PeopleSettings
from topview.records import JointState, Person

Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Ours: a tracked body whose head is further from the expected one has been lost itself.
STRAYED_M = 0.5
# Ours: a tracked body tells where its hidden head is if this share of its joints is seen.
KNOWING_SHARE = 0.3
HEAD_JOINT = JOINT_NAMES.index("head")
# Ours: a limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S = 1.5


@dataclass(slots=True, eq=False)
class Roll:
    """All who are known, and those who may be furniture yet.

    Attributes:
        settings: how people are found.
        known: in the order in which they came.
        bodies: [h, w] each, of the present frame (`body_distance`), in the same order.
    """

    settings: PeopleSettings
    known: list[KnownUser] = field(default_factory=list)
    bodies: list[Distance] = field(default_factory=list)
    _last_depth_m: NDArray[np.float32] | None = None
    _last_s: float = 0.0

    def __iter__(self) -> Iterator[tuple[KnownUser, Distance]]:
        return iter(list(zip(self.known, self.bodies, strict=True)))

    def add(self, user: KnownUser, body: Distance) -> None:
        self.known.append(user)
        self.bodies.append(body)

    def strike_out(self, user: KnownUser) -> None:
        index = self.known.index(user)
        del self.known[index], self.bodies[index]

    def others_of(self, user: KnownUser) -> list[tuple[KnownUser, Distance]]:
        """All but one, and but those who may be furniture, with their bodies."""
        return [(other, body) for other, body in self if other is not user and not other.is_suspect]

    def heed(self, tracked: Sequence[Person]) -> None:
        """Where a head was not seen in the last frame, a body of which enough was seen knows
        better."""
        known = {user.id: user for user in self.known if user.confidence_now == 0.0}
        for person in tracked:
            user = known.get(person.id)
            given = person.joint_state[person.joint_state != JointState.ABSENT]
            seen = (given == JointState.VISIBLE).mean()
            if user is None or seen < KNOWING_SHARE:
                continue
            head_camera = person.joints_camera[HEAD_JOINT]
            if np.linalg.norm(head_camera - user.head_camera) < STRAYED_M:
                user.head_camera = np.array(head_camera)

    def body_of(self, scene: Scene, user: KnownUser) -> Distance:
        """[h, w] a known user's body in the present frame."""
        is_seen = user.seen_s == scene.time_s
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
        elapsed_s = scene.time_s - self._last_s
        return Memory(user.body_m, self._last_depth_m, fading_m_per_s * elapsed_s)

    def remember(self, scene: Scene, masks: Sequence[Mask]) -> None:
        """For the next frame: which pixels [h, w] were whose."""
        for (user, body), is_users in zip(self, masks, strict=True):
            user.body_m = np.where(is_users, body, np.float32(np.inf))
        self._last_depth_m, self._last_s = scene.cloud.depth_m, scene.time_s

    def dismiss(self, scene: Scene) -> None:
        """Forget who has been away for too long: soon if he went out of the picture, but not
        while he stands so near that only the head is out of it."""
        settings = self.settings
        for user, _ in self:
            has_body = user.body_m is not None and bool(np.isfinite(user.body_m).any())
            is_out = scene.is_out(user.head_camera, settings.border_m)
            grace_s = settings.out_s if is_out and not has_body else settings.grace_s
            stands_near = has_body and scene.is_above(user.head_camera)
            if not stands_near and scene.time_s - user.seen_s > grace_s:
                self.strike_out(user)
