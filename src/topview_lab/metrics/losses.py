"""How often people are lost: found once, then present, to be seen, and matched by nobody."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview_lab.metrics.errors import total_share
from topview_lab.metrics.samples import CAUSES, Samples

LOST_AFTER_S: Final = 0.5
"""Somebody who goes unmatched for so long is lost; seconds (ours)."""
LEAST_SEEN: Final = 0.3
"""Share of the joints that neither others nor objects hide, and that are in the image, from which
on somebody is to be seen (ours)."""
_NOT_ONESELF: Final = [CAUSES.index(cause) for cause in CAUSES if cause != "oneself"]


def times_lost(samples: Samples, fps: float) -> int:
    """How often people of one recording are lost.

    Somebody is lost who was matched before, and then goes unmatched for `LOST_AFTER_S` or more of
    consecutive frames, in each of which `LEAST_SEEN` of the joints are to be seen.

    Args:
        samples: of the recording; what is unknown to be hidden counts as seen.
        fps: frames per second of it.
    """
    hidden = np.nan_to_num(total_share(samples.hidden[..., _NOT_ONESELF]))
    is_missed = ~samples.found & (1.0 - hidden.mean(1) >= LEAST_SEEN)
    least = round(LOST_AFTER_S * fps)
    lost = 0
    for person in np.unique(samples.person):
        of = samples.person == person
        since = np.cumsum(samples.found[of]) > 0
        lost += sum(n >= least for n in _runs(samples.frame[of], is_missed[of] & since))
    return lost


def _runs(frame: NDArray[np.int64], chosen: NDArray[np.bool_]) -> list[int]:
    """Lengths of the runs of consecutive frames that are chosen."""
    frames = frame[chosen]
    ends = np.flatnonzero(np.diff(frames) != 1) + 1
    return [len(run) for run in np.split(frames, ends)]
