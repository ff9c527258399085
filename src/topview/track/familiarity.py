"""How sure to be of proposed joints, of somebody like whom the proposer has seen few (ours).

A network states how sure it is of each joint, and that holds for people like those that it has
learnt from. Two things tell when it does not: its joints do not fit a body with the person's bones,
and it doubts, over time, that this is a person at all. Two more tell it of single joints: what it
says of one jumps from frame to frame, as it looks by turns at what is there and in the mirror; and
others are before the joint or beside it, so that nobody knows for sure whether it is hidden.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import JointProposals
from topview.filter.over_time import share_after

Array = NDArray[np.float64]

# Fitted by scripts/fit_familiarity.py for the tenth network, on rendered people in rooms and
# motions that it has not learnt, seeds 100 to 103 of all kinds and 160 to 171 of hug and hidden,
# and on UTD-MHAD's subjects 1 and 2, a real sensor that no training has seen. How errors grow with
# the residual, with disagreement and towards cover is what makes all errors likeliest. With the
# doubt's exponent 90 % of the intervals of 90 % hold on the worst axis of the worse of these
# subjects; with the familiar disagreement 93.3 % hold of rendered joints in view, of people whom
# the network knows, so that 90 % hold when they are stretched to other proportions.
FIT_EXPONENT: Final = 0.289
DOUBT_EXPONENT: Final = 0.525
DISAGREEMENT_EXPONENT: Final = 0.210
COVER_EXPONENT: Final = 0.178
COVER_REACH_M: Final = 0.677  # beyond which others do not count
FAMILIAR_DISAGREEMENT: Final = 0.241
# Of rendered people, 20 recordings of seeds 0 to 9, the medians; from there on scales become wider.
FAMILIAR_RESIDUAL: Final = 0.092
FAMILIAR_DOUBT: Final = 0.00025
# All ours.
LEAST_RESIDUAL: Final = 0.02  # what differs below these says nothing
LEAST_DOUBT: Final = 0.001
LEAST_DISAGREEMENT: Final = 0.02
LEAST_TO_COVER_M: Final = 0.02
DOUBT_MEMORY_S: Final = 5.0  # of the doubt; after which 63 % are new
DISAGREEMENT_MEMORY_S: Final = 0.2  # the same of disagreement
ACCELERATION_M_S2: Final = 5.0  # of joints; what this moves is no disagreement
LONGEST_STEP_S: Final = 0.5  # from frame to frame; after longer ones nothing is expected


@dataclass(frozen=True, slots=True, eq=False)
class Familiarity:
    """What tells whether one person's window looks like those that were learnt.

    Attributes:
        residual: of the body that is fitted to the likeliest mode, in scales:
            `topview.track.joint_fit.robust_residual`.
        doubt: geometric mean over time of the probability that the window shows no person, 0..1.
        disagreement: [J, 3] of each proposed joint, as `DisagreementOverTime` tells it; None before
            there is any.
    """

    residual: float = FAMILIAR_RESIDUAL
    doubt: float = FAMILIAR_DOUBT
    disagreement: Array | None = None

    def trusted_scales_m(self, proposals: JointProposals) -> Array:
        """[1, M, J, 3] scales of one person's proposals, as sure of each joint as they may be
        trusted to be."""
        scales_m = self.widened_scales_m(proposals)
        if self.disagreement is not None:
            scales_m = scales_m * widening_unsteady(self.disagreement)
        if proposals.to_cover_m is not None:
            scales_m = scales_m * widening_beside(proposals.to_cover_m)[..., None]
        return scales_m

    def widened_scales_m(self, proposals: JointProposals) -> Array:
        """The same by what tells of the person alone, to be weighed against the surface that is
        seen: near other people this is as doubtful as the joints are."""
        return self.widening * proposals.scales_m

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


def widening_unsteady(
    disagreement: Array,
    exponent: float = DISAGREEMENT_EXPONENT,
    familiar: float = FAMILIAR_DISAGREEMENT,
) -> Array:
    """[...] what scales of joints with this disagreement are to be multiplied by; below 1 where
    there is less than the familiar one."""
    return (disagreement / familiar) ** exponent


def widening_beside(
    to_cover_m: Array, exponent: float = COVER_EXPONENT, reach_m: float = COVER_REACH_M
) -> Array:
    """[...] what scales of joints so far from others before them are to be multiplied by."""
    nearness = (reach_m + LEAST_TO_COVER_M) / (to_cover_m + LEAST_TO_COVER_M)
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


class DisagreementOverTime:
    """How far one person's joints are proposed from where the two proposals before lead to expect
    them, at a constant velocity, in the scales of one proposal: a geometric mean over time."""

    def __init__(self) -> None:
        self._before: list[tuple[float, Array]] = []
        self._log: Array | None = None
        self._frames = 0

    def update(self, proposals: JointProposals, time_s: float) -> Array | None:
        """[J, 3] after the next proposals, to the right, down and along the ray, of the likeliest
        mode; None while nothing is expected."""
        mode = int(np.argmax(proposals.weights[0]))
        places, scales_m = proposals.positions_camera[0, mode], proposals.scales_m[0, mode]
        depth_m = places[:, 2:]
        to_metres = np.concatenate([depth_m, depth_m, np.ones_like(depth_m)], axis=-1)
        if self._before and not 0.0 < time_s - self._before[-1][0] <= LONGEST_STEP_S:
            self._before, self._log, self._frames = [], None, 0
        if len(self._before) == 2:
            self._learn(places / to_metres, scales_m / to_metres, to_metres, time_s)
        self._before = [*self._before[-1:], (time_s, places / to_metres)]
        return None if self._log is None else np.exp(self._log)

    def _learn(self, here: Array, scales: Array, to_metres: Array, time_s: float) -> None:
        (first_s, first), (last_s, last) = self._before
        elapsed_s = time_s - last_s
        steps = elapsed_s / (last_s - first_s)
        expected = last + (last - first) * steps
        spread = (1.0 + (1.0 + steps) ** 2 + steps**2) ** 0.5  # of three errors of one scale
        moved = ACCELERATION_M_S2 * elapsed_s**2 / to_metres
        ways = np.abs(here - expected) / (spread * (scales + moved))
        self._frames += 1
        share = max(share_after(elapsed_s, DISAGREEMENT_MEMORY_S), 1.0 / self._frames)
        logs = np.log(ways + LEAST_DISAGREEMENT)
        self._log = logs if self._log is None else self._log + share * (logs - self._log)
