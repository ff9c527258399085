"""How stout a person is, and how loosely dressed: the parts' radii, learnt while tracking (ours).

Published radii are those of the average person without clothes. The width of what is seen of a
part says more: points spread evenly over a width of 2 r lie r / 2 from its middle on average.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS
from topview.geometry.rotations import unit
from topview.track.evidence import Evidence
from topview.track.pose import Pose
from topview.track.refinement import label_points

Array = NDArray[np.float64]

LEAST_POINTS = 20  # on a part, to say anything
LEAST_ACROSS = 0.5  # sine between part and line of sight; a foreshortened part shows its end
LEARNING_RATE = 0.0  # per frame
LARGEST_CHANGE = (0.85, 1.35)  # of the published radii
REACH_M = 0.08  # points farther from a part are not its clothes

# Left and right share one girth.
_GROUP = np.array(
    [
        next(i for i, p in enumerate(PARTS) if p.name == part.name.replace("right", "left"))
        for part in PARTS
    ]
)


class GirthEstimate:
    """Factors on the published radii of one person's parts."""

    def __init__(self) -> None:
        self.scales: Array = np.ones(len(PARTS))

    def applied_to(self, model: BodyModel) -> BodyModel:
        """The model with this person's girths."""
        return model.with_girths(self.scales)

    def learn(self, pose: Pose, model: BodyModel, evidence: Evidence) -> None:
        """Move the factors a little towards what this frame shows; `model` has them applied."""
        origins = pose.origins(model)
        points = evidence.points_camera
        labels, _ = label_points(points, pose, origins, model, REACH_M)
        seen: dict[int, list[float]] = {}
        for part in range(len(PARTS)):
            mine = points[labels == part]
            if len(mine) < LEAST_POINTS:
                continue
            R = pose.Rs[part]
            sight = unit(mine.mean(0))
            across = np.cross(R[:, 1], sight)
            sine = float(np.linalg.norm(across))
            if sine < LEAST_ACROSS:
                continue
            across /= sine
            width = 2.0 * np.abs((mine - origins[part]) @ across).mean()
            radius = np.hypot(*(model.radii_m[part] * (R.T @ across)[[0, 2]]))
            seen.setdefault(int(_GROUP[part]), []).append(width / radius)
        for group, ratios in seen.items():
            scale = self.scales[group] * (1.0 + LEARNING_RATE * (np.mean(ratios) - 1.0))
            self.scales[group == _GROUP] = np.clip(scale, *LARGEST_CHANGE)
