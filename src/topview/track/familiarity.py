"""How much less sure proposed joints are of somebody like whom the proposer has seen few (ours).

A network states how sure it is of each joint, and that holds for people like those that it has
learnt from. Two things tell when it does not: its joints do not fit a body with the person's bones,
and it doubts, over time, that this is a person at all.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log
from typing import Final

from topview.filter.over_time import share_after

# Fitted by scripts/fit_familiarity.py on UTD-MHAD, subjects 1 and 2, a real sensor that no training
# has seen, and on rendered people, seeds 0 to 9; that of the doubt so that of the intervals of 90 %
# of these subjects 90 % hold.
FIT_EXPONENT: Final = 0.245
DOUBT_EXPONENT: Final = 0.3
# Of these rendered people, the median; from there on scales become wider.
FAMILIAR_RESIDUAL: Final = 0.089
FAMILIAR_DOUBT: Final = 0.0029
# All ours.
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

    @property
    def widening(self) -> float:
        """What the proposals' scales are to be multiplied by, 1 or more."""
        residual = (self.residual + LEAST_RESIDUAL) / (FAMILIAR_RESIDUAL + LEAST_RESIDUAL)
        doubt = (self.doubt + LEAST_DOUBT) / (FAMILIAR_DOUBT + LEAST_DOUBT)
        return max(1.0, residual**FIT_EXPONENT * doubt**DOUBT_EXPONENT)


FAMILIAR: Final = Familiarity()


class FamiliarityOverTime:
    """`Familiarity` of one person, from frame to frame."""

    def __init__(self) -> None:
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
        return Familiarity(residual, exp(self._log_doubt) - LEAST_DOUBT)
