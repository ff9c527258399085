"""The body fitted to proposed joints: each mode becomes a pose (ours)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.limits import ANATOMICAL_LIMITS_RAD
from topview.body.model import BodyModel
from topview.body.parts import JOINT_NAMES, JOINTS, PARTS
from topview.detect.joints import JointProposals, proposed_of_joints
from topview.kernels import joint_fit as kernel
from topview.records import check_range
from topview.track.degrees_of_freedom import (
    BENDS,
    CHAIN,
    DOF_AXIS,
    DOF_OF,
    DOF_PART,
    HINGES,
    N_CHAIN,
    N_DOF_OF,
    PARENT_OF,
    TREE,
)
from topview.track.pose import Pose

Array = NDArray[np.float64]

LEAST_SCALE_M: Final = 0.005  # no joint is trusted to be nearer; ours

JOINT_PART = np.array([joint.part for joint in JOINTS])
_SIDES: Final = ("left", "right")
_TRUNK = np.array(
    [JOINT_NAMES.index(name) for name in ("neck", "torso", "pelvis")]
    + [JOINT_NAMES.index(f"{side}_{name}") for name in ("shoulder", "hip") for side in _SIDES]
)
# Upper part of each limb, and its three joints.
_LIMBS = np.array(
    [
        [JOINTS[first].part, first, first + 1, first + 2]
        for name in ("shoulder", "hip")
        for first in (JOINT_NAMES.index(f"{side}_{name}") for side in _SIDES)
    ]
)

# Hinges are held by how limbs turn; limits of nothing would count or not by rounding.
_LIMITS_RAD = ANATOMICAL_LIMITS_RAD.copy()
_LIMITS_RAD[[part.is_hinge for part in PARTS], 1:] = -0.5 * np.pi, 0.5 * np.pi


@dataclass(frozen=True, slots=True)
class JointFitSettings:
    """Ours, all of it. Weights are against that of a joint's place, per square of its scale.

    Attributes:
        iterations: Gauss-Newton steps, 1 to 100.
        limit_weight: of a joint beyond its limits, per square radian, 0 to 1e6.
        prior_weight: of a part turned away from the start, per square radian, 0.001 to 1e6; it
            holds what no joint tells, as the head's turn about its own axis.

    Raises:
        InputError: a value out of range.
    """

    iterations: int = 8
    limit_weight: float = 10.0
    prior_weight: float = 0.05

    def __post_init__(self) -> None:
        check_range(self, 1, 100, "iterations")
        check_range(self, 0.0, 1e6, "limit_weight")
        check_range(self, 0.001, 1e6, "prior_weight")


@dataclass(frozen=True, slots=True, eq=False)
class JointTargets:
    """Where the body's joints are proposed to be, in one mode.

    Attributes:
        places_camera: [16, 3] metres.
        scales_m: [16, 3] as in `JointProposals`; infinite for joints that are not proposed.
    """

    places_camera: Array
    scales_m: Array

    def with_place(self, joint: int, place_camera: Array, sigma_m: float) -> JointTargets:
        """With another place [3] of a joint, where that is surer than the one that is proposed."""
        if sigma_m >= self.scales_m[joint].max():
            return self
        places_camera, scales_m = self.places_camera.copy(), self.scales_m.copy()
        places_camera[joint], scales_m[joint] = place_camera, max(sigma_m, LEAST_SCALE_M)
        return JointTargets(places_camera, scales_m)

    @staticmethod
    def none() -> JointTargets:
        """No joint is proposed."""
        return JointTargets(np.ones((0, 3)), np.ones((0, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class FittedJoints:
    """Poses fitted to the modes of one person's proposals, in their order.

    Attributes:
        poses: M poses.
        residuals: [M] mean robust residual of each, in units of scale: `robust_residual`.
    """

    poses: list[Pose]
    residuals: Array


def fit_joints(
    model: BodyModel, proposals: JointProposals, settings: JointFitSettings
) -> FittedJoints:
    """Fit a body to each mode of one person's proposals, each on its own.

    Args:
        model: the body.
        proposals: of one person, P = 1; joints that the body does not have are left out.
        settings: of the fit.
    """
    places, scales_m = body_joints(proposals)
    M = len(places)
    necks, Rs, residuals = np.empty((M, 3)), np.empty((M, len(PARTS), 3, 3)), np.empty(M)
    kernel.fit_joints(
        necks, Rs, places, scales_m, model.lengths_m, model.joints_parent, PARENT_OF, TREE,
        JOINT_PART, model.joints_part, _TRUNK, _LIMBS, _LIMITS_RAD, HINGES, BENDS, DOF_PART,
        DOF_AXIS, CHAIN, N_CHAIN, DOF_OF, N_DOF_OF, settings.prior_weight, settings.limit_weight,
        settings.iterations, residuals,
    )  # fmt: skip
    return FittedJoints([Pose(neck, R) for neck, R in zip(necks, Rs, strict=True)], residuals)


def body_joints(
    proposals: JointProposals,
    wanted: tuple[str, ...] = JOINT_NAMES,
    scales_m: Array | None = None,
) -> tuple[Array, Array]:
    """[M, J, 3] where the wanted joints, the body's if none are named, are proposed for the first
    person, and the scales, both in metres; infinite scales for joints that are not proposed.
    `scales_m` [P, M, all, 3] are taken in place of the proposals' own."""
    proposed = proposed_of_joints(proposals.joint_names, wanted)
    stated_m = proposals.scales_m if scales_m is None else scales_m
    wanted_m = np.maximum(stated_m[0].take(proposed, axis=1), LEAST_SCALE_M)
    wanted_m[:, proposed < 0] = np.inf
    return proposals.positions_camera[0].take(proposed, axis=1), wanted_m


def robust_residual(joints_camera: Array, places_camera: Array, scales_m: Array) -> float:
    """Mean of sqrt(1 + (e / s)^2) - 1 over [K, 3] residuals e and scales s, infinite ones left out.

    The axes are those of the scales: to the right and down in the image, both at the proposed
    depth, and along the ray through the proposed place.

    Args:
        joints_camera: [K, 3] of the body.
        places_camera, scales_m: [K, 3] as proposed.
    """
    e = joints_camera - places_camera
    rays = places_camera / places_camera[:, 2:]
    residuals = e - rays * e[:, 2:] * (1.0, 1.0, 0.0)
    is_proposed = np.isfinite(scales_m)
    robust = np.sqrt(1.0 + (residuals / scales_m) ** 2) - 1.0
    return float(robust[is_proposed].mean())
