"""One step of a track: where it is now, and what the frame tells of whether it is a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.heads import HeadCandidate, torso_is_unread, upright_confidence
from topview.people.bodies import SHOWN_M2, body_of, nearest_body, without_room
from topview.people.existence import Existence, is_too_near
from topview.people.features import FEATURE_NAMES, Features, features_of
from topview.people.height import PRIOR_HEIGHT_M
from topview.people.likelihood import Evidence, Likelihood, shipped_likelihood
from topview.people.motion import PAUSE_S
from topview.people.segmentation import SegmentationSettings, body_distance
from topview.people.settings import PeopleSettings
from topview.people.told import Told
from topview.people.track import SURE_HEAD, Track, is_off
from topview.people.unseen_heads import over_body
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# Above 0 where something of a body is nearer to another head.
ANOTHERS: Final = FEATURE_NAMES.index("somebody else's")
# Ours: a head is in view of which no more than this is hidden.
IN_VIEW: Final = 0.15


@dataclass(frozen=True, eq=False)
class Step:
    """What one frame, and the network in the last one, show.

    Attributes:
        scene: of this frame.
        last: of the last one; None in the first.
        told: what is known of the last frame's bodies.
        settings: how people are found.
        likelihood: of a person.
        before: the tracks in the last frame.
        bodies: [h, w] those under heads (`body_under`), by the heads' identities.
    """

    scene: Scene
    last: Scene | None
    told: Told
    settings: PeopleSettings
    likelihood: Likelihood = field(default_factory=shipped_likelihood)
    before: Sequence[Track] = ()
    bodies: dict[int, tuple[HeadCandidate, NDArray[np.float32]]] = field(default_factory=dict)

    @property
    def elapsed_s(self) -> float:
        """Since the last frame; of a pause only the beginning counts."""
        gone_s = 0.0 if self.last is None else self.scene.time_s - self.last.time_s
        return min(max(gone_s, 0.0), PAUSE_S)

    @cached_property
    def segmentation(self) -> SegmentationSettings:
        """How bodies grow from heads."""
        own = self.settings.segmentation
        return own.where_asked() if self.told.has_network else own

    @property
    def told_s(self) -> float:
        """When the network looked."""
        return self.scene.time_s if self.last is None else self.last.time_s

    def moved(self, tracks: Sequence[Track], taken: Mapping[int, HeadCandidate]) -> list[Track]:
        """The tracks in this frame: updated with the heads that they have taken, by their indices;
        or coasted, to where their bodies are."""
        scene = self.scene
        others = [head.center_camera for index, head in taken.items() if tracks[index].id]
        after = []
        for index, track in enumerate(tracks):
            told_camera = self.told.head_of(track, tracks, scene.time_s - track.time_s)
            head = taken.get(index)
            own = track
            if told_camera is not None:
                own, head = self._by_body(track, tracks, head, told_camera)
            if head is not None:
                now = own.updated(scene.cloud, head).corrected(scene, told_camera)
            else:
                now = own.coasted(scene, others)
            body_m = body_of(scene, now, self.segmentation, self.last, told_camera, others)
            after.append((replace(now, body_m=body_m), told_camera))
        seen = [track for track, _ in after if track.is_seen]
        return [
            track
            if track.is_seen
            else over_body(
                scene, track, seen, self.told, told_camera, self.settings, self.elapsed_s
            )
            for track, told_camera in after
        ]

    def with_evidence(self, tracks: Sequence[Track], known: Set[int]) -> list[Track]:
        """The tracks, with what tells whether they are people; `known` are the keys of those whose
        shape is not looked at again."""
        after = []
        looked_at = {track.key for track in tracks if track.key not in known}
        nearest = nearest_body(self.scene, tracks if looked_at else ())
        for track in tracks:
            evidence = track.evidence
            if track.key in looked_at:
                evidence = self._with_shape(track, tracks, nearest)
            log_odds = self.told.log_odds_of(track, tracks)
            if log_odds is not None:
                log_odds = self.told.unless_anothers(log_odds, self._share_of_others(track))
                evidence = evidence.with_network(log_odds, self.elapsed_s, self.told_s)
            is_upright = self.told.is_upright(track, self.scene.up_camera)
            if track.id and is_upright is False and self.told.is_near(track):
                evidence = replace(evidence, by_body=True)
            elif is_upright and track.confidence >= SURE_HEAD:
                evidence = replace(evidence, by_body=False, was_upright=True)
            now = replace(track, evidence=evidence)
            is_told = log_odds is not None
            after.append(without_room(self.scene, now, self.likelihood) if is_told else now)
        return after

    def _share_of_others(self, track: Track) -> float:
        """Of what the network was asked about as a track's, the share that is on the body of one
        who is more surely a person."""
        asked = next((own for own in self.before if own.key == track.key), None)
        if asked is None or asked.body_m is None or self.last is None:
            return 0.0
        surer = [other for other in self.before if self._is_surer(other, asked)]
        return self.told.share_on_body(self.last, asked.body_m < np.inf, surer)

    def _is_surer(self, other: Track, track: Track) -> bool:
        """Whether another track is a person more surely than this one."""
        own = track.evidence.log_odds(self.likelihood)
        is_surer = not track.id or other.evidence.log_odds(self.likelihood) > own
        return other.id > 0 and other.key != track.key and is_surer

    def body_under(self, head: HeadCandidate) -> NDArray[np.float32]:
        """[h, w] `body_distance` of a head of which nothing else is known; sought once."""
        if id(head) not in self.bodies:
            body = body_distance(self.scene, head.center_camera, PRIOR_HEIGHT_M, self.segmentation)
            self.bodies[id(head)] = head, body
        return self.bodies[id(head)][1]

    def features_under(self, head: HeadCandidate, nearest: NDArray[np.float32]) -> Features:
        """[S] of a head and what of the body below it is nobody else's (`nearest_body`)."""
        return features_of(self.scene, head, self.body_under(head), nearest)

    def _with_shape(
        self, track: Track, tracks: Sequence[Track], nearest: NDArray[np.float32]
    ) -> Evidence:
        """With the shape of a track's head and body: of what is not nearer to another head, or,
        where that is likelier a person's, of all but what those have who are likelier people."""
        head = self._head_in_view(track)
        if head is None or track.body_m is None:
            return track.evidence
        shape = features_of(self.scene, head, track.body_m, nearest)
        if shape[ANOTHERS] > 0.0:
            others = [other for other in tracks if self._is_likelier(other, track)]
            wider = nearest_body(self.scene, others)
            whole = features_of(self.scene, head, track.body_m, wider)
            shape = max(shape, whole, key=self.likelihood.log_odds_of_shape)
        moved = self.scene.moved_share(track.body_m < np.inf, track.born_depth_m, SHOWN_M2)
        return track.evidence.with_shape(shape, moved, self.scene.time_s)

    def _is_likelier(self, other: Track, track: Track) -> bool:
        """Whether another track is a person rather than this one is: a confirmed one, or of two
        that are not confirmed the likelier."""
        if other.id or track.id:
            return other.id > 0 and other.key != track.key
        return other.existence(self.likelihood) > track.existence(self.likelihood)

    def _by_body(
        self,
        track: Track,
        tracks: Sequence[Track],
        head: HeadCandidate | None,
        told_camera: Vector,
    ) -> tuple[Track, HeadCandidate | None]:
        """A track and its head: the one at [3] that the network tells, if what is in doubt is a
        person who lies or bends and whose head is elsewhere, or if no upright one has been
        found."""
        is_upright = self.told.is_upright(track, self.scene.up_camera)
        if not track.id and is_off(told_camera, track.place_camera):
            others = [other for other in tracks if other.key != track.key]
            if is_upright is False and not is_too_near(told_camera, others, self.scene):
                return track.found_by_body(self.scene.time_s), self.head_at(told_camera)
            if is_upright:
                there = self.head_at(told_camera)
                return track.restarted(self.scene, there).asked_anew(self.scene.time_s), there
        is_in_view = self.scene.covered_share(told_camera) <= IN_VIEW
        if head is None and (not track.id or (track.by_body and is_in_view)):
            return track, self.head_at(told_camera)
        return track, head

    @cached_property
    def heads_of_doubtful(self) -> dict[int, tuple[HeadCandidate, float]]:
        """Heads that the network knows where nobody is known yet, by their identities, and its
        log-odds."""
        told = [head for who, head in self.told.heads.items() if who < 0 and head.is_sure]
        found = [(self.head_at(head.head_camera), head.log_odds) for head in told]
        return {id(head): (head, log_odds) for head, log_odds in found}

    def head_at(self, told_camera: Vector) -> HeadCandidate:
        """A head [3] that the joint network tells, and how much it looks like an upright one."""
        scene = self.scene
        confidence = upright_confidence(scene.cloud, told_camera, scene.up_camera)
        return HeadCandidate(told_camera, confidence)

    def _head_in_view(self, track: Track) -> HeadCandidate | None:
        """A track's head as it looks; None where it is not in view."""
        scene, center = self.scene, track.place_camera
        confidence = track.confidence
        if not track.is_seen:
            if scene.covered_share(center) > IN_VIEW:
                return None
            confidence = upright_confidence(scene.cloud, center, scene.up_camera)
        up = np.array(scene.up_camera, ndmin=2)
        is_unread = torso_is_unread(scene.cloud, np.array(center, ndmin=2), up)
        return HeadCandidate(center, confidence, bool(is_unread[0]))


@dataclass(frozen=True, slots=True, eq=False)
class ShapeOdds:
    """Log-odds that what nobody explained in the last frame is a person below a head: of a head
    that it tells by the network, of what is remembered by all that is known, or else by shape."""

    step: Step
    existence: Existence

    def __call__(self, head: HeadCandidate) -> float:
        if id(head) in self.step.heads_of_doubtful:
            return self.step.heads_of_doubtful[id(head)][1]
        likelihood = self.existence.likelihood
        known = self.existence.remembered_at(head.center_camera, self.step.scene)
        if known is not None:
            return known.evidence.log_odds(likelihood)
        seen = [track for track in self.step.before if track.is_seen]
        nearest = nearest_body(self.step.scene, seen)
        return likelihood.log_odds_of_shape(self.step.features_under(head, nearest))
