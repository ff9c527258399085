"""Who is a person, and who has gone: thresholds on one probability."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from math import dist
from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from topview.detect.heads import HeadCandidate
from topview.people.bodies import SHOWN_M2
from topview.people.features import Features
from topview.people.likelihood import (
    FLICKER,
    Likelihood,
    probability,
    shipped_likelihood,
)
from topview.people.places import HEADS_APART_M
from topview.people.track import Track
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# All ours. A track is a person's from this probability of existence on, once its head has been seen
# for so long (at once in the very first frame).
CONFIRMED, NEW_TRACK_S = 0.9, 0.05
# Below it a confirmed one ends; and one that is not confirmed.
ENDED, REFUSED = 0.2, 0.05
# One that is not confirmed ends, too, when its head has not been seen for so long.
UNSEEN_S: Final = 0.3
# A confirmed one that is so new, or that stands and has not moved yet, and of which the network is
# asked, ends below this; a new one that was confirmed in the very first frame, before the network
# was asked, where it would not be confirmed again. Nor is anybody put out who is not seen and is
# less likely there.
NEW_S, DOUBTED = 0.5, 0.5
# What is probably no person, and has neither moved nor been confirmed for so long, is the room's.
ROOM_S, ROOM_BELOW = 5.0, 0.5
# So many tracks are remembered that have ended.
MOST_REMEMBERED: Final = 20
# Somebody is put out while near to the place that is told with this probability.
TOLD: Final = 0.9
# A person whose track ended less than so long ago may have moved so fast since, as who falls does.
AGAIN_S, FALL_M_PER_S = 1.0, 2.0
# Why heads are refused, besides what their bodies lack.
OWN_HEAD, NEW, TOO_NEAR = "on somebody's body", "just come", "too near to another head"


@dataclass(frozen=True, slots=True, eq=False)
class Refusal:
    """A head that is nobody's yet, and why, in a few words."""

    head: HeadCandidate
    reason: str


class Existence:
    """Confirms tracks and ends them.

    Args:
        most: people at the same time; None for any number.
        likelihood: of a person; the shipped one if None.
    """

    def __init__(self, most: int | None = None, likelihood: Likelihood | None = None) -> None:
        self.likelihood = likelihood or shipped_likelihood()
        self._most = most
        self._next_id = 1
        self._is_first = True
        self._unasked: set[int] = set()  # who was confirmed in the first frame
        self._remembered: list[Track] = []  # that ended though the network was asked about them
        self._was: dict[int, int] = {}  # by keys, whose track it was before it ended

    def confirmed(
        self, tracks: Sequence[Track], scene: Scene, free: Set[int], has_network: bool
    ) -> list[Track]:
        """The tracks, with identities for those who have come to be people, likeliest first, of two
        at one head the likelier; where a network is asked, not before it has answered, but in the
        very first frame.

        Args:
            tracks: after this frame.
            scene: of this frame.
            free: keys of those that may be no part of somebody else.
            has_network: whether a network is asked.
        """
        ready = [
            track
            for track in tracks
            if not track.id and track.key in free and self._is_ready(track, scene, has_network)
        ]
        ready.sort(key=lambda track: (-self.existence_of(track), track.key))
        self._are_there({track.id for track in tracks})
        there = sum(self.is_put_out(track, scene) for track in tracks)
        new: list[Track] = []
        for track in ready:
            if not is_too_near(track.place_camera, new, scene):
                new.append(track)
        most = len(new) if self._most is None else max(self._most - there, 0)
        ids = self._identities(new[:most])
        if self._is_first:
            self._unasked, self._is_first = set(ids.values()), False
        return [replace(t, id=ids[t.key]) if t.key in ids else t for t in tracks]

    def _are_there(self, ids: Set[int]) -> None:
        """These people are known to be somewhere: nobody else is to be one of them."""
        self._was = {key: own for key, own in self._was.items() if own not in ids}
        self._remembered = [
            replace(track, id=0) if track.id in ids else track for track in self._remembered
        ]

    def _identities(self, ready: Sequence[Track]) -> dict[int, int]:
        """By key, of those who come to be people: the one of before of whoever was put out for a
        while, new ones of all others."""
        again = {track.key: self._was.pop(track.key) for track in ready if track.key in self._was}
        for track in ready:
            before = None if track.key in again else self._just_ended_near(track)
            if before is not None:
                again[track.key] = before.id
                self._are_there({before.id})
        others = [track.key for track in ready if track.key not in again]
        first = self._next_id
        self._next_id += len(others)
        return again | {key: first + number for number, key in enumerate(others)}

    def _just_ended_near(self, track: Track) -> Track | None:
        """The person whose track ended a moment ago, so near that the track may go on with it."""
        for ended in self._remembered:
            gone_s = track.time_s - ended.time_s
            if not ended.id or gone_s >= AGAIN_S:
                continue
            away_m = dist(ended.place_camera.tolist(), track.place_camera.tolist())
            if away_m < HEADS_APART_M + FALL_M_PER_S * gone_s:
                return ended
        return None

    def _is_ready(self, track: Track, scene: Scene, has_network: bool) -> bool:
        if has_network and not (track.evidence.asked_s > 0.0 or self._is_first):
            return False
        is_old = scene.time_s - track.born_s >= NEW_TRACK_S and scene.time_s > track.anew_s
        is_long_enough = self._is_first or is_old
        return track.is_seen and is_long_enough and self.existence_of(track) > CONFIRMED

    def existence_of(self, track: Track) -> float:
        """Probability that a track is a person, and there."""
        return track.existence(self.likelihood)

    def is_put_out(self, track: Track, scene: Scene) -> bool:
        """Whether it can be told where a confirmed person is: one whose head is neither seen nor
        told must be in the picture, or above it, and likelier there than not."""
        if not track.id or track.places is None:
            return track.id > 0
        outside = 0.0 if scene.is_above(track.place_camera) else track.places.outside
        existence = self.existence_of(track)
        if existence > DOUBTED and track.body_m2 > SHOWN_M2:
            return outside <= TOLD
        return existence * track.certainty * (1.0 - outside) > TOLD

    def has_ended(self, track: Track, scene: Scene) -> bool:
        """Whether it is too unlikely to be followed."""
        if not track.id and track.unseen_s(scene.time_s) > UNSEEN_S:
            return True
        is_asked = track.evidence.asked_s > 0.0
        if not track.id:
            # What was refused and stands still is kept, so that it is not asked about as if new.
            is_kept = is_asked and track.evidence.still == 1.0
            return self.existence_of(track) < REFUSED and not is_kept
        has_stood = track.evidence.still > 0.0 and not track.evidence.by_body
        is_new = scene.time_s - max(track.born_s, track.anew_s) < NEW_S
        least = CONFIRMED if is_new and track.id in self._unasked else DOUBTED
        is_doubted = is_asked and (is_new or has_stood)
        return self.existence_of(track) < (least if is_doubted else ENDED)

    def going_on(self, tracks: Sequence[Track], scene: Scene) -> list[Track]:
        """Those that have not ended; what the network said of the others is kept for their places,
        but of who has gone."""
        after = [track for track in tracks if not self.has_ended(track, scene)]
        keys, left = {track.key for track in tracks}, {track.key for track in after}
        before = [track for track in self._remembered if track.key not in keys]
        ended = [track for track in tracks if track.key not in left and _is_there(track)]
        self._remembered = [*before, *ended][-MOST_REMEMBERED:]
        return after

    def remembered_at(self, head_camera: Vector, scene: Scene) -> Track | None:
        """The track that ended at a head at [3], if nothing has changed there; a thing that had
        stood still all the time also where its head is told higher or lower."""
        for track in self._remembered:
            assert track.body_m is not None
            if track.evidence.still == 1.0:
                is_here = is_too_near(head_camera, [track], scene)
            else:
                is_here = dist(track.place_camera.tolist(), head_camera.tolist()) < HEADS_APART_M
            if is_here and scene.changed_share(track.body_m < np.inf, track.time_s) < FLICKER:
                return track
        return None

    def taken_up(self, born: Track, scene: Scene) -> Track:
        """A track that has just been born; or what is known of that place goes on."""
        track = self.remembered_at(born.place_camera, scene)
        if track is None:
            return born
        if track.id:
            self._are_there({track.id})
            self._was[track.key] = track.id
        own = replace(track, id=0, height=born.height, face=born.face)
        return replace(own.restarted(scene, born.head), body_m=born.body_m)

    def is_room(self, track: Track, scene: Scene) -> bool:
        """Whether it is probably a part of the room."""
        is_old = scene.time_s - track.born_s > ROOM_S
        return not track.id and is_old and self.existence_of(track) < ROOM_BELOW

    def may_be(self, features: Features) -> bool:
        """Whether a new head with [S] features is worth following."""
        return probability(self.likelihood.log_odds_of_shape(features)) > REFUSED

    def refusal_of(self, track: Track) -> Refusal:
        """Why a track is not confirmed."""
        is_person = self.existence_of(track) > CONFIRMED
        reason = NEW if is_person else self.likelihood.worst_of(track.evidence.features)
        return Refusal(HeadCandidate(track.place_camera, track.confidence), reason)


def _is_there(track: Track) -> bool:
    """Whether what has ended is a thing that the network was asked about and that has not gone."""
    is_there = track.is_seen or not track.id
    return is_there and track.evidence.asked_s > 0.0


def is_too_near(head_camera: Vector, tracks: Sequence[Track], scene: Scene) -> bool:
    """Whether a head [3] is so near to another that both cannot be heads, seen from above."""
    if not tracks:
        return False
    offsets_camera = head_camera - np.array([track.place_camera for track in tracks])
    aside = scene.overview_of(offsets_camera).tolist()
    return any(right * right + forward * forward < HEADS_APART_M**2 for right, forward in aside)
