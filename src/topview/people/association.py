"""Which head is whose: one assignment over log-likelihood ratios."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import dist, exp, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.head_template import track_head
from topview.detect.heads import HeadCandidate
from topview.filter.assignment import assign
from topview.people.appearance import clothes_under, unlikeness
from topview.people.existence import is_too_near
from topview.people.height import TALLER_M, sunk_m
from topview.people.motion import Motion
from topview.people.places import SAME_HEAD_M
from topview.people.track import Track
from topview.room.scene import Scene

Vector = NDArray[np.float64]

# All ours. Density of things that look like heads, per cubic metre.
CLUTTER_PER_M3: Final = 0.3
# And of new people who appear in the middle of the picture where another is missed.
NEW_PER_M3: Final = 0.003
# A head in plain view is missed in this share of frames.
MISSED: Final = 0.05
# Log-likelihood ratios of a candidate without and with all marks of a head; and of clothes that are
# alike and not.
UNLIKE_HEAD, LIKE_HEAD = -2.0, 2.0
CLOTHES_WEIGHT: Final = 10.0
# The unlikeness of clothes between that of one person and that of two.
SAME_CLOTHES: Final = 0.45
# A head that something comes to cover does not move down, but what is seen of it does.
COVERED, SLIP_M, SLIP_M_PER_S = 0.15, 0.02, 0.3
SLIPPED: Final = 8.0
# On somebody else's body, so near to the head, is no other head, if it is not a good one.
OWN_HEAD_M, ANOTHERS_HEAD, GOOD_HEAD = 0.4, 6.0, 0.75
# A head this near to where it is expected, and as sure, is not searched for again.
AT_ONCE_M, AT_ONCE = 0.06, 0.75
# Of one who was hidden for longer the head's shape of then is no more followed.
FOLLOWED_S: Final = 0.5
# Less likely places are not looked at.
FARTHEST: Final = -8.0


def associate(
    tracks: Sequence[Track],
    scene: Scene,
    heads: Sequence[HeadCandidate],
    log_odds_of: Callable[[HeadCandidate], float],
    told: Sequence[HeadCandidate] = (),
) -> tuple[dict[int, HeadCandidate], list[HeadCandidate]]:
    """The head of each track that has one, by the track's index; and the detected heads that nobody
    took.

    Args:
        tracks: as they were in the last frame.
        scene: of this frame.
        heads: that are detected.
        log_odds_of: of a person's body below a head that nobody else explains.
        told: heads that the joint network tells of what may be people; they may be those of people
            whose heads are not seen.
    """
    seekers = [Seeker.of(row, tracks, scene, log_odds_of) for row in range(len(tracks))]
    options = [*heads, *told]
    scores = np.full((len(tracks), len(options) + len(tracks)), -np.inf)
    for row, seeker in enumerate(seekers):
        for column, head in enumerate([*heads, *told] if seeker.track.is_hidden else heads):
            scores[row, column] = seeker.ratio_of(head)
        followed = seeker.followed(heads, scores[row])
        if followed is not None:
            scores[row, len(options)] = seeker.ratio_of(followed)
            options.append(followed)
    missed = np.array([seeker.missed() for seeker in seekers])
    gains = scores[:, : len(options)] - missed[:, None]
    lent = _lent_to_who_comes_back(tracks, options, gains)
    scores[:, : len(options)] += lent
    gains += lent
    matches = assign(np.where(gains > 0.0, gains, -np.inf))
    taken: dict[int, HeadCandidate] = {}
    for row, column in sorted(matches.items(), key=lambda match: -scores[match]):
        if is_apart(options[column], taken.values()):
            taken[row] = options[column]
    return taken, [head for head in heads if is_apart(head, taken.values())]


def _lent_to_who_comes_back(
    tracks: Sequence[Track], heads: Sequence[HeadCandidate], gains: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[tracks, heads] what people whose place is not known gain besides from a head that a track
    which is not confirmed gains from: where one of them may be there, the track is theirs, and its
    motion speaks for both."""
    lent = np.zeros_like(gains)
    is_new = [not track.id for track in tracks]
    is_back = [track.id > 0 and track.places is not None for track in tracks]
    if heads and any(is_new) and any(is_back):
        places_camera = np.array([head.center_camera for head in heads])
        apart_m = np.linalg.norm(places_camera[:, None] - places_camera, axis=-1)
        of_new = np.maximum(gains[is_new].max(axis=0), 0.0)
        most = np.where(apart_m <= SAME_HEAD_M, of_new, 0.0).max(axis=1)
        lent[is_back] = np.where(gains[is_back] > 0.0, most, 0.0)
    return lent


@dataclass(frozen=True, slots=True, eq=False)
class Seeker:
    """A track that seeks its head in a frame.

    Attributes:
        track: as it was in the last frame.
        others: the other tracks.
        scene: of this frame.
        expected: the head's motion, predicted.
        log_odds_of: see `associate`.
    """

    track: Track
    others: Sequence[Track]
    scene: Scene
    expected: Motion
    log_odds_of: Callable[[HeadCandidate], float]

    @classmethod
    def of(
        cls,
        row: int,
        tracks: Sequence[Track],
        scene: Scene,
        log_odds_of: Callable[[HeadCandidate], float],
    ) -> Seeker:
        """One of the tracks."""
        track, others = tracks[row], [*tracks[:row], *tracks[row + 1 :]]
        return cls(track, others, scene, track.expected(scene.time_s), log_odds_of)

    def missed(self) -> float:
        """Log-likelihood of no measurement: unlikely of a head that is in plain view."""
        if self.track.places is not None:
            return 0.0
        is_free = 1.0 - self.scene.covered_share(self.expected.position_camera)
        return log(1.0 - (1.0 - MISSED) * is_free)

    def ratio_of(self, head: HeadCandidate) -> float:
        """Log-likelihood ratio of a head: this track's against clutter or somebody new."""
        track, scene, center = self.track, self.scene, head.center_camera
        if track.places is not None:
            ratio = track.places.log_density(scene, center)
            if ratio < FARTHEST:
                return -np.inf
            by_shape = self.log_odds_of(head)
            ratio += by_shape - log(CLUTTER_PER_M3 + NEW_PER_M3 * exp(min(by_shape, 50.0)))
            ratio += self._by_clothes(head)
        else:
            ratio = self.expected.log_density(center) - log(CLUTTER_PER_M3)
            if ratio < FARTHEST:
                return -np.inf
            ratio += UNLIKE_HEAD + (LIKE_HEAD - UNLIKE_HEAD) * head.confidence
        ratio += self._by_stature(head)
        return ratio - ANOTHERS_HEAD * self._is_anothers(head) - SLIPPED * self._slips(head)

    def _by_stature(self, head: HeadCandidate) -> float:
        below_m = sunk_m(self.scene, head.center_camera, self.track.height)
        return 0.0 if below_m is None else -0.5 * (min(below_m, 0.0) / TALLER_M) ** 2

    def _by_clothes(self, head: HeadCandidate) -> float:
        if self.track.clothes is None:
            return 0.0
        near = [other.place_camera for other in self.others if other.is_seen]
        worn = clothes_under(self.scene, head.center_camera, near)
        if worn is None:
            return 0.0
        return CLOTHES_WEIGHT * (SAME_CLOTHES - unlikeness(self.track.clothes, worn))

    def _is_anothers(self, head: HeadCandidate) -> bool:
        """Whether a head is a part of another: too near to a head that is seen or told, for one
        that comes back; or not a good one, and on the body of another whose head is seen, or, for
        one that comes back, on what shows of another whose head is not."""
        people = [other for other in self.others if other.id]
        known = [other for other in people if other.places is None]
        if not self.track.is_seen and is_too_near(head.center_camera, known, self.scene):
            return True
        if head.confidence >= GOOD_HEAD:
            return False
        row, column, in_view = self.scene.cloud.pixel_at(head.center_camera)
        if not in_view or self.scene.is_hidden_at(head.center_camera):
            return False
        return any(
            other.body_m is not None
            and bool(other.body_m[row, column] < (OWN_HEAD_M if other.is_seen else np.inf))
            for other in people
            if other.is_seen or (not self.track.is_seen and other.body_m2 > 0.0)
        )

    def _slips(self, head: HeadCandidate) -> bool:
        """Whether a head seems to move down as something comes before it."""
        if self.track.places is not None:
            return False
        scene, expected_camera = self.scene, self.expected.position_camera
        down_m = -float((head.center_camera - expected_camera) @ scene.up_camera)
        step_s = scene.time_s - self.track.time_s
        if down_m < SLIP_M + SLIP_M_PER_S * step_s:
            return False
        above = head.center_camera + down_m * scene.up_camera
        return max(scene.covered_share(expected_camera), scene.covered_share(above)) > COVERED

    def followed(
        self, heads: Sequence[HeadCandidate], scores: NDArray[np.float64]
    ) -> HeadCandidate | None:
        """The head found again by its shape, where none that was detected is as good."""
        track, scene, expected_camera = self.track, self.scene, self.expected.position_camera
        if track.unseen_s(scene.time_s) > FOLLOWED_S:
            return None
        if heads:
            best = heads[int(np.argmax(scores[: len(heads)]))]
            off_m = dist(best.place, expected_camera.tolist())
            if off_m < AT_ONCE_M and best.confidence > AT_ONCE:
                return None
        return track_head(
            scene.cloud,
            track.view,
            expected_camera,
            scene.up_camera,
            max(scene.time_s - track.time_s, 0.0),
        )


def is_apart(head: HeadCandidate, others: Iterable[HeadCandidate]) -> bool:
    """Whether a head is none of the others."""
    return all(dist(head.place, other.place) > SAME_HEAD_M for other in others)
