"""Tiny ROS bags, written by rosbags itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

WIDTH, HEIGHT = 32, 24
K = [30.0, 0.0, 15.5, 0.0, 31.0, 11.5, 0.0, 0.0, 1.0]
KINDS = ("bag", "db3", "mcap")


class BagWriter:
    """Writes a bag of one of `KINDS`; it is a context manager.

    Attributes:
        path: what a user would give.
        file: the file that holds the messages.
    """

    def __init__(self, folder: Path, kind: str) -> None:
        self._is_ros1 = kind == "bag"
        store = Stores.ROS1_NOETIC if self._is_ros1 else Stores.ROS2_HUMBLE
        self._store = get_typestore(store)
        transforms = "geometry_msgs/TransformStamped[] transforms"
        self._store.register(get_types_from_msg(transforms, "tf2_msgs/msg/TFMessage"))
        self.trailing = b""
        self._topics: dict[str, Any] = {}
        if self._is_ros1:
            self.path = self.file = folder / "walk.bag"
            self._writer: Any = rosbag1.Writer(self.path)
        else:
            self.path = folder / "walk"
            self.file = self.path / f"walk.{kind}"
            plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
            self._writer = rosbag2.Writer(self.path, version=9, storage_plugin=plugin)

    def __enter__(self) -> BagWriter:
        self._writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def make(self, kind: str, **fields: Any) -> Any:
        """A message."""
        return self._store.types[kind](**fields)

    def write(self, topic: str, message: Any, time_s: float = 0.0) -> None:
        kind = message.__msgtype__
        if topic not in self._topics:
            self._topics[topic] = self._writer.add_connection(topic, kind, typestore=self._store)
        write = self._store.serialize_ros1 if self._is_ros1 else self._store.serialize_cdr
        data = bytes(write(message, kind)) + self.trailing
        self._writer.write(self._topics[topic], round(time_s * 1e9), data)

    def header(self, time_s: float, frame: str) -> Any:
        sec, nanosec = divmod(round(time_s * 1e9), 10**9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        sequence = {"seq": 0} if self._is_ros1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **sequence)

    def image(
        self,
        topic: str,
        image: np.ndarray,
        encoding: str,
        time_s: float,
        frame: str,
        received_s: float | None = None,
    ) -> None:
        """Of rows that are padded with four bytes."""
        rows = image.reshape(len(image), -1)
        padded = np.concatenate([rows.view(np.uint8), np.full((len(rows), 4), 99, np.uint8)], 1)
        message = self.make(
            "sensor_msgs/msg/Image",
            header=self.header(time_s, frame),
            height=image.shape[0],
            width=image.shape[1],
            encoding=encoding,
            is_bigendian=int(image.dtype.byteorder == ">"),
            step=padded.shape[1],
            data=padded.ravel(),
        )
        self.write(topic, message, time_s if received_s is None else received_s)

    def compressed(self, topic: str, data: bytes, format: str, time_s: float, frame: str) -> None:
        header = self.header(time_s, frame)
        array = np.frombuffer(data, np.uint8)
        kind = "sensor_msgs/msg/CompressedImage"
        self.write(topic, self.make(kind, header=header, format=format, data=array), time_s)

    def info(self, topic: str, frame: str, **changed: Any) -> None:
        """A pinhole camera, unless something is changed; keys as ROS 1 has them."""
        values = {
            "width": WIDTH, "height": HEIGHT, "distortion_model": "plumb_bob", "D": np.zeros(5),
            "K": np.array(K), "R": np.eye(3).ravel(), "P": np.zeros(12), "binning_x": 0,
            "binning_y": 0,
        } | changed  # fmt: skip
        if not self._is_ros1:
            values = {key.lower() if len(key) == 1 else key: v for key, v in values.items()}
        roi = dict.fromkeys(("x_offset", "y_offset", "height", "width"), 0)
        region = self.make("sensor_msgs/msg/RegionOfInterest", **roi, do_rectify=False)
        header = self.header(0.0, frame)
        kind = "sensor_msgs/msg/CameraInfo"
        self.write(topic, self.make(kind, header=header, roi=region, **values))

    def imu(self, topic: str, frame: str, acceleration: tuple[float, float, float]) -> None:
        """A sample of an accelerometer alone."""
        nothing = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        x, y, z = acceleration
        sample = self.make(
            "sensor_msgs/msg/Imu",
            header=self.header(0.0, frame),
            orientation=self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=np.zeros(9),
            angular_velocity=nothing,
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
            linear_acceleration_covariance=np.zeros(9),
        )
        self.write(topic, sample)

    def transform(self, x_m: float, about_x_rad: float = 0.0) -> Any:
        """Of a shift along x and a turn about it."""
        shift = self.make("geometry_msgs/msg/Vector3", x=x_m, y=0.0, z=0.0)
        half = about_x_rad / 2
        turn = self.make(
            "geometry_msgs/msg/Quaternion", x=np.sin(half), y=0.0, z=0.0, w=np.cos(half)
        )
        return self.make("geometry_msgs/msg/Transform", translation=shift, rotation=turn)

    def static(self, parent: str, child: str, x_m: float, about_x_rad: float = 0.0) -> None:
        """The child's place in the parent's frame."""
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(0.0, parent),
            child_frame_id=child,
            transform=self.transform(x_m, about_x_rad),
        )
        self.write("/tf_static", self.make("tf2_msgs/msg/TFMessage", transforms=[stamped]))


def depth_mm(index: int) -> np.ndarray:
    """[24, 32] millimetres, another image for every frame."""
    rng = np.random.default_rng(index)
    image = rng.integers(500, 6000, (HEIGHT, WIDTH), np.uint16)
    image[0, :2] = 0, 29_999
    return image


def shade(index: int) -> np.ndarray:
    """[24, 32, 3] of one colour."""
    return np.full((HEIGHT, WIDTH, 3), (10 + index, 90, 200), np.uint8)
