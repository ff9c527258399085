"""One frame of a person, and a whole body that was found in it, with its cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.filter.over_time import frames_in
from topview.kernels.visibility import look_along_parts
from topview.timing import StageClock
from topview.track.degrees_of_freedom import N_DOFS, N_ROOT_DOFS, PARENT_OF
from topview.track.evidence import NEAREST_PLACE_M, OCCLUDER_MARGIN_M, Evidence
from topview.track.methods.topview.refinement import Refined
from topview.track.pose import Pose

Array = NDArray[np.float64]

# All ours. A pose's cost is the share of the person's points that it leaves unexplained, and what
# is added to that; all costs, margins and weights are in that unit.
FREE_SPACE_COST: Final = 1.0  # of the share of the body in free space
DEPARTURE_COST: Final = 0.3  # of the mean squared turn away from the prior, per square radian
TOLERATED_OCCLUSION: Final = 0.15  # share of a body whose occlusion changes nothing


@dataclass(frozen=True, slots=True, eq=False)
class FrameContext:
    """One frame, as every step of a tracker needs it."""

    model: BodyModel
    evidence: Evidence
    clock: StageClock
    elapsed_s: float  # since the frame before
    is_hidden: bool = False  # whether more of the body is than is tolerated


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A pose, the body it was found for, its cost, the share of it that is occluded, whether it has
    not moved on from the last one, and [6] what is known of its root (`Refined.information`)."""

    pose: Pose
    model: BodyModel
    cost: float
    hidden: float
    is_new: bool = False
    root_information: Array | None = None


class RootCertainty:
    """How surely the last guided pose's root was known: of whom little is seen it is little, and
    grows less, so that the pose is given up for what comes to be seen.

    The information form of a Kalman filter, for each degree of freedom by itself: the prior of the
    next frame is as sure as the last estimate and a random walk since then, together.
    """

    def __init__(self) -> None:
        self._known = np.full(N_ROOT_DOFS, np.inf)

    def update(self, information: Array) -> None:
        """With [6] what is known after a frame (`Refined.information`)."""
        self._known = information

    def hold(self, weights: Array, guided_s: float, elapsed_s: float) -> Array:
        """[D] factors on a prior's weights [D], of a pose that was guided so long ago and estimated
        so long ago."""
        hold = np.full(N_DOFS, firmness(elapsed_s))
        walk = firmness(guided_s)
        hold[:N_ROOT_DOFS] = walk / (1.0 + walk * weights[:N_ROOT_DOFS] / self._known)
        return hold


def costs_of(refined: Refined) -> Array:
    """[M] what refined poses cost."""
    return (
        refined.unexplained
        + FREE_SPACE_COST * refined.in_free_space
        + DEPARTURE_COST * refined.departure
    )


def firmness(elapsed_s: float) -> float:
    """Factor on a prior's weight after so long: the longer ago a pose was seen, the less it tells
    of the present one; its variance grows with the time, as a random walk's does."""
    return 1.0 / max(frames_in(elapsed_s), 0.25)


def beyond_tolerance(hidden_share: float) -> float:
    """What of a hidden share is beyond what is tolerated."""
    return max(0.0, hidden_share - TOLERATED_OCCLUSION)


def parts_out_of_sight(pose: Pose, model: BodyModel, evidence: Evidence) -> Array:
    """[11] share of each part's axis that is outside of the image, or behind something that is not
    the person."""
    view, out = evidence.view, np.empty(len(PARENT_OF))
    look_along_parts(
        np.ascontiguousarray(pose.neck_camera), np.ascontiguousarray(pose.Rs), model.lengths_m,
        model.joints_parent, PARENT_OF, model.radii_m, view.depth_m, evidence.user_mask,
        (view.fx, view.fy, view.cx, view.cy), NEAREST_PLACE_M, OCCLUDER_MARGIN_M, out,
    )  # fmt: skip
    return out


def of_what_is_seen(share: float, look: FrameContext) -> float:
    """A share of what a whole body shows, seen from the side, as one of what is seen of it."""
    model, evidence = look.model, look.evidence
    whole_m2 = 2.0 * float((model.lengths_m * model.radii_m.mean(1)).sum())
    return share * max(1.0, whole_m2 / max(evidence.seen_m2, evidence.point_area_m2))
