"""Forward kinematics: from rotations to poses of the parts and joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import JOINTS, PARTS
from topview.geometry.rotations import transform

# A person who stands upright and faces the camera: right hand at the image's left.
R_CAMERA_FACING = np.diag([-1.0, 1.0, -1.0])

# Pairs of a part and the one that it hangs from, parents first; the root is in none.
Tree = tuple[tuple[int, int], ...]
FROM_HEAD: Tree = tuple(
    (index, part.parent) for index, part in enumerate(PARTS) if part.parent >= 0
)

_JOINT_PARTS = np.array([joint.part for joint in JOINTS])


def place_part(
    model: BodyModel, part: int, R_camera_parent: NDArray, origin_parent_camera: NDArray
) -> NDArray[np.float64]:
    """[3] camera position of a part's proximal joint, given its parent's pose."""
    return origin_parent_camera + R_camera_parent @ model.joints_parent[part]


def forward_kinematics(
    model: BodyModel, crown_camera: NDArray, Rs_camera_part: NDArray
) -> NDArray[np.float64]:
    """[3] position of the crown and [11, 3, 3] rotations to [11, 4, 4] `Ts_camera_part`."""
    origins = np.empty((len(PARTS), 3))
    origins[0] = crown_camera
    for part, parent in FROM_HEAD:
        origins[part] = place_part(model, part, Rs_camera_part[parent], origins[parent])
    return transform(Rs_camera_part, origins)


def rotations_in_parent(Rs_camera_part: NDArray, tree: Tree = FROM_HEAD) -> NDArray[np.float64]:
    """[11, 3, 3] rotations of parts in the camera frame to the same in their parents' frames."""
    Rs = np.array(Rs_camera_part, np.float64)
    for part, parent in tree:
        Rs[part] = Rs_camera_part[parent].T @ Rs_camera_part[part]
    return Rs


def rotations_in_camera(Rs_parent_part: NDArray, tree: Tree = FROM_HEAD) -> NDArray[np.float64]:
    """Inverse of `rotations_in_parent`."""
    Rs = np.array(Rs_parent_part, np.float64)
    for part, parent in tree:
        Rs[part] = Rs[parent] @ Rs_parent_part[part]
    return Rs


def joints_from_parts(model: BodyModel, Ts_camera_part: NDArray) -> NDArray[np.float64]:
    """[11, 4, 4] poses to [16, 3] joints_camera in metres."""
    T = Ts_camera_part[_JOINT_PARTS]
    return np.einsum("jab,jb->ja", T[:, :3, :3], model.joints_part) + T[:, :3, 3]
