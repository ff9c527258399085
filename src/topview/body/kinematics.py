"""Forward kinematics: from rotations to poses of the parts and joints."""

from __future__ import annotations

from functools import cache

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
    """[11, ..., 3, 3] rotations of parts in the camera frame to the same in their parents'
    frames."""
    Rs = np.array(Rs_camera_part, np.float64)
    parts, parents = _columns(tree)
    Rs[parts] = np.swapaxes(Rs_camera_part[parents], -1, -2) @ Rs_camera_part[parts]
    return Rs


@cache
def _columns(tree: Tree) -> NDArray[np.int64]:
    """[2, N] the parts and their parents."""
    return np.array(tree).T


def rotations_in_camera(Rs_parent_part: NDArray, tree: Tree = FROM_HEAD) -> NDArray[np.float64]:
    """Inverse of `rotations_in_parent`."""
    Rs = np.array(Rs_parent_part, np.float64)
    for parts, parents in _generations(tree):
        Rs[parts] = Rs[parents] @ Rs_parent_part[parts]
    return Rs


@cache
def _generations(tree: Tree) -> tuple[NDArray[np.int64], ...]:
    """[2, N] parts and their parents, for each distance from the root."""
    distance: dict[int, int] = {}
    for part, parent in tree:
        distance[part] = distance.get(parent, 0) + 1
    return tuple(
        np.array([pair for pair in tree if distance[pair[0]] == n]).T
        for n in sorted(set(distance.values()))
    )


def joints_from_parts(model: BodyModel, Ts_camera_part: NDArray) -> NDArray[np.float64]:
    """[11, 4, 4] poses to [16, 3] joints_camera in metres."""
    T = Ts_camera_part[_JOINT_PARTS]
    return np.einsum("jab,jb->ja", T[:, :3, :3], model.joints_part) + T[:, :3, 3]
