"""Refinement: all parts at once, by Gauss-Newton on the user's points and silhouette (ours).

The thesis optimises part by part and names global optimisation as future work (Sec. 7.1). This
moves all degrees of freedom of candidate poses together (`topview.track.degrees_of_freedom`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from topview.body.limits import ANATOMICAL_LIMITS_RAD, LIMITS_RAD
from topview.body.model import BodyModel
from topview.body.parts import HEAD
from topview.kernels import body as kernel
from topview.track.degrees_of_freedom import (
    BENDS,
    CHAIN,
    DOF_AXIS,
    DOF_OF,
    DOF_PART,
    HINGES,
    N_CHAIN,
    N_DOF_OF,
    N_DOFS,
    N_ROOT_DOFS,
    PARENT_OF,
    TREE,
)
from topview.track.evidence import Evidence
from topview.track.joint_fit import JOINT_PART, JointTargets
from topview.track.pose import Pose
from topview.track.surfaces import NearestSurfaces, nearest_surfaces

Array = NDArray[np.float64]

UNIT_AREA_M2 = 4e-4  # the seen surface whose weight is 1; ours

_HEAD_TWIST = (DOF_PART == HEAD) & (DOF_AXIS == 1)


@dataclass(frozen=True, slots=True)
class RefinementSettings:
    """Ours, all of it. Weights are against that of 4 cm2 of seen surface.

    Attributes:
        iterations: Gauss-Newton steps.
        reach_m, scale_m: points farther from a surface do not pull it, and the width of the robust
            weight, metres.
        free_space_margin_m: how far a part may lie in front of what is seen, metres.
        free_space_weight: of a place on a part's axis in free space.
        collision_weight: of a place on a limb's axis inside the torso.
        limit_weight: of a joint beyond its limits, metres per radian squared.
        place_prior_weight: of the neck joint away from the prior.
        turn_prior_weight: of a part turned away from the prior, metres per radian squared.
        twist_prior_weight: the same for the head about its own axis, which hardly shows.
        head_weight: of the head's measured centre.
        joint_weight: of a proposed joint that is one scale off, square metres; it says how far the
            surface of 4 cm2 is off.
        samples_per_part: places on each part's axis that are tested against free space.
    """

    iterations: int = 5
    reach_m: float = 0.15
    scale_m: float = 0.05
    free_space_margin_m: float = 0.06
    free_space_weight: float = 6.0
    collision_weight: float = 10.0
    limit_weight: float = 50.0
    place_prior_weight: float = 32.0
    turn_prior_weight: float = 1.0
    twist_prior_weight: float = 40.0
    head_weight: float = 30.0
    joint_weight: float = 0.1
    samples_per_part: int = 5

    @property
    def prior_weights(self) -> Array:
        """[D] of each degree of freedom away from the prior."""
        weights = np.full(N_DOFS, self.turn_prior_weight)
        weights[:3] = self.place_prior_weight
        weights[_HEAD_TWIST] = self.twist_prior_weight
        return weights


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """Refined candidates, in the order they came in.

    Attributes:
        poses, together: M poses, and the same at once.
        unexplained: [M] share of the user's points that lie on no part, robustly counted.
        in_free_space: [M] share of the body's axis that the image shows to be in free space.
        departure: [M] mean squared turn away from the prior, square radians.
        hidden: [M] share of the body's axis that is behind others or objects, or out of view.
        apart: [M] mean robust residual of the proposed joints, in units of scale; 0 without any.
        information: [M, 6] inverse variances of the root's place and turn, each with all else free,
            in the unit of the prior's weights, with the prior.
    """

    poses: list[Pose]
    together: Pose
    unexplained: Array
    in_free_space: Array
    departure: Array
    hidden: Array
    apart: Array
    information: Array


def refine(
    candidates: Sequence[Pose],
    prior: Pose | Sequence[Pose] | None,
    model: BodyModel,
    evidence: Evidence,
    settings: RefinementSettings,
    iterations: int | None = None,
    hold: float | Array = 1.0,
    targets: JointTargets | None = None,
    *,
    is_hidden: bool = False,
) -> Refined:
    """Refine candidate poses against the evidence, each on its own.

    All are held softly to `prior`, or each to one of its own, or to where it starts if there is
    none; `hold` is a factor on how firmly, or [D] of them. Where the body `is_hidden` in part,
    little says how far legs bend, and they keep to Table 3.2.
    """
    s = settings
    targets = targets or JointTargets.none()
    priors = [prior] * len(candidates) if isinstance(prior, Pose) else prior or candidates
    held_to = Pose.together(priors)
    necks = np.array([pose.neck_camera for pose in candidates])
    Rs = np.array([pose.Rs for pose in candidates])
    costs = np.empty((len(candidates), 5))
    information = np.zeros((len(candidates), N_ROOT_DOFS))
    view, surface = evidence.view, model.surface
    limits_rad = LIMITS_RAD if is_hidden else ANATOMICAL_LIMITS_RAD
    kernel.refine_bodies(
        necks,
        Rs,
        held_to.neck_camera,
        np.ascontiguousarray(np.swapaxes(held_to.relative(), 0, 1)),
        surface.lengths_m,
        surface.shapes_m,
        surface.owners,
        surface.Rs_part,
        surface.origins_part,
        model.joints_parent,
        PARENT_OF,
        TREE,
        limits_rad,
        HINGES,
        BENDS,
        DOF_PART,
        DOF_AXIS,
        CHAIN,
        N_CHAIN,
        DOF_OF,
        N_DOF_OF,
        s.prior_weights * hold,
        evidence.points_camera,
        evidence.normals_camera,
        view.depth_m,
        evidence.user_mask,
        evidence.nearest.columns,
        evidence.nearest.corner,
        view.fx,
        view.fy,
        view.cx,
        view.cy,
        evidence.head_camera,
        s.head_weight if evidence.head_is_seen else 0.0,
        evidence.floor,
        s.reach_m,
        s.scale_m,
        evidence.point_area_m2 / UNIT_AREA_M2,
        s.free_space_margin_m,
        s.free_space_weight,
        s.collision_weight,
        s.limit_weight,
        s.samples_per_part,
        s.iterations if iterations is None else iterations,
        targets.places_camera,
        targets.scales_m,
        JOINT_PART,
        model.joints_part,
        s.joint_weight,
        costs,
        information,
    )
    together = Pose(necks, np.swapaxes(Rs, 0, 1))
    return Refined(together.apart(), together, *costs.T, information=information)


class Explained(NamedTuple):
    """What a body explains of evidence with normals.

    Attributes:
        surfaces: which part each point lies on.
        shares: [N] how much of each point is explained, 0 to 1.
    """

    surfaces: NearestSurfaces
    shares: Array


def explained(
    pose: Pose, model: BodyModel, evidence: Evidence, settings: RefinementSettings
) -> Explained:
    """What this body explains of evidence with normals."""
    surfaces = nearest_surfaces(
        evidence.points_camera, pose.Rs, pose.origins(model), model.surface, settings.reach_m,
        evidence.normals_camera,
    )  # fmt: skip
    return Explained(surfaces, 1.0 / (1.0 + (surfaces.unlike_m / settings.scale_m) ** 2))
