"""Which of the hands that the colour of skin shows is which arm's.

Sec. 5.1.4 asks for them; their use for the full body, and how they are told apart, is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import LEFT_FOREARM, LEFT_UPPER_ARM, RIGHT_FOREARM, RIGHT_UPPER_ARM
from topview.geometry.rotations import unit
from topview.people.identity import assign
from topview.track.evidence import Evidence
from topview.track.pose import Pose

Array = NDArray[np.float64]

# All ours. A hand is the arm's from whose predicted one it is few of these lengths away; its belief
# to be a left or a right one weighs so much; and it is within this share of the arm's length.
MOTION_M = 0.15
SIDE_WEIGHT = 0.5
REACH = 1.1
LEAST_SHARE = 0.01
ARMS = ((LEFT_UPPER_ARM, LEFT_FOREARM), (RIGHT_UPPER_ARM, RIGHT_FOREARM))


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """An arm's end as it is seen by its colour: [3] metres on the forearm's axis, and the belief
    that it is a hand."""

    palm_camera: Array
    belief: float


def hands_of_arms(
    pose: Pose, predicted: Pose, model: BodyModel, evidence: Evidence
) -> dict[int, Hand]:
    """By upper arm, the hands that are seen on the user: each the arm's whose predicted hand is
    near, whose side it looks like, and which reaches that far from its shoulder in `pose`."""
    seen = [hand for hand in evidence.hands if evidence.is_on_user(hand.palm_camera)]
    if not seen:
        return {}
    palms = np.array([hand.palm_camera for hand in seen])
    palms += unit(palms) * model.radii_m[LEFT_FOREARM, 0]  # from the skin to the axis
    left = np.clip([hand.left_share for hand in seen], LEAST_SHARE, 1.0 - LEAST_SHARE)
    shoulders, elbows = pose.origins(model), predicted.origins(model)
    costs = np.empty((2, len(seen)))
    for row, ((upper, lower), share) in enumerate(zip(ARMS, (left, 1.0 - left), strict=True)):
        expected = elbows[lower] + predicted.Rs[lower, :, 1] * model.lengths_m[lower]
        off_m = np.linalg.norm(palms - expected, axis=1)
        costs[row] = off_m / MOTION_M - SIDE_WEIGHT * np.log(share)
        reach_m = REACH * model.lengths_m[[upper, lower]].sum()
        costs[row, np.linalg.norm(palms - shoulders[upper], axis=1) > reach_m] = np.inf
    return {
        ARMS[row][0]: Hand(palms[column], seen[column].confidence)
        for row, column in assign(-costs).items()
    }
