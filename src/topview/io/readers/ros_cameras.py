"""Cameras of ROS messages: `sensor_msgs/CameraInfo`."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.records import Camera, Distortion, InputError, SensorName

# What `sensor_msgs/distortion_models.hpp` and librealsense call a lens.
ROS_MODELS: Final = {
    "plumb_bob": "brown_conrady",
    "rational_polynomial": "rational",
    "Brown Conrady": "brown_conrady",
    "Inverse Brown Conrady": "inverse_brown_conrady",
}


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
