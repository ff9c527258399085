"""Assignment of hands, which the colour of skin shows, to arms.

Sec. 5.1.4 uses hands for the upper body; their use for the full body, and the assignment, are ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, RIGHT_FOREARM, RIGHT_UPPER_ARM
from topview.filter.assignment import assign
from topview.geometry.rotations import unit
from topview.track.evidence import Evidence
from topview.track.pose import Pose

Array = NDArray[np.float64]

# All ours. The cost of giving a hand to an arm is its distance from the arm's predicted hand in
# units of `PALM_MOTION_M`, less the weighted logarithm of the belief that it is that side's.
PALM_MOTION_M: Final = 0.15
SIDE_WEIGHT: Final = 0.5
LEAST_SIDE_BELIEF: Final = 0.01  # a lower belief counts as this
UNMATCHED: Final = 1e3  # cost of a hand that goes to no arm
PALM_REACH: Final = 1.1  # a hand is no farther from its shoulder, in lengths of the arm
ARMS = ((LEFT_UPPER_ARM, LEFT_FOREARM), (RIGHT_UPPER_ARM, RIGHT_FOREARM))


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """The end of an arm, detected by its colour.

    Attributes:
        palm_camera: [3] metres, on the forearm's axis.
        belief: that it is a hand, 0 to 1.
    """

    palm_camera: Array
    belief: float


def hands_of_arms(
    pose: Pose, predicted: Pose, model: BodyModel, evidence: Evidence
) -> dict[int, Hand]:
    """The detected hands by upper arm: each goes to the arm whose predicted hand is near, whose
    side it seems to be, and whose shoulder in `pose` is within reach."""
    seen = [hand for hand in evidence.hands if evidence.is_on_user(hand.palm_camera)]
    if not seen:
        return {}
    palms = np.array([hand.palm_camera for hand in seen])
    palms += unit(palms) * model.radii_m[LEFT_FOREARM, 0]  # from the skin to the axis
    left = np.clip([hand.left_share for hand in seen], LEAST_SIDE_BELIEF, 1.0 - LEAST_SIDE_BELIEF)
    shoulders, elbows = pose.origins(model), predicted.origins(model)
    costs = np.empty((2, len(seen)))
    for row, ((upper, lower), share) in enumerate(zip(ARMS, (left, 1.0 - left), strict=True)):
        expected = elbows[lower] + predicted.Rs[lower, :, 1] * model.lengths_m[lower]
        off_m = np.linalg.norm(palms - expected, axis=1)
        costs[row] = off_m / PALM_MOTION_M - SIDE_WEIGHT * np.log(share)
        reach_m = PALM_REACH * model.lengths_m[[upper, lower]].sum()
        costs[row, np.linalg.norm(palms - shoulders[upper], axis=1) > reach_m] = np.inf
    return {
        ARMS[row][0]: Hand(palms[column], seen[column].confidence)
        for row, column in assign(-costs, unmatched=-UNMATCHED).items()
    }
