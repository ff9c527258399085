"""How large somebody is, learnt from the surface that is seen: stature and thickness (ours).

People differ from the average of their stature: the surface of children and of loose clothes lies 2
to 3 cm farther out, that of slim people 1 cm farther in, and the joints of an average body are off
by as much. The fit of a pose moves that body until its surface is where it is seen, so what is
wrong with its size shows in the residuals that are left at its sides. They are linear in pose and
size together; the pose is eliminated (Schur's complement), and what each frame tells of the size is
added up, of older frames less. In the spirit of Tkach, Tagliasacchi, Remelli, Pauly, Fitzgibbon
2017, who estimate a hand's measures, and their uncertainty, from frame to frame.
"""

from __future__ import annotations

from math import exp, log
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import PARTS
from topview.filter.over_time import share_after
from topview.kernels.sizes import N_TOLD, moves_of_pose, sum_up_surface
from topview.track.bone_lengths import BoneLengths
from topview.track.degrees_of_freedom import CHAIN, DOF_AXIS, DOF_PART, N_CHAIN, N_DOFS
from topview.track.evidence import Evidence
from topview.track.methods.topview.refinement import UNIT_AREA_M2, RefinementSettings
from topview.track.pose import Pose
from topview.track.stature import StatureBelief
from topview.track.surfaces import nearest_surfaces

Array = NDArray[np.float64]

# What is estimated: how far the surface of these lies farther out, and the stature's logarithm.
SIZE_GROUPS: Final = ("head", "torso", "arm", "leg")
OF_STATURE: Final = len(SIZE_GROUPS)
N_SIZES: Final = len(SIZE_GROUPS) + 1
# All ours. By so much people's surface is farther out than the average of their stature: of all
# groups together, and of each by itself.
SHARED_M, GROUP_M = 0.015, 0.01
# By so much it is off in each frame, in each patch of this area by itself, for so long.
SURFACE_SIGMA_M, PATCH_M2, SURFACE_ALIKE_S = 0.015, 0.01, 0.25
# What was seen so long ago counts for 37 %: it was linear about another pose and size.
SIZE_MEMORY_S: Final = 1.0

_GROUP_OF = np.array(
    [next(g for g, name in enumerate(SIZE_GROUPS) if name in part.name) for part in PARTS]
)
_OF_SIZE = np.zeros((len(PARTS), 3, N_SIZES + 1))  # thickness, stature and residual of each part
_OF_SIZE[np.arange(len(PARTS)), 0, _GROUP_OF] = 1.0
_OF_SIZE[:, 1, OF_STATURE] = _OF_SIZE[:, 2, N_SIZES] = 1.0
_IS_MOVED = np.zeros((len(PARTS), N_DOFS), np.bool_)  # which degrees of freedom move which part
for _part, _dofs in enumerate(CHAIN):
    _IS_MOVED[_part, _dofs[: N_CHAIN[_part]]] = True


class BodySize:
    """One person's size over time."""

    def __init__(
        self, bones: BoneLengths, stature: StatureBelief, refinement: RefinementSettings
    ) -> None:
        """`stature` is told the one that is learnt; `refinement` says how poses are found."""
        self._bones = bones
        self._stature = stature
        self._refinement = refinement
        self._thickness_m = np.zeros(len(SIZE_GROUPS))
        self.forget()

    def forget(self) -> None:
        """The body is another than was thought: what its frames told says nothing."""
        self._information = np.zeros((N_SIZES, N_SIZES))
        self._weighted = np.zeros(N_SIZES)
        self._last_s: float | None = None

    def model(self, stature_m: float) -> BodyModel:
        """The body of this stature, of this person's bones and thickness."""
        return self._bones.model(stature_m).thicker(self._thickness_m[_GROUP_OF])

    def update(self, pose: Pose, model: BodyModel, evidence: Evidence) -> None:
        """Learn from a pose that was found with a body of this size."""
        time_s = evidence.timestamp_s
        elapsed_s = SURFACE_ALIKE_S if self._last_s is None else max(time_s - self._last_s, 0.0)
        self._last_s = time_s
        information, gradient = self._seen(pose, model, evidence)
        size = np.append(self._thickness_m, log(model.stature_m))
        kept, looks = exp(-elapsed_s / SIZE_MEMORY_S), share_after(elapsed_s, SURFACE_ALIKE_S)
        self._information = kept * self._information + looks * information
        self._weighted = kept * self._weighted + looks * (gradient + information @ size)
        prior, mean = self._prior()
        size = np.linalg.solve(self._information + prior, self._weighted + prior @ mean)
        self._thickness_m = np.asarray(size[:OF_STATURE], np.float64)
        self._stature.learn(exp(size[OF_STATURE]))

    def _prior(self) -> tuple[Array, Array]:
        """[N, N] information before any frame, and [N] the size."""
        stature_m, sigma = self._stature.prior
        covariance = np.zeros((N_SIZES, N_SIZES))
        covariance[:OF_STATURE, :OF_STATURE] = SHARED_M**2 + GROUP_M**2 * np.eye(OF_STATURE)
        covariance[OF_STATURE, OF_STATURE] = sigma**2
        mean = np.zeros(N_SIZES)
        mean[OF_STATURE] = log(stature_m)
        return np.asarray(np.linalg.inv(covariance), np.float64), mean

    def _seen(self, pose: Pose, model: BodyModel, evidence: Evidence) -> tuple[Array, Array]:
        """[N, N] information of one frame about the size, the pose being free, and [N] the
        gradient: that information times the step to the likeliest size."""
        origins, settings = pose.origins(model), self._refinement
        points_camera = evidence.points_camera
        surfaces = nearest_surfaces(
            points_camera, pose.Rs, origins, model.surface, settings.reach_m
        )
        sums = np.empty((len(PARTS), N_TOLD, N_TOLD))
        sum_up_surface(
            points_camera, surfaces.labels, surfaces.distances_m, surfaces.normals_camera,
            np.ascontiguousarray(pose.Rs[:, :, 1]), pose.neck_camera, settings.scale_m, sums,
        )  # fmt: skip
        shares = _shares(pose, origins)
        system = (np.swapaxes(shares, 1, 2) @ sums @ shares).sum(0)
        system *= evidence.point_area_m2 / PATCH_M2
        held = settings.prior_weights * (UNIT_AREA_M2 / PATCH_M2)
        of_pose = system[:N_DOFS, :N_DOFS] + np.diag(held)
        explained = system[N_DOFS:, :N_DOFS] @ np.linalg.solve(of_pose, system[:N_DOFS, N_DOFS:])
        left = (system[N_DOFS:, N_DOFS:] - explained) / SURFACE_SIGMA_M**2
        return left[:N_SIZES, :N_SIZES], left[:N_SIZES, N_SIZES]


def _shares(pose: Pose, origins: Array) -> Array:
    """[B, 9, D + N + 1] what each degree of freedom, size, and the residual by itself changes of
    the numbers that `sum_up_surface` sums up of a part."""
    moves = np.empty((N_DOFS, 6))
    moves_of_pose(pose.neck_camera, pose.Rs, origins, DOF_PART, DOF_AXIS, moves)
    shares = np.zeros((len(PARTS), N_TOLD, N_DOFS + N_SIZES + 1))
    shares[:, :6, :N_DOFS] = moves.T * _IS_MOVED[:, None]
    shares[:, 6:, N_DOFS:] = _OF_SIZE
    return shares
