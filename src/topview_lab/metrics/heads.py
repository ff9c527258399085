"""Who was found, when, and under which id, counted by people's heads.

In each frame every track that is put out, one that coasts too, and the true heads of everybody in
the room are matched one to one: fewest left over, then nearest. Somebody is due while present and
to be seen by enough; finding somebody who is not due counts neither way. A track that matches
nobody is false.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError, read_only
from topview_lab.metrics.matching import NOBODY, match_heads, people_distances, people_matched
from topview_lab.metrics.reference import SHARE_ROUNDING
from topview_lab.metrics.statistics import share

# All ours.
HEAD_GATE_M: Final = 0.4
"""Gate between tracked and true heads: two people who touch."""
LEAST_TO_BE_SEEN: Final = 0.3
"""Share of a person to be seen, from which the person is due."""
CLEARLY_TO_BE_SEEN: Final = 0.5
"""Share from which the time runs until the person is found."""
OUTSIDE_FROM: Final = 0.9
"""Share outside the image from which a person is outside."""
FORGOTTEN_AFTER_S: Final = 1.0
"""Whoever was outside for longer may come back under another id."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueHeads:
    """Where people's heads truly are, and how much of the people there is to be seen.

    Attributes:
        heads_camera: [F, R, 3] metres, NaN for whoever is not in the room.
        to_be_seen: [F, R] share that nothing hides and that lies inside of the image.
        outside: [F, R] share that lies outside of the image.
        is_present: [F, R] whether enough of the person is inside to be due at all.

    Raises:
        InputError: shapes that do not fit, or shares that are none.
    """

    heads_camera: NDArray[np.float64]
    to_be_seen: NDArray[np.float64]
    outside: NDArray[np.float64]
    is_present: NDArray[np.bool_]

    def __post_init__(self) -> None:
        F, R = self.heads_camera.shape[:2]
        for name, shape in (
            ("heads_camera", (F, R, 3)),
            ("to_be_seen", (F, R)),
            ("outside", (F, R)),
            ("is_present", (F, R)),
        ):
            values = getattr(self, name)
            if values.shape != shape:
                raise InputError(f"{name} is {values.shape}; it must be {shape}")
            read_only(values)
        for name in ("to_be_seen", "outside"):
            shares = getattr(self, name)
            if (wrong := (shares < -SHARE_ROUNDING) | (shares > 1.0 + SHARE_ROUNDING)).any():
                raise InputError(f"{name} holds {shares[wrong][0]:g}; a share must be 0 to 1")

    def of_frames(self, frames: NDArray[np.int64]) -> TrueHeads:
        """Those of some frames.

        Raises:
            InputError: there are fewer.
        """
        if len(beyond := frames[frames >= len(self.heads_camera)]):
            raise InputError(
                f"frame {beyond[0]} was tracked; the truth has {len(self.heads_camera)} frames"
            )
        return TrueHeads(
            self.heads_camera[frames],
            self.to_be_seen[frames],
            self.outside[frames],
            self.is_present[frames],
        )

    @property
    def is_in_room(self) -> NDArray[np.bool_]:
        """[F, R]."""
        return np.asarray(np.isfinite(self.heads_camera).all(axis=-1))

    @property
    def is_due(self) -> NDArray[np.bool_]:
        """[F, R] who has to be found."""
        return self.is_in_room & self.is_present & (self.to_be_seen >= LEAST_TO_BE_SEEN)

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """[F, R]."""
        return ~self.is_in_room | (self.outside >= OUTSIDE_FROM)


@dataclass(frozen=True, slots=True, eq=False)
class PersonFound:
    """How well one person was found in one recording.

    Attributes:
        frames: in which the person was due.
        errors_m: [N] distances of the head in those of them in which the person was found.
        wait_s: from the first frame in which the person is clearly to be seen until found, infinite
            if never, 0 if found before; None if there is no such frame.
        swaps: times that the person went on under an id that had been another person's.
        fragments: times that the person went on under a fresh id.
        returns: times that the person was found again after frames without being due.
        kept: of these, with the same id.
    """

    frames: int
    errors_m: NDArray[np.float64]
    wait_s: float | None
    swaps: int
    fragments: int
    returns: int
    kept: int


@dataclass(frozen=True, slots=True, eq=False)
class PeopleFound:
    """One recording.

    Attributes:
        frames: how many.
        false: tracks that match nobody, summed over frames.
        people: in the order of the truth.
    """

    frames: int
    false: int
    people: tuple[PersonFound, ...]

    @property
    def exchanges(self) -> int:
        """Times that somebody went on under another id."""
        return sum(person.swaps + person.fragments for person in self.people)

    @property
    def due(self) -> int:
        """Person-frames."""
        return due_of(self.people)

    @property
    def recall(self) -> float:
        """Share of the person-frames that were due, NaN where none was."""
        return recall_of(self.people)


def due_of(people: Iterable[PersonFound]) -> int:
    """Person-frames that had to be found."""
    return sum(person.frames for person in people)


def recall_of(people: Sequence[PersonFound]) -> float:
    """Share of them that were, NaN where there was none."""
    return share(sum(len(person.errors_m) for person in people), due_of(people))


def measure_heads(
    truth: TrueHeads,
    found_camera: NDArray[np.float64],
    ids: NDArray[np.int64],
    times_s: NDArray[np.float64],
) -> PeopleFound:
    """Compare heads with the truth.

    Args:
        truth: of F frames and R people.
        found_camera: [F, S, 3] metres, NaN in slots without anybody.
        ids: [F, S] of whoever is in each slot.
        times_s: [F].
    """
    matches, distances_m = match_true_heads(truth, found_camera)
    matched_ids = people_matched(matches, ids)
    firsts = [_first_seen(own) for own in matched_ids.T]
    is_due, is_outside = truth.is_due, truth.is_outside
    is_clear = is_due & (truth.to_be_seen >= CLEARLY_TO_BE_SEEN)
    people = []
    for r in range(matches.shape[1]):
        due = np.flatnonzero(is_due[:, r] & (matches[:, r] != NOBODY))
        changes = list(_changes(matched_ids[:, r], is_outside[:, r], times_s))
        others = [*firsts[:r], *firsts[r + 1 :]]
        swaps = sum(
            any(first.get(new, frame + 1) <= frame for first in others) for frame, new in changes
        )
        returns, kept = _returns(matched_ids[:, r], is_due[:, r])
        people.append(
            PersonFound(
                int(is_due[:, r].sum()),
                distances_m[due, r, matches[due, r]],
                _wait_s(matches[:, r] != NOBODY, is_clear[:, r], times_s),
                swaps,
                len(changes) - swaps,
                returns,
                kept,
            )
        )
    is_found = np.isfinite(found_camera).all(axis=-1)
    false = int(is_found.sum() - (matches != NOBODY).sum())
    return PeopleFound(len(times_s), false, tuple(people))


def match_true_heads(
    truth: TrueHeads, found_camera: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """[F, R] the slot of the [F, S, 3] heads, metres, that is each true head's, or `NOBODY`; and
    the [F, R, S] distances, metres."""
    distances_m = people_distances(truth.heads_camera[:, :, None], found_camera[:, :, None])
    return match_heads(distances_m, HEAD_GATE_M), distances_m


def _first_seen(ids: NDArray[np.int64]) -> dict[int, int]:
    """The first frame of each of the [F] ids that a person had."""
    first: dict[int, int] = {}
    for frame in np.flatnonzero(ids != NOBODY):
        first.setdefault(int(ids[frame]), int(frame))
    return first


def _changes(
    ids: NDArray[np.int64], is_outside: NDArray[np.bool_], times_s: NDArray[np.float64]
) -> Iterator[tuple[int, int]]:
    """Frame and new id of each change of a person's [F] ids that a stay outside does not excuse."""
    found = np.flatnonzero(ids != NOBODY)
    lasts_s = np.diff(times_s, append=times_s[-1:])
    for before, after in zip(found[:-1], found[1:], strict=True):
        outside_s = lasts_s[before:after][is_outside[before:after]].sum()
        if ids[before] != ids[after] and outside_s <= FORGOTTEN_AFTER_S:
            yield int(after), int(ids[after])


def _wait_s(
    is_found: NDArray[np.bool_], is_clear: NDArray[np.bool_], times_s: NDArray[np.float64]
) -> float | None:
    """From the first frame in which a person is clearly to be seen to that in which found."""
    if not is_clear.any():
        return None
    if not is_found.any():
        return np.inf
    return max(0.0, float(times_s[np.argmax(is_found)] - times_s[np.argmax(is_clear)]))


def _returns(ids: NDArray[np.int64], is_due: NDArray[np.bool_]) -> tuple[int, int]:
    """How often a person with [F] ids was due and found again after not being due; how often with
    the same id."""
    returns = kept = 0
    found = np.flatnonzero((ids != NOBODY) & is_due)
    for before, after in zip(found[:-1], found[1:], strict=True):
        if not is_due[before:after].all():
            returns += 1
            kept += int(ids[before] == ids[after])
    return returns, kept
