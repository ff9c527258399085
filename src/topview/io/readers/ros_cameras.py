"""Cameras of ROS messages: `sensor_msgs/CameraInfo`, and where they are by static transforms."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.records import Camera, Distortion, InputError, SensorName, rigid_transform

# What `sensor_msgs/distortion_models.hpp` and librealsense call a lens.
ROS_MODELS: Final = {
    "plumb_bob": "brown_conrady",
    "rational_polynomial": "rational",
    "Brown Conrady": "brown_conrady",
    "Inverse Brown Conrady": "inverse_brown_conrady",
}

_EXTRINSIC: Final = re.compile(r"rotation=(.+);translation=(.+)")

Transforms = Mapping[tuple[str, str], NDArray[np.float64]]
"""[4, 4] T_parent_child by the names of both."""


def camera_of(info: Any, is_rectified: bool, sensor: SensorName) -> Camera:
    """The camera of a CameraInfo message, of ROS 1 or 2.

    Args:
        info: the message.
        is_rectified: its images are; then the projection P holds, and no lens.
        sensor: what kind of depth camera.

    Raises:
        InputError: not calibrated, or a lens that is not known.
    """
    K, P, D = (np.asarray(_field(info, name), np.float64).ravel() for name in "KPD")
    if is_rectified and P.size == 12 and P[0] > 0.0:
        fx, fy, cx, cy = P[0], P[5], P[2], P[6]
        lens = None
    else:
        if K.size != 9 or not K[0] > 0.0:
            raise InputError("has K of zeros; the camera must be calibrated")
        fx, fy, cx, cy = K[0], K[4], K[2], K[5]
        lens = _lens(str(info.distortion_model), D)
    return Camera(fx, fy, cx, cy, int(info.width), int(info.height), lens, sensor)


def _field(info: Any, name: str) -> Any:
    """ROS 1 has capital letters, ROS 2 small ones."""
    return getattr(info, name, None) if hasattr(info, name) else getattr(info, name.lower())


def _lens(model: str, coefficients: NDArray[np.float64]) -> Distortion | None:
    if not coefficients.any():
        return None
    if model not in ROS_MODELS:
        raise InputError(
            f"distortion_model is {model!r}; it must be one of {', '.join(ROS_MODELS)}, or images "
            "must be rectified"
        )
    return Distortion(ROS_MODELS[model], tuple(coefficients.tolist()))


def transform_of(message: Any) -> NDArray[np.float64]:
    """[4, 4] of a `geometry_msgs/Transform`. Raises InputError for one that is not rigid."""
    q, t = message.rotation, message.translation
    T = np.eye(4)
    try:
        T[:3, :3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
    except ValueError:
        raise InputError("has a rotation of zeros; it must be a quaternion") from None
    T[:3, 3] = t.x, t.y, t.z
    return rigid_transform(T, "a transform")


def extrinsic_of(text: str) -> NDArray[np.float64] | None:
    """[4, 4] of what librealsense writes for ROS 2, nine numbers by columns and three; None for
    anything else."""
    match = _EXTRINSIC.fullmatch(text)
    if match is None:
        return None
    T = np.eye(4)
    try:
        rotation, shift = (np.array(part.split(","), np.float64) for part in match.groups())
        T[:3, :3], T[:3, 3] = rotation.reshape(3, 3).T, shift
    except ValueError:
        return None
    return rigid_transform(T, "a transform")


def transform_between(transforms: Transforms, to: str, from_: str) -> NDArray[np.float64] | None:
    """[4, 4] T_to_from along a chain of transforms, forwards and back; None without one."""
    steps: dict[str, dict[str, NDArray[np.float64]]] = {}
    for (parent, child), T_parent_child in transforms.items():
        steps.setdefault(child, {})[parent] = T_parent_child
        steps.setdefault(parent, {})[child] = np.linalg.inv(T_parent_child).astype(np.float64)
    reached = {from_: np.eye(4)}
    waiting = [from_]
    while waiting and to not in reached:
        frame = waiting.pop(0)
        for other, T_other_frame in steps.get(frame, {}).items():
            if other not in reached:
                reached[other] = T_other_frame @ reached[frame]
                waiting.append(other)
    return reached.get(to)
