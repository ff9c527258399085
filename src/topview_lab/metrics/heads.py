"""Detection of people by their heads: who was found, when, where, and under which id."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.matching import (
    NOBODY,
    count_people,
    match_people,
    people_distances,
)

HEAD_GATE_M: Final = 0.4
"""Gate between detected and true heads (ours: two people who touch)."""
LEAST_VISIBLE_SHARE: Final = 0.4
"""A person counts in frames with at least this visible share (ours)."""
HIDDEN_BELOW_SHARE: Final = 0.05
"""A person with a smaller visible share is hidden (ours)."""
LONGEST_HIDDEN_S: Final = 5.0
"""After a longer occlusion a new id is allowed (ours)."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonFound:
    """How well one person was found in one recording.

    Attributes:
        frames: number of frames with enough of the person visible (`LEAST_VISIBLE_SHARE`).
        errors_m: [N] distances of the head in those frames in which the person was found.
        wait_s: from the first such frame until the person was found, infinite if never; None if
            there is no such frame.
        returns: number of times that the person reappeared after an occlusion.
        kept: number of these with the same id afterwards.
    """

    frames: int
    errors_m: NDArray[np.float64]
    wait_s: float | None
    returns: int
    kept: int


@dataclass(frozen=True, slots=True, eq=False)
class PeopleFound:
    """One recording.

    Attributes:
        frames: how many.
        false: false positives, summed over frames.
        false_hidden: those of them that were predicted for hidden people and not seen.
        swaps: identity swaps of visible people.
        people: in the order of the truth.
    """

    frames: int
    false: int
    false_hidden: int
    swaps: int
    people: tuple[PersonFound, ...]


def measure_heads(
    heads_camera: NDArray[np.float64],
    visible: NDArray[np.float64],
    times_s: NDArray[np.float64],
    found_camera: NDArray[np.float64],
    is_seen: NDArray[np.bool_],
) -> PeopleFound:
    """Compare heads with the truth.

    Args:
        heads_camera: [F, R, 3] metres, true centres.
        visible: [F, R] share 0..1 of each person that neither others nor things hide and that is
            not out of view.
        times_s: [F].
        found_camera: [F, P, 3] metres, by id; NaN where there is no such user.
        is_seen: [F, P] False where a head was predicted.
    """
    is_visible = visible >= LEAST_VISIBLE_SHARE
    reference = np.where(is_visible[..., None], heads_camera, np.nan)[:, :, None]
    distances_m = people_distances(reference, found_camera[:, :, None])
    matches = match_people(distances_m, HEAD_GATE_M)
    is_found = np.asarray(np.isfinite(found_camera).all(-1))
    counts = count_people(matches, is_visible, is_found)
    to_anybody = people_distances(heads_camera[:, :, None], found_camera[:, :, None])
    is_false = is_found & (to_anybody.min(1, initial=np.inf) > HEAD_GATE_M)
    people = tuple(
        _person(matches[:, r], distances_m[:, r], visible[:, r], times_s)
        for r in range(visible.shape[1])
    )
    return PeopleFound(
        frames=len(times_s),
        false=int(is_false.sum()),
        false_hidden=int((is_false & ~is_seen).sum()),
        swaps=counts.id_swaps,
        people=people,
    )


def _person(
    matches: NDArray[np.int64],
    distances_m: NDArray[np.float64],
    visible: NDArray[np.float64],
    times_s: NDArray[np.float64],
) -> PersonFound:
    """From [F] matches, [F, P] distances and [F] shares."""
    shown = np.flatnonzero(visible >= LEAST_VISIBLE_SHARE)
    found = np.flatnonzero(matches != NOBODY)
    wait_s = None
    if len(shown):
        wait_s = float(times_s[found[0]] - times_s[shown[0]]) if len(found) else np.inf
    returns, kept = _returns(matches, visible, times_s)
    return PersonFound(len(shown), distances_m[found, matches[found]], wait_s, returns, kept)


def _returns(
    matches: NDArray[np.int64], visible: NDArray[np.float64], times_s: NDArray[np.float64]
) -> tuple[int, int]:
    """Number of reappearances of a found person, and of those with the same id."""
    returns = kept = 0
    last = last_f = NOBODY
    for f in np.flatnonzero(matches != NOBODY):
        was_hidden = last != NOBODY and (visible[last_f:f] < HIDDEN_BELOW_SHARE).any()
        if was_hidden and times_s[f] - times_s[last_f] <= LONGEST_HIDDEN_S:
            returns += 1
            kept += matches[f] == last
        last, last_f = matches[f], f
    return returns, int(kept)
