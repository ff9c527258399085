"""What is known of one person, or of what may be one; it does not change, each frame makes a new
one."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Final

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.cloud import Cloud
from topview.detect.head_template import HeadTemplate
from topview.detect.heads import HeadCandidate
from topview.people.colors import FaceMemory
from topview.people.features import Features
from topview.people.height import TALLER_M, HeightEstimate, sunk_m
from topview.people.likelihood import Evidence, Likelihood, probability
from topview.people.motion import PAUSE_S, Motion, predicted
from topview.people.places import Places, repeated_m
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# Ours: how a head looks is learnt anew from this confidence on, which one that hangs down has.
VIEW_FROM: Final = 0.25
# Ours: what the network says is so far away, for so long, is not the head.
TOLD_OFF_M, TOLD_OFF_S = 0.18, 0.08
# Ours: from this confidence on what is followed is an upright head.
SURE_HEAD: Final = 0.75


class Track(msgspec.Struct, frozen=True, eq=False):
    """The state of one track after a frame.

    Attributes:
        key: number of the track, from 1 in the order of birth.
        motion: of the head, at `motion_s`: when it was last seen, or told by the joint network.
        view: what the head looked like then.
        evidence: what tells whether it is a person.
        height, face: stature, and how much of the face is seen of late.
        born_s, seen_s, time_s, motion_s: when the head was first and last seen; time of this state,
            and of `motion`.
        born_depth_m: [h, w] the depth image at `born_s`, which tells whether it has moved since.
        id: of the person, from 1; 0 while it is not confirmed.
        confidence: that what is followed is the head, 0 while it is not seen.
        places: where the head may be while it is neither seen nor told; None while it is.
        place_camera: [3] the head's centre: seen, or the most likely place.
        certainty: probability that it is near `place_camera`.
        clothes: histogram of their colours, None while unknown.
        company: keys of tracks for which it may have been taken of late.
        body_m: [h, w] how far its pixels were from the head in the last frame, None before.
        body_m2: area of what is seen of it.
        rival_since_s: since when something else on the body has looked more like its head.
        off_since_s: since when the joint network has said that the head is elsewhere.
        anew_s: since when what is followed is something else than before (`asked_anew`).
        is_narrow: whether its body is taken for no more than stands right under the head.
        narrowed_s: since when that was last so.
    """

    key: int
    motion: Motion
    view: HeadTemplate
    evidence: Evidence
    height: HeightEstimate
    face: FaceMemory
    born_s: float
    seen_s: float
    time_s: float
    motion_s: float
    born_depth_m: NDArray[np.float32]
    place_camera: Vector
    id: int = 0
    confidence: float = 0.0
    places: Places | None = None
    certainty: float = 1.0
    clothes: NDArray[np.float32] | None = None
    company: frozenset[int] = frozenset()
    body_m: NDArray[np.float32] | None = None
    body_m2: float = 0.0
    rival_since_s: float | None = None
    off_since_s: float | None = None
    anew_s: float = -inf
    is_narrow: bool = False
    narrowed_s: float = -inf

    @classmethod
    def born(cls, key: int, cloud: Cloud, head: HeadCandidate, features: Features) -> Track:
        """A head that nobody explains."""
        center, time_s = head.center_camera, cloud.frame.timestamp_s
        return cls(
            key,
            Motion.starting_at(center),
            HeadTemplate.of(cloud, center),
            Evidence.starting_with(features, time_s),
            HeightEstimate(),
            FaceMemory(),
            time_s,
            time_s,
            time_s,
            time_s,
            cloud.depth_m,
            center,
            confidence=head.confidence,
        )

    @property
    def told_as(self) -> int:
        """The id by which it is known outside: below 0 while it is not confirmed."""
        return self.id or -self.key

    @property
    def is_seen(self) -> bool:
        """Whether the head is."""
        return self.seen_s == self.time_s

    @property
    def is_hidden(self) -> bool:
        """Whether it is a person who is probably hidden in the picture."""
        return self.id > 0 and self.places is not None and self.places.outside < 0.5

    @property
    def by_body(self) -> bool:
        """Whether no upright head is to be expected on it, and none is seen."""
        return self.evidence.by_body and self.confidence < SURE_HEAD

    @property
    def head(self) -> HeadCandidate:
        """What is followed."""
        return HeadCandidate(self.place_camera, self.confidence)

    @property
    def presence(self) -> float:
        """Probability that it has not gone."""
        return 1.0 if self.places is None else self.places.presence

    def existence(self, likelihood: Likelihood) -> float:
        """Probability that it is a person, and there."""
        return probability(self.evidence.log_odds(likelihood)) * self.presence

    def unseen_s(self, time_s: float) -> float:
        """For how long the head has not been seen."""
        return max(time_s - self.seen_s, 0.0)

    def expected(self, time_s: float) -> Motion:
        """The head's motion, predicted."""
        return predicted(self.motion, time_s - self.motion_s)

    def updated(self, cloud: Cloud, head: HeadCandidate) -> Track:
        """With a measured head."""
        time_s, center = cloud.frame.timestamp_s, head.center_camera
        is_back = time_s - self.motion_s > PAUSE_S
        motion = Motion.starting_at(center) if is_back else self.expected(time_s).updated(center)
        view = HeadTemplate.of(cloud, center) if head.confidence > VIEW_FROM else self.view
        return replace(
            self,
            motion=motion,
            motion_s=time_s,
            view=view,
            seen_s=time_s,
            time_s=time_s,
            confidence=head.confidence,
            places=None,
            place_camera=center,
            certainty=1.0,
        )

    def corrected(self, scene: Scene, told_camera: Vector | None) -> Track:
        """At the head [3] that the joint network told, if another place has been followed for long
        enough."""
        if told_camera is None or not is_off(told_camera, self.place_camera):
            return replace(self, off_since_s=None)
        if self.off_since_s is None:
            return replace(self, off_since_s=scene.time_s)
        if scene.time_s - self.off_since_s < TOLD_OFF_S:
            return self
        head = HeadCandidate(told_camera, self.confidence)
        return replace(self.restarted(scene, head), off_since_s=None)

    def found_by_body(self, time_s: float) -> Track:
        """Without an upright head: what the network says of the body counts from this time on."""
        evidence = replace(self.evidence, by_body=True, was_upright=False)
        return replace(self, evidence=evidence, confidence=0.0).asked_anew(time_s)

    def asked_anew(self, time_s: float) -> Track:
        """What the network said until this time was of something else than what is followed."""
        evidence = replace(self.evidence, network=0.0, asked_s=0.0)
        return replace(self, evidence=evidence, anew_s=time_s)

    def restarted(self, scene: Scene, head: HeadCandidate) -> Track:
        """What was followed was not the head; this is. A stature below it was not its own, nor,
        of who is not known as a person, was the shape."""
        motion = self.motion.restarted(head.center_camera)
        is_above = (sunk_m(scene, head.center_camera, self.height) or 0.0) < -TALLER_M
        height = HeightEstimate() if is_above else self.height
        evidence = self.evidence if self.id else self.evidence.of_another_head()
        there = replace(self, motion=motion, motion_s=scene.time_s, rival_since_s=None)
        return replace(there, height=height, evidence=evidence).updated(scene.cloud, head)

    def as_person(self, other: Track) -> Track:
        """The same head and body, with the identity of another and what is known of that person."""
        return replace(
            self,
            id=other.id,
            height=other.height,
            face=other.face,
            clothes=other.clothes,
        )

    def told_at(self, scene: Scene, told_camera: Vector, sigma_m: float, elapsed_s: float) -> Track:
        """With a head [3] that is not seen, but that the joint network tells so exactly."""
        each_m = repeated_m(sigma_m, elapsed_s)
        motion = self.expected(scene.time_s).updated(told_camera, each_m)
        return replace(
            self,
            motion=motion,
            motion_s=scene.time_s,
            time_s=scene.time_s,
            confidence=0.0,
            places=None,
            place_camera=motion.position_camera,
            certainty=1.0,
        )

    def coasted(self, scene: Scene, others_camera: Sequence[Vector] = ()) -> Track:
        """Without a measured head; those of others are at [3] places."""
        before = self.places or Places.around(scene, self.motion, self.key)
        places = before.seen(scene, scene.time_s - self.time_s, self.key, others_camera)
        return self.placed(scene, places)

    def placed(self, scene: Scene, places: Places) -> Track:
        """With other samples of where the head may be."""
        place_camera, certainty = places.best(scene)
        return replace(
            self,
            time_s=scene.time_s,
            confidence=0.0,
            places=places,
            place_camera=place_camera,
            certainty=certainty,
        )


def is_off(told_camera: Vector, place_camera: Vector) -> bool:
    """Whether a head [3] that the joint network tells is another than the one at [3]."""
    return bool(np.linalg.norm(told_camera - place_camera) > TOLD_OFF_M)
