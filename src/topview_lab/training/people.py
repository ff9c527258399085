"""What is seen of people and of furniture in recordings whose people are known.

The tracker runs with an `Existence` that knows the truth: whatever may be a head is followed, and
who is truly there is confirmed. Each frame's evidence of each followed head is a row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from topview.people.existence import Existence
from topview.people.features import FEATURE_NAMES, Features
from topview.people.finder import PeopleFinder
from topview.people.likelihood import Evidence, Likelihood
from topview.people.track import Track
from topview.records import InputError, Recording
from topview.room.scene import Scene
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker
from topview_lab.metrics.heads import TrueHeads

Vector = NDArray[np.float64]

# All ours. A track whose head is so near to a true one is the person's; one that is farther from
# all of them than the other follows furniture; in between nothing is learnt.
PERSON_M, FURNITURE_M = 0.25, 0.45
# A second track beside a confirmed one that is so near to the true head, and nearer, is no person.
DOUBLE_M: Final = 0.2
# A cluster with points so near to a true head has it; one without any nearer than the second is
# no body.
IN_CLUSTER_M, APART_FROM_M = 0.15, 1.0
# A confirmed track that is farther from all true heads follows nobody any more.
LOST_M: Final = 0.6

NOTHING_KNOWN: Final = Likelihood(
    "nothing", 0.0, dict.fromkeys(FEATURE_NAMES, 0.0), 0.0, 1.0, 0.0, 0.0
)
"""Tells nothing: what is collected does not depend on what was fitted before."""


class KnownPeople(Protocol):
    """A recording whose true heads are known."""

    @property
    def name(self) -> str: ...

    def open(self) -> Recording: ...

    def true_heads(self) -> TrueHeads: ...


@dataclass(frozen=True, slots=True, eq=False)
class TrackRows:
    """What was seen of tracks, a row for each track and frame.

    Attributes:
        features: [N, F] means of `FEATURE_NAMES`.
        network: [N] mean log-odds of the joint network, 0 where it has not looked.
        is_asked: [N] whether it has.
        is_person: [N] whether the track is truly a person's.
    """

    features: NDArray[np.float64]
    network: NDArray[np.float64]
    is_asked: NDArray[np.bool_]
    is_person: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.is_person)

    @classmethod
    def of(cls, seen: Sequence[tuple[Evidence, bool]]) -> TrackRows:
        """From the evidence of tracks, and whether they are people's."""
        return cls(
            np.array([own.features for own, _ in seen], np.float64).reshape(-1, len(FEATURE_NAMES)),
            np.array([own.network for own, _ in seen], np.float64),
            np.array([own.asked_s > 0.0 for own, _ in seen], np.bool_),
            np.array([is_person for _, is_person in seen], np.bool_),
        )

    @classmethod
    def joined(cls, parts: Sequence[TrackRows]) -> TrackRows:
        """One after the other."""
        parts = [cls.of(()), *parts]
        return cls(
            np.concatenate([part.features for part in parts]),
            np.concatenate([part.network for part in parts]),
            np.concatenate([part.is_asked for part in parts]),
            np.concatenate([part.is_person for part in parts]),
        )


class TrueExistence(Existence):
    """Follows whatever may be a head while it is seen, and confirms who is truly there.

    Attributes:
        heads_camera: [R, 3] the true heads of the frame.
    """

    def __init__(self) -> None:
        super().__init__(likelihood=NOTHING_KNOWN)
        self.heads_camera: Vector = np.empty((0, 3))

    def look_at(self, truth: TrueHeads, index: int) -> None:
        """Go on to a frame of the recording."""
        heads_camera = truth.of_frames(np.array([index])).heads_camera[0]
        self.heads_camera = heads_camera[np.isfinite(heads_camera).all(axis=-1)]

    def label_of(self, track: Track, tracks: Sequence[Track]) -> bool | None:
        """Whether a track is a person's, not another's or furniture's; None where that is hard to
        say."""
        away_m = self.away_m(track.place_camera)
        if not track.id and len(self.heads_camera):
            head = self.heads_camera[np.argmin(self._ways_m(track.place_camera))]
            others_m = [np.linalg.norm(head - other.place_camera) for other in tracks if other.id]
            if min(others_m, default=np.inf) < min(DOUBLE_M, away_m):
                return False
        return True if away_m < PERSON_M else False if away_m > FURNITURE_M else None

    def label_of_cluster(self, points_camera: Vector) -> bool | None:
        """Whether [N, 3] points that nobody explains are a person's, whose head is among them, or
        furniture's; None where that is hard to say."""
        ways_m = np.linalg.norm(points_camera[:, None] - self.heads_camera, axis=-1)
        nearest_m = float(ways_m.min(initial=np.inf))
        return True if nearest_m < IN_CLUSTER_M else False if nearest_m > APART_FROM_M else None

    def may_be(self, features: Features) -> bool:
        return True

    def existence_of(self, track: Track) -> float:
        return track.presence if track.id else super().existence_of(track)

    def has_ended(self, track: Track, scene: Scene) -> bool:
        return self.away_m(track.place_camera) > LOST_M if track.id else not track.is_seen

    def is_room(self, track: Track, scene: Scene) -> bool:
        return False

    def _is_ready(self, track: Track, scene: Scene, has_network: bool) -> bool:
        return track.is_seen and self.away_m(track.place_camera) < PERSON_M

    def away_m(self, place_camera: Vector) -> float:
        """From [3] to the nearest true head."""
        return float(self._ways_m(place_camera).min(initial=np.inf))

    def _ways_m(self, place_camera: Vector) -> Vector:
        """From [3] to each true head."""
        return np.linalg.norm(self.heads_camera - place_camera, axis=1)


class TruePeople(PeopleFinder):
    """The finder, told who is a person."""

    def __init__(self, existence: TrueExistence) -> None:
        super().__init__()
        self._existence = existence


def rows_of(recording: Recording, truth: TrueHeads, weights: Path | None = None) -> TrackRows:
    """What is seen of all who may be people in a recording; by a network with other weights than
    those that ship, where they are given.

    Raises:
        InputError: the recording cannot be tracked, or the truth has fewer frames.
    """
    existence = TrueExistence()
    finder = TruePeople(existence)
    settings = TrackerSettings(method="joints", threads=1, weights=weights)
    tracker = Tracker(settings, finder=finder)
    seen: list[tuple[Evidence, bool]] = []
    for frame in recording:
        existence.look_at(truth, frame.index)
        tracker.update(frame)
        tracks = () if finder.found is None else finder.found.tracks
        for track in tracks:
            is_head = track.is_seen and not track.evidence.by_body
            label = existence.label_of(track, tracks) if is_head else None
            if label is not None:
                seen.append((track.evidence, label))
    return TrackRows.of(seen)


@dataclass(frozen=True, slots=True, eq=False)
class Collected:
    """Of one recording: the rows, or None and why; what could not be read, one line each."""

    name: str
    rows: TrackRows | None
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CollectJob:
    """One recording to collect from, in any process, by a network with these weights."""

    recording: KnownPeople
    weights: Path | None = None

    def __call__(self) -> Collected:
        name = self.recording.name
        try:
            truth = self.recording.true_heads()
            recording = self.recording.open()
            rows = rows_of(recording, truth, self.weights)
        except InputError as error:
            return Collected(name, None, (f"{name}: {error}",))
        return Collected(name, rows, tuple(f"{name}: {line}" for line in recording.problems))
