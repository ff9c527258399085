"""One person as the VMC protocol tells avatars: Unity's names and axes, bones that turn from the
T pose.

https://protocol.vmc.info/english gives the messages. Unity's world is left-handed: x right, y up,
z forward. Here its origin is the floor below the camera, and somebody who faces the camera looks
along z. A bone's rotation is that in the frame of the bone it hangs from; all are the identity in
the T pose, which has the arms level, while the project's own reference has them hanging.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.io.writers.levelled import BodyMotion
from topview.records import InputError
from topview.skeletons import About, SkeletonSequence, TrackedFrame

# Unity's HumanBodyBones of the nodes of `topview.body.hierarchy`; it has none of the palm.
UNITY_BONES: Final = {
    "pelvis": "Hips",
    "torso": "Spine",
    "waist": "Chest",
    "neck": "Neck",
    "head": "Head",
    **{
        f"{side}_{node}": f"{side.capitalize()}{bone}"
        for side in ("left", "right")
        for node, bone in (
            ("shoulder", "UpperArm"), ("elbow", "LowerArm"), ("wrist", "Hand"),
            ("hip", "UpperLeg"), ("knee", "LowerLeg"), ("ankle", "Foot"), ("foot", "Toes"),
        )
    },
}  # fmt: skip
UNITY_FROM_ANIMATION: Final = np.diag([-1.0, 1.0, 1.0])  # x to the left becomes x to the right
# From the T pose to hanging arms: about z, in the animation frame (x left, y up, z front).
_HANGING_LEFT: Final = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_ABOUT: Final = About(OUTPUT_JOINT_NAMES, PART_NAMES)


def vmc_messages(frame: TrackedFrame) -> list[tuple[str, tuple[Any, ...]]]:
    """The messages about the person with the lowest id; none if nobody has a pelvis."""
    motion = _motion(frame)
    if motion is None:
        return []
    rest = [_hanging_from_t_pose(name) for name in motion.names]
    messages: list[tuple[str, tuple[Any, ...]]] = [
        ("/VMC/Ext/OK", (1,)),
        ("/VMC/Ext/T", (float(frame.timestamp_s),)),
        ("/VMC/Ext/Root/Pos", ("root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
    ]
    M = UNITY_FROM_ANIMATION
    for n, (name, parent) in enumerate(zip(motion.names, motion.parents, strict=True)):
        if name not in UNITY_BONES:
            continue
        of_parent = rest[parent] if parent >= 0 else np.eye(3)
        R = of_parent.T @ motion.Rs_parent_node[0, n] @ rest[n]
        place = of_parent.T @ motion.offsets_m[n] if parent >= 0 else motion.root_m[0]
        x_y_z_w = Rotation.from_matrix(M @ R @ M).as_quat()
        values = (*map(float, M @ place), *map(float, x_y_z_w))
        messages.append(("/VMC/Ext/Bone/Pos", (UNITY_BONES[name], *values)))
    return messages


def _motion(frame: TrackedFrame) -> BodyMotion | None:
    if not len(frame.people):
        return None
    person = frame.people[[int(np.argmin(frame.people["id"]))]]
    alone = TrackedFrame(frame.index, frame.timestamp_s, frame.name, person, frame.floor_camera)
    try:
        return BodyMotion.of(SkeletonSequence.from_frames([alone], _ABOUT), "VMC")
    except InputError:  # no pelvis: a tracker of upper bodies
        return None


def _hanging_from_t_pose(node: str) -> NDArray[np.float64]:
    """[3, 3] how a node's limb turns from the T pose to the reference pose."""
    side, _, limb = node.partition("_")
    if limb not in ("shoulder", "elbow", "wrist"):
        return np.eye(3)
    return _HANGING_LEFT if side == "left" else _HANGING_LEFT.T
