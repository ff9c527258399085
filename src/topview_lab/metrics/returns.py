"""Who was hidden entirely and comes back: under the same identity? (ours)"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.heads import CLEARLY_TO_BE_SEEN, TrueHeads, match_true_heads
from topview_lab.metrics.matching import NOBODY, people_matched
from topview_lab.metrics.statistics import share

HIDDEN_UP_TO: Final = 0.1
"""Of whom no larger share is to be seen is hidden entirely: a hand and a heel. Ours."""


@dataclass(frozen=True, slots=True)
class Return:
    """Somebody who was hidden entirely, once, and came back.

    Attributes:
        hidden_s: for how long.
        wait_s: from the first frame afterwards in which the person is clearly to be seen until
            found; infinite if never, 0 if found before.
        kept: whether the person was found before, and afterwards, in every frame in which found,
            with the id of just before.
    """

    hidden_s: float
    wait_s: float
    kept: bool


def score_return(
    truth: TrueHeads,
    found_camera: NDArray[np.float64],
    ids: NDArray[np.int64],
    times_s: NDArray[np.float64],
    person: int,
) -> Return:
    """Of one person, whose longest time hidden counts.

    Args:
        truth: of F frames and R people.
        found_camera: [F, S, 3] heads, metres, NaN in slots without anybody.
        ids: [F, S] of whoever is in each slot.
        times_s: [F].
        person: index of the person in the truth; hidden once at least, and to be seen later.
    """
    to_be_seen = truth.to_be_seen[:, person]
    first, last = _longest(to_be_seen <= HIDDEN_UP_TO)
    matches, _ = match_true_heads(truth, found_camera)
    own_ids = people_matched(matches, ids)[:, person]
    before = own_ids[:first][own_ids[:first] != NOBODY]
    is_found = own_ids[last + 1 :] != NOBODY
    after = own_ids[last + 1 :][is_found]
    clear = int(np.argmax(to_be_seen[last + 1 :] >= CLEARLY_TO_BE_SEEN))
    later_s = times_s[last + 1 :]
    wait_s = float(later_s[np.argmax(is_found)] - later_s[clear]) if is_found.any() else np.inf
    kept = bool(before.size and after.size and (after == before[-1]).all())
    return Return(float(times_s[last + 1] - times_s[first]), max(wait_s, 0.0), kept)


def _longest(holds: NDArray[np.bool_]) -> tuple[int, int]:
    """The first and last index of the longest stretch of [F] in which something holds."""
    steps = np.flatnonzero(np.diff(holds, prepend=False, append=False))
    firsts, ends = steps[::2], steps[1::2]
    longest = int(np.argmax(ends - firsts))
    return int(firsts[longest]), int(ends[longest]) - 1


@dataclass(frozen=True, slots=True)
class ReturnsSummary:
    """Of several returns.

    Attributes:
        count: how many.
        hidden_s: for how long, on average.
        kept: share 0..1 with the same identity.
        found: share 0..1 who were found again at all.
        wait_median_s, wait_95_s: until then; infinite where that many never were.
    """

    count: int
    hidden_s: float
    kept: float
    found: float
    wait_median_s: float
    wait_95_s: float


def summarise_returns(returns: Sequence[Return]) -> ReturnsSummary:
    """Of at least one."""
    waits_s = np.array([each.wait_s for each in returns])
    median_s, late_s = np.quantile(waits_s, (0.5, 0.95), method="inverted_cdf")
    return ReturnsSummary(
        len(returns),
        float(np.mean([each.hidden_s for each in returns])),
        share(sum(each.kept for each in returns), len(returns)),
        share(int(np.isfinite(waits_s).sum()), len(returns)),
        float(median_s),
        float(late_s),
    )
