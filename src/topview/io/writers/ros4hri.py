"""What ROS4HRI (REP 155) says of a body: names, the joints of its URDF, places in the image.

The joints are those of the package `human_description`: bodies have x to the front, y to the left
and z up, hang their arms, and turn about one axis at each joint.
"""

from __future__ import annotations

import warnings
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.body.hierarchy import NODES, WAIST
from topview.body.parts import OUTPUT_JOINT_NAMES
from topview.camera import project
from topview.geometry.rotations import are_rotations
from topview.io.writers.levelled import ROS_FROM_STAGE
from topview.records import Camera

Array = NDArray[np.float64]

ROS_FROM_PART: Final = ROS_FROM_STAGE  # a part has its x, y and z where the stage has them
# `hri_msgs` is not among the messages that rosbags knows; constants are left out.
IDS_TYPE: Final = "hri_msgs/msg/IdsList"
POINT_TYPE: Final = "hri_msgs/msg/NormalizedPointOfInterest2D"
SKELETON_TYPE: Final = "hri_msgs/msg/Skeleton2D"
DEFINITIONS: Final = {
    IDS_TYPE: "std_msgs/Header header\nstring[] ids",
    POINT_TYPE: "float32 x\nfloat32 y\nfloat32 c",
    SKELETON_TYPE: f"std_msgs/Header header\n{POINT_TYPE}[18] skeleton",
}
# Of `Skeleton2D`, in its order, which is OpenPose's; empty for what no joint is.
KEYPOINTS: Final = (
    "", "neck",
    "right_shoulder", "right_elbow", "right_wrist", "left_shoulder", "left_elbow", "left_wrist",
    "right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle",
    "", "", "", "",
)  # fmt: skip
HANGS_BELOW_RAD: Final = 1e-6  # ours: an arm that is raised by less hangs
# REP 155's names where it has some, ours for `lower_torso`, `neck`, hands and feet.
_NAMES: Final = {"pelvis": "body", "torso": "lower_torso", WAIST: "waist"}
# Node: the axes of its turns, each about what the one before has turned, and for each the joint and
# the sign of its axis in the URDF.
_TURNS: Final[dict[str, tuple[str, tuple[tuple[str, int], ...]]]] = {
    WAIST: ("YXZ", (("waist", 1),)),
    "neck": ("XZY", (("r_head", 1), ("y_head", 1), ("p_head", -1))),
    "left_elbow": ("YXZ", (("l_elbow", -1),)),
    "right_elbow": ("YXZ", (("r_elbow", -1),)),
    "left_knee": ("YXZ", (("l_knee", -1),)),
    "right_knee": ("YXZ", (("r_knee", -1),)),
    "left_shoulder": ("ZXZ", (("l_y_shoulder", -1), ("l_p_shoulder", 1), ("l_r_shoulder", 1))),
    "right_shoulder": ("ZXZ", (("r_y_shoulder", 1), ("r_p_shoulder", -1), ("r_r_shoulder", -1))),
    "left_hip": ("ZXY", (("l_y_hip", -1), ("l_p_hip", 1), ("l_r_hip", -1))),
    "right_hip": ("ZXY", (("r_y_hip", -1), ("r_p_hip", -1), ("r_r_hip", -1))),
}


def frame_name(node: str, body: str) -> str:
    """What REP 155 calls the frame of a node of `topview.body.hierarchy`."""
    side, _, kind = node.partition("_")
    is_limb = side in ("left", "right")
    name = f"{side[0]}_{kind}" if is_limb else _NAMES.get(node, node)
    return f"{name}_{body}"


def body_id(person_id: int) -> str:
    """A person's number as a part of topics, none of which may begin with a digit."""
    return f"p{person_id}"


def joint_turns(Rs_parent_node: Array) -> dict[str, float]:
    """Radians of the URDF's joints, of [K, 3, 3] turns of one body's nodes; those that are not
    known are left out. What a joint cannot turn, as the waist sideways, is dropped."""
    turns: dict[str, float] = {}
    for node, R_parent_node in zip(NODES, Rs_parent_node, strict=True):
        axes, joints = _TURNS.get(node.name, ("", ()))
        if not axes or not are_rotations(R_parent_node):
            continue
        R = Rotation.from_matrix(ROS_FROM_PART @ R_parent_node @ ROS_FROM_PART.T)
        for (name, sign), turn in zip(joints, _turns(R, axes, joints), strict=False):
            turns[name] = sign * float(turn)
    return turns


def _turns(R: Rotation, axes: str, joints: tuple[tuple[str, int], ...]) -> Array:
    """[3] turns about the axes; of an arm those that raise it by a positive turn of its joint."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an arm that hangs: only the sum of two turns is known
        turns = np.asarray(R.as_euler(axes))
    if axes == "ZXZ" and joints[1][1] * turns[1] < -HANGS_BELOW_RAD:
        turns = (turns * (1, -1, 1) + (2 * np.pi, np.pi, 2 * np.pi)) % (2 * np.pi) - np.pi
    return turns


def keypoints(joints_camera: Array, confidence: NDArray[np.floating], camera: Camera) -> Array:
    """[18, 3] of `KEYPOINTS`: x and y in the image, 0..1 from its upper left corner, and confidence
    0..1; zeros for those that are not known, or not in the image.

    Args:
        joints_camera: [J, 3] in the order of `OUTPUT_JOINT_NAMES`, metres.
        confidence: [J].
        camera: that took the image.
    """
    points = np.zeros((len(KEYPOINTS), 3))
    ours = np.array([k for k, name in enumerate(KEYPOINTS) if name])
    order = [OUTPUT_JOINT_NAMES.index(KEYPOINTS[k]) for k in ours]
    joints = joints_camera[order]
    is_ahead = np.isfinite(joints).all(-1) & (joints[:, 2] > 0.0)
    places = project(joints[is_ahead], camera)
    shares = (places + 0.5) / (camera.width, camera.height)
    is_inside = ((shares >= 0.0) & (shares <= 1.0)).all(-1)
    points[ours[is_ahead][is_inside], :2] = shares[is_inside]
    points[ours[is_ahead][is_inside], 2] = confidence[order][is_ahead][is_inside]
    return points
