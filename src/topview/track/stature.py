"""Which stature somebody has, by what a body of it leaves unexplained (ours).

The finder measures the stature of who stands upright, and now and then takes who sits for a small
person who stands. Of who sits from the first frame on it measures none. So where the pose leaves
much unexplained other statures are tried, one a frame, and the one that over time explains more is
believed. Where a method learns a stature from the surface that is seen, that one is believed, as
long as a body of it explains what is seen.
"""

from __future__ import annotations

from math import log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.people.height import PRIOR_HEIGHT_M

Array = NDArray[np.float64]

# All ours. A cost is the share of the person's points that a pose leaves unexplained, and what a
# method adds to it.
TRIED_STATURES_M: Array = np.array([1.25, 1.4, 1.55, 1.72, 1.9])
# Of a stature, per logarithm of its ratio to the measured one, or before to adults' mean.
MEASURED_COST: Final = 0.2
ADULTS_COST: Final = 0.05
# By so much logarithms of statures differ: of one that was given, or measured by the finder, and
# adults' from their mean.
GIVEN_SIGMA, MEASURED_SIGMA, ADULTS_SIGMA = 0.001, 0.02, 0.08
LOOKS: Final = 10.0  # at a stature, over which its gain is averaged
LEAST_LOOKS: Final = 3  # at one before it is believed
LEAST_STATURE_GAIN: Final = 0.02


class StatureBelief:
    """One person's stature over time.

    Attributes:
        stature_m: that is believed.
        is_given: whether it is known beforehand, and not doubted.
        is_measured: whether the finder has measured one.
    """

    def __init__(self, is_given: bool = False) -> None:
        self.is_given = is_given
        self.stature_m = self._likely_m = PRIOR_HEIGHT_M
        self.is_measured = False
        self._is_learnt = False  # from what is seen of a body of it
        self._is_judged = False  # better than the one that was believed before
        self._turn = 0
        self._forget()

    def _forget(self) -> None:
        self._gains = np.zeros(len(TRIED_STATURES_M) + 1)
        self._looks = np.zeros(len(TRIED_STATURES_M) + 1)

    @property
    def _tried_m(self) -> float:
        return float(np.append(TRIED_STATURES_M, self._likely_m)[self._turn])

    def begin(self, stature_m: float) -> None:
        """With the stature of the first poses, while the finder has measured none."""
        self.stature_m = stature_m

    def tell(self, stature_m: float) -> None:
        """What the finder has measured."""
        if not (self._is_learnt or self._is_judged):
            self.stature_m = stature_m
        self._likely_m, self.is_measured = stature_m, True

    @property
    def prior(self) -> tuple[float, float]:
        """Metres before anything is learnt from the body's surface, and by how much the logarithm
        differs from that."""
        if not self.is_measured:
            return PRIOR_HEIGHT_M, ADULTS_SIGMA
        return self._likely_m, GIVEN_SIGMA if self.is_given else MEASURED_SIGMA

    def learn(self, stature_m: float) -> None:
        """One that has been learnt from what is seen."""
        if not self.is_given:
            self.stature_m, self._is_learnt = stature_m, True

    def unlearn(self) -> bool:
        """A body of what was learnt does not explain what is seen: the finder's measure is believed
        again, if there is one that has not been judged to be wrong. Whether that is so."""
        if not self._is_learnt or not self.is_measured or self._is_judged:
            return False
        self.stature_m, self._is_learnt = self._likely_m, False
        return True

    def is_doubted(self, is_lost: bool) -> bool:
        """Whether another is to be tried: where the pose is lost, and while none is measured."""
        return not self.is_given and (is_lost or not self.is_measured)

    def next_m(self) -> float:
        """Which stature is to be tried."""
        self._turn = (self._turn + 1) % len(self._gains)
        return self._tried_m

    def judge(self, cost: float, tried_cost: float) -> None:
        """What a body costs of the stature that is believed, and of the one that was tried."""
        gain = self._with_prior(cost, self.stature_m) - self._with_prior(tried_cost, self._tried_m)
        self._looks[self._turn] += 1.0
        looks = self._looks[self._turn]
        self._gains[self._turn] += (gain - self._gains[self._turn]) / min(looks, LOOKS)
        if looks >= LEAST_LOOKS and self._gains[self._turn] > LEAST_STATURE_GAIN:
            self.stature_m, self._is_judged = self._tried_m, True
            self._forget()

    def _with_prior(self, cost: float, stature_m: float) -> float:
        if not self.is_measured:
            return cost + adults_cost(stature_m)
        return cost + MEASURED_COST * abs(log(stature_m / self._likely_m))


def adults_cost(stature_m: float) -> float:
    """What speaks against a stature while none is measured: people are mostly adults."""
    return ADULTS_COST * abs(log(stature_m / PRIOR_HEIGHT_M))
