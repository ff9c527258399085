"""The body as animation programs want it: a tree of nodes that hangs from the pelvis, bones of
constant length, and one rotation for each node.

The nodes are the reported joints and the `waist`, which is an articulation that no output names.
Without it the way from the pelvis to the neck would be no chain of rigid bones. In the reference
pose the person stands upright with the arms hanging, and all rotations are the identity, as in
Table 3.2: the frame of each node then has +x to the person's right, +y down and +z to the front.

A node turns with a body part; ankles turn with the foot, about which the parts say nothing: by the
least angle from where the foot is at rest on the lower leg to where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.ends import FEET_AT_REST
from topview.body.parts import (
    HEAD,
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    OUTPUT_JOINT_NAMES,
    RIGHT_FOREARM,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import shortest_turns, unit

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Node:
    """A place that moves with the body.

    Attributes:
        name: of the joint, or `waist`.
        parent: index of the node that it hangs from, -1 for the root.
        part: index of the body part that turns with the node, which carries its children; of
            ankles and feet the one on which the foot turns.
    """

    name: str
    parent: int
    part: int


WAIST: Final = "waist"
NODES: Final[tuple[Node, ...]] = (
    Node("pelvis", -1, LOWER_TORSO),
    Node("torso", 0, LOWER_TORSO),
    Node(WAIST, 1, UPPER_TORSO),
    Node("neck", 2, HEAD),
    Node("head", 3, HEAD),
    Node("left_shoulder", 2, LEFT_UPPER_ARM),
    Node("left_elbow", 5, LEFT_FOREARM),
    Node("left_wrist", 6, LEFT_FOREARM),
    Node("left_hand", 7, LEFT_FOREARM),
    Node("right_shoulder", 2, RIGHT_UPPER_ARM),
    Node("right_elbow", 9, RIGHT_FOREARM),
    Node("right_wrist", 10, RIGHT_FOREARM),
    Node("right_hand", 11, RIGHT_FOREARM),
    Node("left_hip", 0, LEFT_UPPER_LEG),
    Node("left_knee", 13, LEFT_LOWER_LEG),
    Node("left_ankle", 14, LEFT_LOWER_LEG),
    Node("left_foot", 15, LEFT_LOWER_LEG),
    Node("right_hip", 0, RIGHT_UPPER_LEG),
    Node("right_knee", 17, RIGHT_LOWER_LEG),
    Node("right_ankle", 18, RIGHT_LOWER_LEG),
    Node("right_foot", 19, RIGHT_LOWER_LEG),
)
ROOT: Final = 0

NODE_INDEX: Final = {node.name: n for n, node in enumerate(NODES)}
_JOINT_NODES = np.array([NODE_INDEX[name] for name in OUTPUT_JOINT_NAMES])
_PARENTS = np.array([node.parent for node in NODES])
_PARTS = np.array([node.part for node in NODES])
_ANKLES = [NODE_INDEX["left_ankle"], NODE_INDEX["right_ankle"]]
_FEET = [NODE_INDEX["left_foot"], NODE_INDEX["right_foot"]]


@dataclass(frozen=True, slots=True, eq=False)
class Articulation:
    """One person in N frames, as K = 21 nodes.

    Attributes:
        offsets_m: [K, 3] from each node's parent to the node, in the parent's frame; zeros for the
            root, NaN for nodes that are not known, such as the legs of an upper body.
        root_camera: [N, 3] where the root is, metres.
        Rs_parent_node: [N, K, 3, 3] each node's frame in its parent's; the root's in the camera's.
    """

    offsets_m: Array
    root_camera: Array
    Rs_parent_node: Array

    @property
    def known(self) -> NDArray[np.bool_]:
        """[K] the nodes that there are; those that hang from an unknown one are unknown too."""
        return np.asarray(np.isfinite(self.offsets_m).all(-1))

    def joints_camera(self) -> Array:
        """[N, J, 3] forward kinematics: the joints in the order of `OUTPUT_JOINT_NAMES`, metres."""
        Rs_camera_node = np.empty_like(self.Rs_parent_node)
        places = np.empty((*self.Rs_parent_node.shape[:2], 3))
        for n, node in enumerate(NODES):
            if node.parent < 0:
                Rs_camera_node[:, n], places[:, n] = self.Rs_parent_node[:, n], self.root_camera
            else:
                R = Rs_camera_node[:, node.parent]
                Rs_camera_node[:, n] = R @ self.Rs_parent_node[:, n]
                places[:, n] = places[:, node.parent] + R @ self.offsets_m[n]
        return places[:, _JOINT_NODES]


def articulated(joints_camera: Array, Ts_camera_part: Array) -> Articulation:
    """The nodes of one person in N frames.

    A bone's offset is the median over the frames. A tracker that changes its mind about the stature
    or lets the shoulders slide makes joints that lie on no rigid chain: `joints_camera` of the
    result is then off by as much.

    Args:
        joints_camera: [N, J, 3] metres, in the order of `OUTPUT_JOINT_NAMES`.
        Ts_camera_part: [N, B, 4, 4], in the order of `PART_NAMES`.
    """
    offsets_m, Rs_parent_node = nodes_of(joints_camera, Ts_camera_part)
    lengths_m = np.stack([_middle(offsets_m[:, n]) for n in range(len(NODES))])
    lengths_m[ROOT] = 0.0
    turns = np.isfinite(Rs_parent_node).all((-1, -2)).any(0)
    lengths_m[~turns] = np.nan
    return Articulation(lengths_m, offsets_m[:, ROOT], Rs_parent_node)


def nodes_of(joints_camera: Array, Ts_camera_part: Array) -> tuple[Array, Array]:
    """The nodes of N bodies, each as it is: [N, K, 3] from each node's parent to the node, in the
    parent's frame, metres, and [N, K, 3, 3] `Rs_parent_node`; the root's in the camera's frame.
    Those that are not known are NaN. Arguments as of `articulated`."""
    return in_parents(*nodes_in_camera(joints_camera, Ts_camera_part), _PARENTS)


def nodes_in_camera(joints_camera: Array, Ts_camera_part: Array) -> tuple[Array, Array]:
    """[N, K, 3] places and [N, K, 3, 3] rotations of the nodes in the camera's frame."""
    places = np.empty((len(joints_camera), len(NODES), 3))
    places[:, _JOINT_NODES] = joints_camera
    places[:, NODE_INDEX[WAIST]] = Ts_camera_part[:, LOWER_TORSO, :3, 3]
    Rs = Ts_camera_part[:, _PARTS, :3, :3]
    Rs_leg = Rs[:, _ANKLES]
    ways_leg = np.einsum("nlba,nlb->nla", Rs_leg, places[:, _FEET] - places[:, _ANKLES])
    Rs_leg_foot = shortest_turns(unit(FEET_AT_REST), unit(ways_leg))
    is_told = np.isfinite(ways_leg).all(-1)[..., None, None]
    Rs[:, _ANKLES] = Rs[:, _FEET] = Rs_leg @ np.where(is_told, Rs_leg_foot, np.eye(3))
    return places, Rs


def in_parents(
    places: Array, Rs_camera_node: Array, parents: NDArray[np.intp]
) -> tuple[Array, Array]:
    """[N, K, 3] from each node's parent to the node and [N, K, 3, 3] its rotation, both in the
    parent's frame; the camera's for nodes whose parent is -1."""
    hang = parents >= 0
    above = parents[hang]
    Rs_parent_camera = np.swapaxes(Rs_camera_node[:, above], -1, -2)
    Rs_parent_node, offsets_m = Rs_camera_node.copy(), places.copy()
    Rs_parent_node[:, hang] = Rs_parent_camera @ Rs_camera_node[:, hang]
    ways = places[:, hang] - places[:, above]
    offsets_m[:, hang] = (Rs_parent_camera @ ways[..., None])[..., 0]
    return offsets_m, Rs_parent_node


def _middle(vectors: Array) -> Array:
    """[3] median of those of [N, 3] that are known; NaN if none is."""
    known = vectors[np.isfinite(vectors).all(-1)]
    return np.median(known, axis=0) if len(known) else np.full(3, np.nan)
