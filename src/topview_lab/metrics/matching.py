"""Match predicted people to reference people, frame by frame.

As in the CLEAR MOT metrics (Bernardin & Stiefelhagen, "Evaluating multiple object tracking
performance", EURASIP J. Image and Video Processing 2008, Sec. 2.1): a match of the frame before
is kept while it is valid, everyone else is matched by least total distance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from topview_lab.metrics.statistics import share

PERSON_GATE_M: Final = 0.5  # ours: about half the shoulder breadths of two people side by side
NOBODY: Final = -1


def people_distances(
    reference_camera: NDArray[np.float64], predicted_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[F, R, S] mean distance over the joints that both have, infinite where there are none.

    Args:
        reference_camera: [F, R, J, 3] metres, NaN where unknown or absent.
        predicted_camera: [F, S, J, 3] metres, NaN where absent.
    """
    F, R = reference_camera.shape[:2]
    mean_m = np.full((F, R, predicted_camera.shape[1]), np.inf)
    for r in range(R):  # one by one: of many people, the joints take much memory
        distances = np.linalg.norm(reference_camera[:, r, None] - predicted_camera, axis=-1)
        known = np.isfinite(distances)
        total = np.where(known, distances, 0.0).sum(-1)
        np.divide(total, known.sum(-1), out=mean_m[:, r], where=known.any(-1))
    return mean_m


def match_people(
    distances_m: NDArray[np.float64],
    gate_m: float = PERSON_GATE_M,
    who: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]:
    """[F, R] the slot of the predicted person matched to each reference person, or -1.

    Args:
        distances_m: [F, R, S] as from `people_distances`.
        gate_m: people further apart than this mean joint distance are never matched.
        who: [F, S] who is in each slot; each slot is a person throughout if not told.
    """
    F, R, S = distances_m.shape
    who = people_in_slots(who, F, S)
    matches = np.full((F, R), NOBODY, np.int64)
    before: dict[int, int] = {}  # reference person: the predicted one of the frame before
    for f, distances in enumerate(distances_m):
        slot_of = {int(p): s for s, p in enumerate(who[f])}
        kept = {r: slot_of[p] for r, p in before.items() if p in slot_of}
        matches[f] = _match_frame(distances, kept, gate_m)
        before = {r: int(who[f, s]) for r, s in enumerate(matches[f]) if s != NOBODY}
    return matches


def _match_frame(
    distances_m: NDArray[np.float64], before: Mapping[int, int], gate_m: float
) -> NDArray[np.int64]:
    """[R] matches of one frame from its [R, S] distances and the slots in which those are who were
    matched in the frame before."""
    matches = np.full(len(distances_m), NOBODY, np.int64)
    for r, slot in before.items():
        if distances_m[r, slot] <= gate_m:
            matches[r] = slot
    open_r = np.flatnonzero(matches == NOBODY)
    open_p = np.setdiff1d(np.arange(distances_m.shape[1]), matches)
    cost = distances_m[np.ix_(open_r, open_p)]
    # Dearer than any set of valid pairs, so that as many people as possible are matched.
    beyond_gate = gate_m * (len(matches) + 1)
    rows, columns = linear_sum_assignment(np.where(cost <= gate_m, cost, beyond_gate))
    for i, j in zip(rows, columns, strict=True):
        if cost[i, j] <= gate_m:
            matches[open_r[i]] = open_p[j]
    return matches


def match_heads(distances_m: NDArray[np.float64], gate_m: float) -> NDArray[np.int64]:
    """[F, R] the slot matched to each reference person, or -1: as many as possible, then those of
    least total distance, whoever was matched before.

    Args:
        distances_m: [F, R, S] as from `people_distances`.
        gate_m: who are further apart are never matched.
    """
    matches = [_match_frame(distances, {}, gate_m) for distances in distances_m]
    return np.array(matches, np.int64).reshape(distances_m.shape[:2])


@dataclass(frozen=True, slots=True)
class PeopleCounts:
    """Counts of detections and identities; they add up over recordings.

    Attributes:
        frames: evaluated: those that both the reference and the tracker have.
        frames_unread: the reference has them, the tracker does not.
        person_frames: reference people present, summed over frames.
        missed: of those, without a predicted person.
        false_person_frames: predicted people that match nobody, summed over frames.
        false_people: predicted ids that never match anybody.
        id_swaps: a reference person continues under another id, or appears under an id that was
            somebody else's; two people who exchange ids count two.
        mismatches: those swaps in which a reference person goes on under another id: the ones
            that CLEAR MOT counts.
        frames_lost: somebody was present, and nobody of them was found.
    """

    frames: int = 0
    frames_unread: int = 0
    person_frames: int = 0
    missed: int = 0
    false_person_frames: int = 0
    false_people: int = 0
    id_swaps: int = 0
    mismatches: int = 0
    frames_lost: int = 0

    def __add__(self, other: PeopleCounts) -> PeopleCounts:
        return PeopleCounts(
            **{field.name: getattr(self, field.name) + getattr(other, field.name)
               for field in fields(self)}
        )  # fmt: skip

    @property
    def recall(self) -> float:
        """Share of the present person-frames that were found, NaN if nobody was present."""
        return share(self.person_frames - self.missed, self.person_frames)

    @property
    def precision(self) -> float:
        """Share of the predicted person-frames that match somebody, NaN if none was predicted."""
        found = self.person_frames - self.missed
        return share(found, found + self.false_person_frames)


def count_people(
    matches: NDArray[np.int64],
    reference_present: NDArray[np.bool_],
    predicted_present: NDArray[np.bool_],
    frames_unread: int = 0,
    who: NDArray[np.int64] | None = None,
) -> PeopleCounts:
    """Counts of one recording.

    Args:
        matches: [F, R] as from `match_people`.
        reference_present: [F, R].
        predicted_present: [F, S].
        frames_unread: see `PeopleCounts`.
        who: [F, S] as of `match_people`.
    """
    F, S = predicted_present.shape
    who = people_in_slots(who, F, S)
    found = matches != NOBODY
    is_matched = np.zeros((F, S), bool)
    frames, people = np.nonzero(found)
    is_matched[frames, matches[frames, people]] = True
    mismatches, handed_on = _count_swaps(people_matched(matches, who))
    return PeopleCounts(
        frames=F,
        frames_unread=frames_unread,
        person_frames=int(reference_present.sum()),
        missed=int((reference_present & ~found).sum()),
        false_person_frames=int((predicted_present & ~is_matched).sum()),
        false_people=len(np.setdiff1d(who[predicted_present], who[is_matched])),
        id_swaps=mismatches + handed_on,
        mismatches=mismatches,
        frames_lost=int((reference_present.any(1) & ~found.any(1)).sum()),
    )


def people_in_slots(who: NDArray[np.int64] | None, F: int, S: int) -> NDArray[np.int64]:
    """[F, S] who is in each slot; each slot is a person throughout if that is not told."""
    return np.tile(np.arange(S), (F, 1)) if who is None else who


def people_matched(matches: NDArray[np.int64], who: NDArray[np.int64]) -> NDArray[np.int64]:
    """[F, R] who was matched, of [F, R] slots, or -1."""
    frames, people = np.nonzero(matches != NOBODY)
    matched = np.full(matches.shape, NOBODY, np.int64)
    matched[frames, people] = who[frames, matches[frames, people]]
    return matched


def _count_swaps(matches: NDArray[np.int64]) -> tuple[int, int]:
    """Of [F, R] matched people: who go on under another id; who appear under somebody else's."""
    id_of: dict[int, int] = {}
    owner_of: dict[int, int] = {}
    mismatches = handed_on = 0
    for frame in matches:
        pairs = [(r, int(p)) for r, p in enumerate(frame) if p != NOBODY]
        mismatches += sum(id_of.get(r, p) != p for r, p in pairs)
        handed_on += sum(r not in id_of and owner_of.get(p, r) != r for r, p in pairs)
        id_of.update(pairs)
        owner_of.update((p, r) for r, p in pairs)
    return mismatches, handed_on
