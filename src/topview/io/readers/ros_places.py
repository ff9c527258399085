"""Where the sensors of a ROS bag are: by static transforms, or by librealsense's own."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.io.readers.ros_messages import TRANSFORMS_TYPE, Messages
from topview.records import InputError, rigid_transform

_EXTRINSIC: Final = re.compile(r"rotation=(.+);translation=(.+)")

Transforms = Mapping[tuple[str, str], NDArray[np.float64]]
"""[4, 4] T_parent_child by the names of both."""


class Places:
    """Transforms between sensors, [4, 4] each; None where no message tells one."""

    def __init__(self, bag: Messages) -> None:
        self._bag = bag

    def by_static_transforms(self, to: str, from_: str) -> NDArray[np.float64] | None:
        """T_to_from of frames, as a robot says it."""
        transforms: dict[tuple[str, str], NDArray[np.float64]] = {}
        static = self._bag.topics.get("/tf_static")
        if static is not None and static.message_type == TRANSFORMS_TYPE:
            for _, _, message in self._bag.messages([static.name]):
                for stamped in message.transforms:
                    names = stamped.header.frame_id.strip("/"), stamped.child_frame_id.strip("/")
                    transforms[names] = transform_of(stamped.transform)
        return transform_between(transforms, to, from_)

    def by_realsense(self, to: str, from_: str) -> NDArray[np.float64] | None:
        """T_to_from of topics, by each stream's T_stream_reference as librealsense stores it."""
        T_to, T_from = (self._extrinsic(topic) for topic in (to, from_))
        if T_to is None or T_from is None:
            return None
        return rigid_transform(T_to @ np.linalg.inv(T_from), "a transform")

    def _extrinsic(self, topic: str) -> NDArray[np.float64] | None:
        if not topic.startswith("/device_"):
            return None
        place = f"{topic.rsplit('/', 2)[0]}/tf/"
        name = next((name for name in self._bag.topics if name.startswith(place)), None)
        message: Any = None if name is None else self._bag.first(name)
        if message is None or hasattr(message, "rotation"):
            return None if message is None else transform_of(message)
        return extrinsic_of(str(getattr(message, "data", "")))


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
