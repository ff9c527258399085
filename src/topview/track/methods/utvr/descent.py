"""At a frame's end: all parts move together onto the points, and the pose that explains more stays
(ours).

A cylinder that wants points inside stands too near to the camera; one whose surface they are does
not. And only what is placed steers the parts below it, until here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.proportions import Proportions
from topview.track.evidence import Evidence
from topview.track.methods.topview.refinement import RefinementSettings, refine
from topview.track.pose import Pose

Array = NDArray[np.float64]

# All ours. The surface of rendered people's torsos, clothes and all, is an ellipse of 10 to 12 % of
# the stature across and 8 to 11 % from back to front, about a point 1 to 2 % before the spine
# (seeds 100 to 103 of `turn`); these semi-axes are at its lower end.
TORSO_SURFACE: Final = (0.098, 0.09)
HOLD: Final = 0.1  # against `RefinementSettings`' priors, which hold to the pose found
LEAST_POINTS: Final = 30  # of fewer, parts stay where the filters have them


def surface_model(stature_m: float, proportions: Proportions) -> BodyModel:
    """A body whose parts are as wide as what a camera sees of them."""
    wide = replace(proportions, upper_torso_radii=TORSO_SURFACE, lower_torso_radii=TORSO_SURFACE)
    return BodyModel.of(stature_m, wide)


def descend(
    poses: Sequence[Pose], surface: BodyModel, evidence: Evidence, steps: int
) -> tuple[list[Pose], Array]:
    """The poses after so many Gauss-Newton steps, and [M] what they cost: the share of points that
    they leave unexplained, and of their axes in free space."""
    moved = refine(poses, None, surface, evidence, RefinementSettings(), steps, HOLD)
    return moved.poses, moved.unexplained + moved.in_free_space
