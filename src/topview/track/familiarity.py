"""How sure of proposed joints to be, of somebody like whom the proposer has seen few (ours).

A network states how sure it is of each joint, and that holds for people like those that it has
learnt from. Two things tell when it does not: its joints do not fit a body with the person's bones,
and it doubts, over time, that this is a person at all. A third tells it of single joints: where
people touch, nobody knows for sure whose pixels are whose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import JointProposals
from topview.filter.over_time import share_after

Array = NDArray[np.float64]

# Fitted by scripts/fit_familiarity.py, on rendered people in rooms and motions that the network has
# not learnt, seeds 100 to 103 of all kinds and 160 to 171 of hug and hidden, and on UTD-MHAD's
# subjects 1 and 2, a real sensor that no training has seen. How errors grow with the residual and
# towards others is what makes all errors likeliest; with the doubt's exponent 90 % of the intervals
# of 90 % hold on the worst axis of the worse of these subjects.
FIT_EXPONENT: Final = 0.26
DOUBT_EXPONENT: Final = 0.39
OTHERS_EXPONENT: Final = 0.37
OTHERS_REACH_M: Final = 0.21  # beyond which others do not count
# Of rendered people, seeds 0 to 9, the medians; from there on scales become wider.
FAMILIAR_RESIDUAL: Final = 0.089
FAMILIAR_DOUBT: Final = 0.0029
# All ours.
LEAST_RESIDUAL: Final = 0.02  # what differs below these says nothing
LEAST_DOUBT: Final = 0.001
LEAST_TO_OTHERS_M: Final = 0.02
DOUBT_MEMORY_S: Final = 5.0  # of the doubt; after which 63 % are new


@dataclass(frozen=True, slots=True)
class Familiarity:
    """What tells whether one person's window looks like those that were learnt.

    Attributes:
        residual: of the body that is fitted to the likeliest mode, in scales:
            `topview.track.joint_fit.robust_residual`.
        doubt: geometric mean over time of the probability that the window shows no person, 0..1.
    """

    residual: float = FAMILIAR_RESIDUAL
    doubt: float = FAMILIAR_DOUBT

    def trusted(self, proposals: JointProposals) -> JointProposals:
        """The same proposals of one person, as sure of each joint as they may be trusted to be."""
        own = self.widened(proposals)
        if own.to_others_m is None:
            return own
        beside = widening_beside(own.to_others_m)[..., None]
        return replace(own, scales_m=beside * own.scales_m)

    def widened(self, proposals: JointProposals) -> JointProposals:
        """The same with what tells of the person alone, to be weighed against the surface that is
        seen: near other people this is as doubtful as the joints are."""
        return replace(proposals, scales_m=self.widening * proposals.scales_m)

    @property
    def widening(self) -> float:
        """What the proposals' scales are to be multiplied by, 1 or more."""
        return float(widening_of(self.residual, self.doubt))


def widening_of(
    residual: float | Array,
    doubt: float | Array,
    fit_exponent: float = FIT_EXPONENT,
    doubt_exponent: float = DOUBT_EXPONENT,
) -> float | Array:
    """`Familiarity.widening`, of one or [N]."""
    fit = (residual + LEAST_RESIDUAL) / (FAMILIAR_RESIDUAL + LEAST_RESIDUAL)
    doubtful = (doubt + LEAST_DOUBT) / (FAMILIAR_DOUBT + LEAST_DOUBT)
    return np.maximum(1.0, fit**fit_exponent * doubtful**doubt_exponent)


def widening_beside(
    to_others_m: Array, exponent: float = OTHERS_EXPONENT, reach_m: float = OTHERS_REACH_M
) -> Array:
    """[...] what scales of joints at these distances from other people are to be multiplied by."""
    nearness = (reach_m + LEAST_TO_OTHERS_M) / (to_others_m + LEAST_TO_OTHERS_M)
    return np.maximum(1.0, nearness) ** exponent


FAMILIAR: Final = Familiarity()


class FamiliarityOverTime:
    """`Familiarity` of one person, from frame to frame.

    Attributes:
        now: after the last frame.
    """

    def __init__(self) -> None:
        self.now = FAMILIAR
        self._log_doubt = 0.0
        self._frames = 0

    def update(self, residual: float, p_person: float, elapsed_s: float) -> Familiarity:
        """After the next frame.

        Args:
            residual: as in `Familiarity`.
            p_person: probability that the frame's window shows a person.
            elapsed_s: since the frame before.
        """
        self._frames += 1
        share = max(share_after(elapsed_s, DOUBT_MEMORY_S), 1.0 / self._frames)
        self._log_doubt += share * (log(1.0 - p_person + LEAST_DOUBT) - self._log_doubt)
        self.now = Familiarity(residual, exp(self._log_doubt) - LEAST_DOUBT)
        return self.now
