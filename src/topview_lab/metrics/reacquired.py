"""How soon a joint that another person hid is found again (ours).

A joint comes back into view after another person hid `OUT_OF_SIGHT_FROM` of it or more, for
`HIDDEN_S` or longer. It is found again if it is within 10 cm in the first frame `FOUND_AFTER_S` or
more after the one in which less than `IN_VIEW_BELOW` of it is hidden, by whatever. It must stay in
view until then. Constant offsets are taken out.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.errors import Pool, position_errors, total_share
from topview_lab.metrics.facing import Held
from topview_lab.metrics.samples import CAUSES
from topview_lab.metrics.splits import HIDDEN_SHARES
from topview_lab.metrics.statistics import WITHIN

IN_VIEW_BELOW, OUT_OF_SIGHT_FROM = HIDDEN_SHARES
HIDDEN_S: Final = 0.5  # ours
FOUND_AFTER_S: Final = 0.1  # ours; three frames of most cameras
LONGEST_STEP_S: Final = 0.5  # ours; after a longer one it is not known what was hidden meanwhile
TIME_ROUNDING_S: Final = 1e-6  # of frames that are numbered, at rates that no double holds

_BY_PERSON: Final = CAUSES.index("another person")


def reacquired(pool: Pool) -> Held:
    """Of all joints that came back into view: whether they were within 10 cm soon after. Whoever is
    not found has no joint within 10 cm; joints that a system never tells do not count."""
    errors = position_errors(pool)
    distance_cm = np.where(np.isfinite(errors.offset_out), errors.offset_out, errors.raw)
    is_told = np.isfinite(distance_cm)
    counts = (is_told | ~pool.samples.found[:, None]) & is_told.any(0)
    frame, joint = comebacks(pool)
    counted = counts[frame, joint]
    return Held.of(distance_cm[frame, joint][counted] <= WITHIN)


def comebacks(pool: Pool) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """[C] person-frame and [C] joint in which each that came back into view is looked at."""
    samples = pool.samples
    by_person = samples.hidden[..., _BY_PERSON] >= OUT_OF_SIGHT_FROM
    in_view = total_share(samples.hidden) < IN_VIEW_BELOW
    found = [
        (rows[k], joint)
        for rows in _stretches(pool)
        for joint in range(in_view.shape[1])
        if by_person[rows, joint].any()
        for k in _looked_at(samples.time_s[rows], by_person[rows, joint], in_view[rows, joint])
    ]
    rows, joints = np.array(found, np.intp).reshape(-1, 2).T
    return rows, joints


def _stretches(pool: Pool) -> Iterator[NDArray[np.intp]]:
    """Indices of the person-frames of one person each, in the order of time and without gaps."""
    samples = pool.samples
    order = np.lexsort((samples.time_s, samples.person, pool.sequence))
    is_other = np.diff(pool.sequence[order]) + np.abs(np.diff(samples.person[order])) > 0
    is_other |= np.diff(samples.time_s[order]) > LONGEST_STEP_S
    yield from np.split(order, np.flatnonzero(is_other) + 1)


def _looked_at(
    time_s: NDArray[np.float64], by_person: NDArray[np.bool_], in_view: NDArray[np.bool_]
) -> Iterator[int]:
    """Index of the frame in which a joint is looked at, each time that it has come back."""
    hidden_since_s: float | None = None  # without interruption
    was_hidden = False  # for long enough, since it was in view
    for k, now_s in enumerate(time_s):
        if in_view[k]:
            if was_hidden:
                due_s = now_s + FOUND_AFTER_S - TIME_ROUNDING_S
                last = int(np.searchsorted(time_s, due_s))
                if last < len(time_s) and in_view[k : last + 1].all():
                    yield last
            was_hidden, hidden_since_s = False, None
        elif by_person[k]:
            hidden_since_s = now_s if hidden_since_s is None else hidden_since_s
            was_hidden |= now_s - hidden_since_s >= HIDDEN_S - TIME_ROUNDING_S
        else:
            hidden_since_s = None
