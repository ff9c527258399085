"""ROS bags: of ROS 1, RealSense's among them, and of ROS 2, as SQLite or MCAP."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io.readers.pairing import StoredImage
from topview.io.readers.ros_images import image_color, image_depth_m
from topview.io.readers.ros_messages import BAG_SUFFIXES, Bag, starts_with, taken_s
from topview.io.readers.ros_topics import TopicChoice
from topview.io.readers.stream_recording import StreamRecording


def recognises(path: Path) -> bool:
    if (path / "depth").is_dir():  # a folder of images, whatever lies beside them
        return False
    return starts_with(_bag_of(path)) is not None or (path / "metadata.yaml").is_file()


class RosRecording(StreamRecording):
    """The frames of one depth topic; `problems` name what is left aside.

    Raises:
        InputError: no bag, truncated, damaged, without depth images or their camera; or rosbags is
            not installed.
    """

    def __init__(self, path: Path) -> None:
        self._bag_path = _bag_of(path)
        problems: list[str] = []
        with naming(path), Bag(self._bag_path) as bag:
            choice = TopicChoice(bag, problems)
            self._metres_per_unit = choice.metres_per_unit()
            rig = choice.rig()
            self._depth, self._color = choice.depth.name, choice.color and choice.color.name
        super().__init__(path, rig, choice.depth.count)
        self.problems += problems

    def images(self) -> Iterator[StoredImage]:
        topics = [self._depth, *([self._color] if self._color else [])]
        with Bag(self._bag_path) as bag:
            for topic, time_s, message in bag.messages(topics):
                yield StoredImage(taken_s(message) or time_s, topic == self._color, message)

    def depth_m(self, data: Any) -> NDArray[np.float32]:
        return image_depth_m(data, self._metres_per_unit)

    def color(self, data: Any) -> NDArray[np.uint8]:
        return image_color(data)


def _bag_of(path: Path) -> Path:
    """The bag itself; of a folder without its description, the one bag in it."""
    if not path.is_dir() or (path / "metadata.yaml").exists():
        return path
    bags = [file for file in sorted(path.iterdir()) if file.suffix in BAG_SUFFIXES]
    return bags[0] if len(bags) == 1 else path
