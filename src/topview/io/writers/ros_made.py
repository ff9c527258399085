"""Messages of ROS 2, with all the fields that nobody wants filled in."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

CAMERA_FRAME: Final = "camera_depth_optical_frame"
NS_PER_S: Final = 1_000_000_000
SPHERES, LINES, REMOVE_ALL = 7, 5, 3  # of visualization_msgs/Marker


class Messages:
    """Makes messages.

    Args:
        types: their classes, by the names of their types.
    """

    def __init__(self, types: Any) -> None:
        self._types = types

    def marker(
        self,
        number: int,
        action: int,
        width_m: float,
        kind: int,
        time_s: float,
        points: list[Any],
        colors: list[Any],
    ) -> Any:
        """`visualization_msgs/Marker` in the camera's frame; points with a color each, metres."""
        make = self._types
        vector = make["geometry_msgs/msg/Vector3"]
        no_image = make["sensor_msgs/msg/CompressedImage"](
            self.header("", 0.0), "", np.zeros(0, np.uint8)
        )
        return make["visualization_msgs/msg/Marker"](
            header=self.header(CAMERA_FRAME, time_s),
            ns="skeleton",
            id=number,
            type=kind,
            action=action,
            pose=make["geometry_msgs/msg/Pose"](
                make["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), self.quaternion(np.eye(3))
            ),
            scale=vector(width_m, width_m, width_m),
            color=make["std_msgs/msg/ColorRGBA"](1.0, 1.0, 1.0, 1.0),
            lifetime=make["builtin_interfaces/msg/Duration"](0, 0),
            frame_locked=False,
            points=points,
            colors=colors,
            texture_resource="",
            texture=no_image,
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=make["visualization_msgs/msg/MeshFile"]("", np.zeros(0, np.uint8)),
            mesh_use_embedded_materials=False,
        )

    def transform(
        self, parent: str, child: str, R_parent_child: Array, origin_parent: Array, time_s: float
    ) -> Any:
        """`geometry_msgs/TransformStamped`: `p_parent = R p_child + origin`, metres."""
        make = self._types
        return make["geometry_msgs/msg/TransformStamped"](
            self.header(parent, time_s),
            child,
            make["geometry_msgs/msg/Transform"](
                make["geometry_msgs/msg/Vector3"](*origin_parent.tolist()),
                self.quaternion(R_parent_child),
            ),
        )

    def quaternion(self, R: Array) -> Any:
        """`geometry_msgs/Quaternion` of a [3, 3] rotation."""
        x, y, z, w = Rotation.from_matrix(R).as_quat(canonical=True).tolist()
        return self._types["geometry_msgs/msg/Quaternion"](x, y, z, w)

    def header(self, frame: str, time_s: float) -> Any:
        """`std_msgs/Header`."""
        make = self._types
        stamp = make["builtin_interfaces/msg/Time"](*divmod(nanoseconds(time_s), NS_PER_S))
        return make["std_msgs/msg/Header"](stamp, frame)


def nanoseconds(time_s: float) -> int:
    """As ROS counts time."""
    return round(time_s * NS_PER_S)


def offered_qos(topic: str) -> list[Any]:
    """Of static transforms, which whoever comes later must get, too."""
    if topic != "/tf_static":
        return []
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    never = QosTime(0, 0)
    return [
        Qos(
            QosHistory.KEEP_LAST,
            1,
            QosReliability.RELIABLE,
            QosDurability.TRANSIENT_LOCAL,
            never,
            never,
            QosLiveliness.SYSTEM_DEFAULT,
            never,
            False,
        )
    ]
