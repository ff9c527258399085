"""A user's stature: the highest that the head has stood over the floor."""

from __future__ import annotations

from collections import deque

import numpy as np

# Mean stature of adults, women and men together (NCD-RisC 2016: 1.59 m and 1.71 m; taller in the
# countries that have depth cameras).
PRIOR_HEIGHT_M = 1.72
MIN_HEIGHT_M, MAX_HEIGHT_M = 1.0, 2.1


class HeightEstimate:
    """Blends what has been measured of one user, frame by frame, with the mean of all people."""

    def __init__(self) -> None:
        self._measured_m: deque[float] = deque(maxlen=300)
        self.height_m = PRIOR_HEIGHT_M

    def add(self, head_top_over_sole_m: float) -> None:
        """One upright moment's distance from the ground to the top of the head, in metres."""
        if not MIN_HEIGHT_M < head_top_over_sole_m < MAX_HEIGHT_M:
            return
        self._measured_m.append(head_top_over_sole_m)
        # A quantile, not the maximum: noise and jumps reach higher than the person.
        self.height_m = float(np.quantile(np.array(self._measured_m), 0.8))
