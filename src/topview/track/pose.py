"""Poses: as body trackers carry them from frame to frame, and as parts of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import Tree, place_part, rotations_in_camera, rotations_in_parent
from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    HEAD_CENTRE_JOINT,
    LOWER_TORSO,
    PART_NAMES,
    PARTS,
    UPPER_TORSO,
    other_side,
)
from topview.geometry.rotations import transform

Array = NDArray[np.float64]

# The table of parts has the head as its root, as in the thesis. Refinement and motion take the
# upper torso, which is seen best: only the edge between head and upper torso is reversed.
TREE_PARENT = tuple(
    -1 if index == UPPER_TORSO else UPPER_TORSO if index == HEAD else part.parent
    for index, part in enumerate(PARTS)
)
FROM_UPPER_TORSO: Final[Tree] = tuple(
    (index, parent) for index, parent in enumerate(TREE_PARENT) if index != UPPER_TORSO
)
# +1 for elbows, which bend to the front, -1 for knees.
HINGE_BENDS = {
    part.parent: 1.0 if part.limits_rad[0][1] > 1.0 else -1.0 for part in PARTS if part.is_hinge
}
# The same part on the other side of the body; head and torso are their own.
OTHER_SIDE = tuple(PART_NAMES.index(other_side(name)) for name in PART_NAMES)
HALF_ROUND = np.diag([-1.0, 1.0, -1.0])  # half a turn about a part's own axis
# Upper limb and the part below it.
HINGE_PAIRS = tuple((part.parent, index) for index, part in enumerate(PARTS) if part.is_hinge)
LIMBS: Final = tuple(upper for upper, _ in HINGE_PAIRS)  # the lower part is the next
TRUNK_PARTS: Final = [UPPER_TORSO, LOWER_TORSO]

MIRRORED = np.diag([-1.0, 1.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """The place of the neck joint and the rotation of every part; or M poses at once.

    Attributes:
        neck_camera: [3] metres, or [M, 3].
        Rs: [11, 3, 3] `Rs_camera_part`, or [11, M, 3, 3].
    """

    neck_camera: Array
    Rs: Array

    def relative(self) -> Array:
        """[11, 3, 3], or [11, M, 3, 3], rotations in the tree that hangs from the upper torso."""
        return rotations_in_parent(self.Rs, FROM_UPPER_TORSO)

    @staticmethod
    def from_relative(neck_camera: Array, Rs_relative: Array) -> Pose:
        """Inverse of `relative`."""
        return Pose(neck_camera, rotations_in_camera(Rs_relative, FROM_UPPER_TORSO))

    @staticmethod
    def below_head(head_camera: Array, Rs: Array, model: BodyModel) -> Pose:
        """The pose of these rotations, or the M poses, whose head has its centre at a [3] place."""
        down_m = model.lengths_m[HEAD] - model.joints_part[HEAD_CENTRE_JOINT, 1]
        return Pose(head_camera + down_m * Rs[HEAD, ..., 1], Rs)

    def origins(self, model: BodyModel) -> Array:
        """[11, 3], or [11, M, 3], proximal joints in metres, camera frame."""
        origins = np.empty(self.Rs.shape[:-1])
        origins[UPPER_TORSO] = self.neck_camera
        origins[HEAD] = self.neck_camera - self.Rs[HEAD][..., 1] * model.lengths_m[HEAD]
        for part, parent in FROM_UPPER_TORSO[1:]:
            origins[part] = place_part(model, part, self.Rs[parent], origins[parent])
        return origins

    def ends(self, model: BodyModel) -> Array:
        """[11, 3], or [11, M, 3], where each part ends, away from its proximal joint, in metres,
        camera frame."""
        origins = self.origins(model)
        return origins + self.Rs[..., 1] * model.lengths_m.reshape(-1, *(1,) * (origins.ndim - 1))

    @staticmethod
    def together(poses: Sequence[Pose]) -> Pose:
        """M poses at once."""
        necks_camera = np.array([pose.neck_camera for pose in poses])
        return Pose(necks_camera, np.swapaxes(np.array([pose.Rs for pose in poses]), 0, 1))

    def apart(self) -> list[Pose]:
        """Inverse of `together`."""
        Rs = np.swapaxes(self.Rs, 0, 1)
        return [
            Pose(neck_camera, own) for neck_camera, own in zip(self.neck_camera, Rs, strict=True)
        ]

    def turned_round(self) -> Pose:
        """The pose that fills the same volume and faces the other way: every part turned half round
        about its own axis, left and right limbs exchanged."""
        return Pose(self.neck_camera, self.Rs[list(OTHER_SIDE)] @ HALF_ROUND)

    def transforms(self, model: BodyModel) -> Array:
        """[11, 4, 4] `Ts_camera_part`."""
        return transform(self.Rs, self.origins(model))


@dataclass(frozen=True, slots=True, eq=False)
class FittedBody:
    """Somebody's body in one frame.

    Attributes:
        person: id.
        model: its size.
        Ts_camera_part: [11, 4, 4], NaN for parts that are not tracked.
    """

    person: int
    model: BodyModel
    Ts_camera_part: NDArray[np.float64]


def mirrored(Rs: Array) -> Array:
    """[N, 11, 3, 3] rotations of who does the same with the other side."""
    return (MIRRORED @ Rs @ MIRRORED)[:, list(OTHER_SIDE)]
