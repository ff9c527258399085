"""Who is there already, and whether somebody else can be there too."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from topview.detect.heads import HeadCandidate, head_evidence
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.legs import stands_on_legs
from topview.people.scene import Scene
from topview.people.segmentation import body_distance
from topview.people.settings import PeopleSettings
from topview.people.validation import unlike_person

Vector = NDArray[np.float64]
Distance = NDArray[np.float32]

# Ours: below it nothing is taken for a head.
SUSPECT = 0.6
# Ours: closer together are no two heads' centres.
SAME_HEAD_M = 0.2
# Ours: what is this near to somebody's head over the surface is that person's, if it is not
# clearly another head.
OWN_HEAD_M = 0.4
TOO_NEAR = "too near to another head"


def reached(scene: Scene, point_camera: Vector, body: Distance) -> float:
    """How far over the surface what is seen at a point is from a body's head."""
    row, column, in_view = scene.cloud.pixel_of(point_camera)
    return float(body[row, column]) if in_view else np.inf


@dataclass(frozen=True, slots=True, eq=False)
class Refusal:
    """A head that has not been made a user, and why, in a few words."""

    head: HeadCandidate
    reason: str


@dataclass(slots=True, eq=False)
class Present:
    """Heads ([3] each) and bodies (`body_distance`, [h, w] each) that are sure, and what has been
    refused beside them."""

    heads: list[Vector] = field(default_factory=list)
    bodies: list[Distance] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)

    def add(self, head_camera: Vector, body: Distance) -> None:
        self.heads.append(head_camera)
        self.bodies.append(body)

    def owns(self, scene: Scene, head: HeadCandidate, sure: float) -> bool:
        """Whether a head is one of theirs already, or the shoulder of one who stands in front,
        which a head of less confidence than `sure` may be."""
        center = head.center_camera
        if any(np.linalg.norm(center - other) < SAME_HEAD_M for other in self.heads):
            return True
        return head.confidence < sure and any(
            reached(scene, center, body) < OWN_HEAD_M for body in self.bodies
        )

    def left_of(self, body: Distance) -> Distance:
        """[h, w] what of a body is not nearer to another's head."""
        own = body.copy()
        for other in self.bodies:
            np.copyto(own, np.inf, where=other < body)
        return own

    def person_under(
        self, scene: Scene, head: HeadCandidate, settings: PeopleSettings
    ) -> Distance | None:
        """The body that a new head stands over, if what of it is nobody else's measures like a
        person's and the head is far enough from other heads."""
        reason = self._against_head(scene, head, settings)
        if reason is None:
            body = body_distance(scene, head.center_camera, PRIOR_HEIGHT_M, settings.segmentation)
            reason = _against_body(scene, head, self.left_of(body), settings)
            if reason is None:
                return body
        self.refusals.append(Refusal(head, reason))
        return None

    def _against_head(
        self, scene: Scene, head: HeadCandidate, settings: PeopleSettings
    ) -> str | None:
        center = head.center_camera
        if self.heads:
            aside_m = np.hypot(*scene.overview_of(center - np.array(self.heads)).T)
            if aside_m.min() < settings.least_apart_m:
                return TOO_NEAR
        if head.torso_is_unread:
            return None
        if head.confidence < SUSPECT:
            return "hardly like a head"
        upright = head_evidence(scene.cloud, center[None], scene.up_camera).confidence[0]
        return "not upright" if upright < settings.upright_confidence else None


def _against_body(
    scene: Scene, head: HeadCandidate, own: Distance, settings: PeopleSettings
) -> str | None:
    if head.torso_is_unread:
        return None if stands_on_legs(scene, head, own) else "no torso read, and no legs"
    return unlike_person(scene, head, own, settings.limits)
