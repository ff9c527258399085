"""How sure of proposed joints to be, of somebody like whom the proposer has seen few (ours).

A network states how sure it is of each joint, and that holds for people like those that it has
learnt from. Two things tell when it does not: its joints do not fit a body with the person's bones,
and it doubts, over time, that this is a person at all. And where it is hardly sure, it is less sure
still: most of those joints are hidden, and it has seen how those that it learnt from held them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, log
from typing import Final

import numpy as np

from topview.detect.joints import JointProposals
from topview.filter.over_time import share_after

# Fitted by scripts/fit_familiarity.py so that 90 % of the intervals of 90 % hold: of the joints of
# rendered people in rooms and motions that the network has not learnt, seeds 100 to 103, in view
# and hidden; and of UTD-MHAD's subjects 1 and 2, a real sensor that no training has seen, on the
# worst axis of the worse subject.
FAMILIAR_SHARE: Final = 0.89  # of the scales as stated, where all looks familiar
FIT_EXPONENT: Final = 0.23
DOUBT_EXPONENT: Final = 0.475
LARGE_EXPONENT: Final = 0.125
# Of rendered people, seeds 0 to 9, the medians; from there on scales become wider.
FAMILIAR_RESIDUAL: Final = 0.089
FAMILIAR_DOUBT: Final = 0.0029
# All ours.
LARGE_SCALE_M: Final = 0.012  # where few joints in view are less sure
LEAST_RESIDUAL: Final = 0.02  # what differs below these says nothing
LEAST_DOUBT: Final = 0.001
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
        large = np.maximum(1.0, proposals.scales_m / LARGE_SCALE_M) ** LARGE_EXPONENT
        share = FAMILIAR_SHARE * self.widening
        return replace(proposals, scales_m=share * large * proposals.scales_m)

    @property
    def widening(self) -> float:
        """How much wider scales are to be taken for than of who looks familiar, 1 or more."""
        residual = (self.residual + LEAST_RESIDUAL) / (FAMILIAR_RESIDUAL + LEAST_RESIDUAL)
        doubt = (self.doubt + LEAST_DOUBT) / (FAMILIAR_DOUBT + LEAST_DOUBT)
        return max(1.0, residual**FIT_EXPONENT * doubt**DOUBT_EXPONENT)


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
