"""What bodies usually do: a pose is held to poses of captured motion that are like it (ours).

Points alone leave a limb that is hidden, or that touches the trunk, free to be anywhere. The table
by which whole bodies are looked up (`lookup`) knows how people move; the mean of those of its poses
that are most like the last one tells what the next one may be.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import rotations_in_parent
from topview.body.parts import PARTS, UPPER_TORSO
from topview.geometry.rotations import nearest_rotations
from topview.kernels.lookup import squared_distances
from topview.track.methods.topview.lookup import shipped_poses
from topview.track.pose import FROM_UPPER_TORSO, Pose, mirrored

Array = NDArray[np.float64]

AKIN: Final = 30  # poses whose mean is taken; ours
# Of the axes of a pose, for `squared_distances`.
_NOTHING_HIDDEN: Final = np.eye(3 * len(PARTS), dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class UsualPoses:
    """Poses of captured motion, and their mirror images.

    Attributes:
        axes: [33, P] of their parts' own axes, in the frame of the upper torso.
        Rs_relative: [P, 11, 3, 3] their rotations, as `Pose.relative`.
    """

    axes: NDArray[np.float32]
    Rs_relative: Array

    @classmethod
    def of(cls, Rs: Array) -> UsualPoses:
        """Of [P / 2, 11, 3, 3] rotations of parts in any upright frame."""
        Rs = np.concatenate([Rs, mirrored(Rs)])
        relative = rotations_in_parent(np.swapaxes(Rs, 0, 1), FROM_UPPER_TORSO)
        axes = np.ascontiguousarray(_axes_in_torso(Rs).T, np.float32)
        return cls(axes, np.ascontiguousarray(np.swapaxes(relative, 0, 1)))

    def towards(self, pose: Pose, share: float) -> Pose:
        """A pose whose limbs and head are turned by this share of the way to the mean of those that
        are like it; the neck and the upper torso stay."""
        squares = self._squares(pose)
        like = np.argpartition(squares, AKIN)[:AKIN]
        weights = np.exp(-0.5 * squares[like] / max(float(np.median(squares[like])), 1e-6))
        weights = weights.astype(np.float64) / weights.sum()
        own = pose.relative()
        mean = np.einsum("k,kpij->pij", weights, self.Rs_relative[like])
        Rs = nearest_rotations((1.0 - share) * own + share * mean)
        Rs[UPPER_TORSO] = own[UPPER_TORSO]
        return Pose.from_relative(pose.neck_camera, Rs)

    def _squares(self, pose: Pose) -> NDArray[np.float32]:
        """[P] squared distances of the axes of a pose to those of each captured one."""
        axes = _axes_in_torso(pose.Rs[None])[0].astype(np.float32)
        squares = np.empty(len(self.Rs_relative), np.float32)
        squared_distances(self.axes, _NOTHING_HIDDEN, axes, squares)
        return np.maximum(squares + (axes * axes).sum(), 0.0)


def _axes_in_torso(Rs: Array) -> Array:
    """[P, 33] of [P, 11, 3, 3] rotations."""
    axes = np.einsum("kji,kpj->kpi", Rs[:, UPPER_TORSO], Rs[..., 1])
    return axes.reshape(len(Rs), -1)


@cache
def usual_poses() -> UsualPoses:
    """Those of the table that comes with the project."""
    return UsualPoses.of(shipped_poses().Rs)
