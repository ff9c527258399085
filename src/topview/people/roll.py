"""Who is known, and which points of the present frame are whose body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.people.height import PRIOR_HEIGHT_M
from topview.people.identity import KnownUser
from topview.people.scene import Scene
from topview.people.segmentation import Memory, body_distance
from topview.people.settings import PeopleSettings

Distance = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Ours: of whom more than this is seen has not gone, though the head is hidden.
SHOWN_M2 = 0.03
# Ours: a limb whose connection with the body is hidden seems further away from the head by this
# much in each second, until it is out of reach.
FADING_M_PER_S = 1.5
# Ours: who is missed first after a pause without frames is looked for as long as this.
AGAIN_S = 0.4


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
        faded_m = fading_m_per_s * self.elapsed_s(scene)
        return Memory(user.body_m, self._last_depth_m, faded_m)

    def elapsed_s(self, scene: Scene) -> float:
        """Since the last frame that is remembered."""
        return max(scene.time_s - self._last_s, 0.0)

    def remember(self, scene: Scene, masks: Sequence[Mask]) -> None:
        """For the next frame: which pixels [h, w] were whose."""
        for (user, body), is_users in zip(self, masks, strict=True):
            user.body_m = np.where(is_users, body, np.float32(np.inf))
        self._last_depth_m, self._last_s = scene.cloud.depth_m, scene.time_s

    def dismiss(self, scene: Scene) -> None:
        """Forget who has been away for too long: soon if he went out of the picture, late if
        something hides him, and later if only the head is hidden or out of the picture."""
        for user, _ in self:
            is_body = np.zeros(0, np.bool_) if user.body_m is None else np.isfinite(user.body_m)
            if user.seen_s == scene.time_s or self._shows(scene, user, is_body):
                user.there_s, user.missed_s = scene.time_s, None
            elif user.missed_s is None:
                user.missed_s = scene.time_s
            is_out = scene.is_out(user.head_camera, self.settings.border_m)
            grace_s = self.settings.out_s if is_out and not is_body.any() else self.settings.grace_s
            if user.missed_s is None or scene.time_s - user.missed_s < AGAIN_S:
                continue
            if scene.time_s - user.there_s > grace_s:
                self.strike_out(user)

    def _shows(self, scene: Scene, user: KnownUser, is_body: Mask) -> bool:
        """Whether of one whose head is not seen enough else is."""
        if scene.is_above(user.head_camera):  # stands too near for the head to be in the picture
            return bool(is_body.any())
        if scene.time_s - user.seen_s > self.settings.headless_s:
            return False
        body_m2 = area_m2(scene, user, is_body)
        return body_m2 > SHOWN_M2 and scene.is_hidden_at(user.head_camera)


def area_m2(scene: Scene, user: KnownUser, is_seen: Mask) -> float:
    """Of pixels at a user's distance."""
    return np.count_nonzero(is_seen) * scene.cloud.pixel_m(user.head_camera) ** 2
