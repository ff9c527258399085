"""Which topics of ROS messages hold the images that are read, and by which cameras they were taken.

Of all topics one with depth images is read, and one with colour, by names and encodings. Cameras
are their `CameraInfo`s'. Colour is registered to the depth here, by the transforms in `/tf_static`,
or by librealsense's own, unless the depth is registered to it already.
"""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from topview.files import naming
from topview.io.camera_values import INTRINSICS_KEYS
from topview.io.readers.camera_json import MAX_BASELINE_M, metres_per_unit
from topview.io.readers.depth import METRES_PER_MILLIMETRE
from topview.io.readers.gravity import MOST_SAMPLES, levelled_by
from topview.io.readers.registration import ColorCamera
from topview.io.readers.rig import Rig
from topview.io.readers.ros_cameras import camera_of
from topview.io.readers.ros_images import is_color, is_depth
from topview.io.readers.ros_messages import Messages, Topic
from topview.io.readers.ros_places import Places
from topview.records import Camera, InputError

IMAGE_TYPES: Final = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
IMU_TYPE: Final = "sensor_msgs/msg/Imu"
INFO_TYPE: Final = "sensor_msgs/msg/CameraInfo"
_REGISTERED: Final = re.compile(r"aligned|registered")
_INFRARED: Final = re.compile(r"infra|(^|[/_])ir([/_]|$)|confidence", re.IGNORECASE)
_RECTIFIED: Final = re.compile(r"rect(?!.*_raw)")  # not RealSense's image_rect_raw, whose K holds


class TopicChoice:
    """Which topics are read, and by which cameras their images were taken.

    Args:
        bag: the messages.
        problems: what is left aside is added to them.
        depth_info: the topic that tells the camera of the depth images; by default the nearest to
            theirs by name.

    Attributes:
        depth: the topic of depth images.
        first_depth: its first message.
        color: the topic of colour images; None where there is none or, once `rig` was asked,
            where its camera is not known.
        is_registered: colour is registered to the depth.

    Raises:
        InputError: there are no depth images.
    """

    def __init__(self, bag: Messages, problems: list[str], depth_info: str | None = None) -> None:
        self._bag = bag
        self._problems = problems
        self._depth_info = depth_info
        topics = bag.topics
        images = [t for t in topics.values() if t.message_type in IMAGE_TYPES and t.count]
        self._first: dict[str, Any] = {
            t.name: bag.first(t.name) for t in images if not _INFRARED.search(t.name)
        }
        depths = [t for t in images if t.name in self._first and is_depth(self._first[t.name])]
        if not depths:
            held = ", ".join(f"{t.name} ({t.message_type})" for t in topics.values()) or "nothing"
            raise InputError(
                f"has no topic of depth images; it holds {held}; it must hold sensor_msgs/Image of "
                "16UC1 or 32FC1, or compressedDepth"
            )
        self.depth = max(depths, key=_depth_preference)
        self.first_depth = self._first[self.depth.name]
        if len(depths) > 1:
            others = ", ".join(t.name for t in depths if t is not self.depth)
            problems.append(f"depth is read from {self.depth.name}; {others} are left aside")
        colors = [t for t in images if t.name in self._first and is_color(self._first[t.name])]
        self.color = max(colors, key=_color_preference, default=None)
        self._infos = {
            t.name: info
            for t in topics.values()
            if t.message_type == INFO_TYPE and (info := bag.first(t.name)) is not None
        }
        self._places = Places(bag)
        self.is_registered = bool(_REGISTERED.search(self.depth.name))

    def rig(self) -> Rig:
        """The cameras; without the colour's where it is registered, missing or not known."""
        camera = self._camera(self.depth)
        if camera is None:
            raise InputError(
                f"has no sensor_msgs/CameraInfo for {self.depth.name}; it must be recorded with it"
            )
        camera = self._levelled(camera)
        rig = Rig(camera)
        if self.color is None:
            self._problems.append("has no colour images")
        elif not self.is_registered:
            rig = Rig(camera, self._color_camera(self.color, camera), "their CameraInfo")
        if rig.color_camera is None and not self.is_registered:
            self.color = None
        return rig

    def metres_per_unit(self) -> float:
        """Of 16-bit depth: millimetres, unless librealsense says otherwise."""
        sensor = self.depth.name.rsplit("/", 3)[0]
        option = f"{sensor}/option/Depth_Units/value"
        told = self._bag.first(option) if self._is_realsense else None
        if told is None:
            return METRES_PER_MILLIMETRE
        return metres_per_unit(float(f"{told.data:.6g}"))  # of 32 bits: 0.001 is not all it has

    @property
    def _is_realsense(self) -> bool:
        return self.depth.name.startswith("/device_")

    def _camera(self, topic: Topic) -> Camera | None:
        """By the CameraInfo nearest by name, of the same size and best of the same frame."""
        image = self._first[topic.name]
        parts = topic.name.split("/")

        def likeness(name: str) -> tuple[int, bool]:
            pairs = zip(parts, name.split("/"), strict=False)
            alike = next((n for n, (a, b) in enumerate(pairs) if a != b), len(parts))
            return alike, self._infos[name].header.frame_id == image.header.frame_id

        size = (getattr(image, "width", None), getattr(image, "height", None))
        fitting = [
            name
            for name, info in self._infos.items()
            if size == (None, None) or size == (info.width, info.height)
        ]
        if topic is self.depth and self._depth_info is not None:
            if self._depth_info not in fitting:
                raise InputError(
                    f"{self._depth_info} is no sensor_msgs/CameraInfo of {size[0]} x {size[1]} "
                    f"pixels, the size of {topic.name}"
                )
            fitting = [self._depth_info]
        if not fitting:
            return None
        name = max(fitting, key=likeness)
        with naming(Path(name)):
            is_rectified = bool(_RECTIFIED.search(topic.name.rsplit("/", 1)[-1]))
            sensor = "stereo" if self._is_realsense else "kinect1"
            return camera_of(self._infos[name], is_rectified, sensor)

    def _color_camera(self, topic: Topic, camera: Camera) -> ColorCamera | None:
        """None where colour is registered, or left aside because nobody knows where it was."""
        taken = self._camera(topic)
        frames = [self._first[t.name].header.frame_id.strip("/") for t in (topic, self.depth)]
        T = self._places.by_realsense(topic.name, self.depth.name)
        if T is None and taken is not None and frames[0] == frames[1] and _is_same(taken, camera):
            self.is_registered = True
            return None
        if T is None:
            T = self._places.by_static_transforms(*frames)
        why = "has no CameraInfo" if taken is None else ""
        if T is None:
            why = f"no static transform leads from {frames[1]!r} to its frame {frames[0]!r}"
        elif np.linalg.norm(T[:3, 3]) > MAX_BASELINE_M:
            why = f"is more than {MAX_BASELINE_M:g} m from the depth camera"
        if taken is None or T is None or why:
            self._problems.append(f"{topic.name}: {why}; going on without colour")
            return None
        return ColorCamera(taken, T)

    def _levelled(self, camera: Camera) -> Camera:
        """The camera with its gravity, if an accelerometer tells it."""
        topics = [t for t in self._bag.topics.values() if t.message_type == IMU_TYPE and t.count]
        topics = [t for t in topics if "gyro" not in t.name.lower()]
        if not topics:
            return camera
        topic = max(topics, key=lambda t: ("accel" in t.name.lower(), t.name))
        try:
            told = [m for _, _, m in islice(self._bag.messages([topic.name]), MOST_SAMPLES)]
        except InputError:  # whoever reads the frames is told
            return camera
        frames = [m.header.frame_id.strip("/") for m in (self.first_depth, told[0])]
        T = self._places.by_realsense(self.depth.name, topic.name)
        if T is None:
            T = self._places.by_static_transforms(*frames)
        if T is None:
            self._problems.append(
                f"{topic.name}: no static transform leads from its frame {frames[1]!r} to "
                f"{frames[0]!r}; gravity is left to the floor"
            )
            return camera
        accelerations = [m.linear_acceleration for m in told]
        samples = [np.array([a.x, a.y, a.z]) for a in accelerations]
        return levelled_by(camera, samples, T[:3, :3], self._problems)


def _is_same(a: Camera, b: Camera) -> bool:
    return all(getattr(a, key) == getattr(b, key) for key in INTRINSICS_KEYS)


def _depth_preference(topic: Topic) -> tuple[bool, bool, int, str]:
    return (
        "depth" in topic.name.lower(),
        bool(_REGISTERED.search(topic.name)),
        topic.count,
        topic.name,
    )


def _color_preference(topic: Topic) -> tuple[bool, bool, int, str]:
    is_named = bool(re.search(r"rgb|colou?r", topic.name, re.IGNORECASE))
    return is_named, topic.message_type == IMAGE_TYPES[0], topic.count, topic.name
