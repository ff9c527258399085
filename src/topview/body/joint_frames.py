"""The outputs' joints as a tree: how each is turned in its parent's frame, and where it lies there.

It is the tree of `topview.body.hierarchy` without the waist, which is no joint: the mid spine turns
as the upper torso. All bones keep their lengths but those from the mid spine to the neck and to the
shoulders, on which the spine bends.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.hierarchy import NODE_INDEX, NODES, WAIST, in_parents, nodes_in_camera, nodes_of
from topview.body.parts import OUTPUT_JOINT_NAMES

Array = NDArray[np.float64]

_NODES = np.array([NODE_INDEX[name] for name in OUTPUT_JOINT_NAMES])
# The node as which each joint turns.
_TURNS_AS = np.array(
    [NODE_INDEX[WAIST if name == "torso" else name] for name in OUTPUT_JOINT_NAMES]
)


def _parent(name: str) -> int:
    node = NODES[NODE_INDEX[name]].parent
    if node >= 0 and NODES[node].name == WAIST:
        node = NODES[node].parent
    return OUTPUT_JOINT_NAMES.index(NODES[node].name) if node >= 0 else -1


JOINT_PARENTS: Final[tuple[int, ...]] = tuple(_parent(name) for name in OUTPUT_JOINT_NAMES)
"""[20] of each of `OUTPUT_JOINTS` the one that it hangs from, -1 for the pelvis, the root."""


def joint_frames(joints_camera: Array, Ts_camera_part: Array) -> tuple[Array, Array]:
    """The joints of N bodies in their parents' frames.

    In the reference pose, upright with the arms hanging, all frames have +x to the person's right,
    +y down and +z to the front.

    Args:
        joints_camera: [N, 20, 3] in the order of `OUTPUT_JOINTS`, metres.
        Ts_camera_part: [N, 11, 4, 4] in the order of `PARTS`.

    Returns:
        [N, 20, 3, 3] `Rs_parent_joint` and [N, 20, 3] `offsets_parent_joint_m`, from each joint's
        parent to the joint; the root's both in the camera's frame. NaN where they are not known.
    """
    places, Rs_camera_node = nodes_in_camera(joints_camera, Ts_camera_part)
    offsets_m, Rs_parent_joint = in_parents(
        places[:, _NODES], Rs_camera_node[:, _TURNS_AS], np.array(JOINT_PARENTS)
    )
    return Rs_parent_joint, offsets_m


def joints_from_frames(Rs_parent_joint: Array, offsets_parent_joint_m: Array) -> Array:
    """[N, 20, 3] `joints_camera`: the inverse of `joint_frames`, which is forward kinematics."""
    Rs, places = Rs_parent_joint.copy(), offsets_parent_joint_m.copy()
    for joint in PARENTS_FIRST:
        parent = JOINT_PARENTS[joint]
        places[:, joint] = places[:, parent] + (Rs[:, parent] @ places[:, joint, :, None])[..., 0]
        Rs[:, joint] = Rs[:, parent] @ Rs[:, joint]
    return places


def _depth(joint: int) -> int:
    return 0 if JOINT_PARENTS[joint] < 0 else 1 + _depth(JOINT_PARENTS[joint])


PARENTS_FIRST: Final = tuple(sorted(range(len(JOINT_PARENTS)), key=_depth)[1:])
"""All joints but the root, each after its parent."""


def bone_lengths(joints_camera: Array, Ts_camera_part: Array) -> Array:
    """[N, 20] metres from its parent to each joint while the body stands in the reference pose, 0
    for the root; NaN where it is not known. Arguments as of `joint_frames`."""
    offsets_m, _ = nodes_of(joints_camera, Ts_camera_part)
    straight_m = offsets_m[:, _NODES]
    for joint, node in enumerate(_NODES):
        parent = NODES[node].parent
        if parent >= 0 and NODES[parent].name == WAIST:
            straight_m[:, joint] += offsets_m[:, parent]
    lengths_m = np.linalg.norm(straight_m, axis=-1)
    root = JOINT_PARENTS.index(-1)
    lengths_m[:, root] = np.where(np.isfinite(lengths_m[:, root]), 0.0, np.nan)
    return lengths_m
