"""Cameras that publish to ROS 2: images on topics, by the rclpy of a ROS that is installed.

Topics and cameras are chosen as in a ROS bag. Written after rclpy's documents and tested against a
stand-in for it: no ROS was at hand.
"""

from __future__ import annotations

from pathlib import Path
from time import time
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io.readers.pairing import StoredImage
from topview.io.readers.ros_images import image_color, image_depth_m, is_color, is_depth, is_float
from topview.io.readers.ros_messages import taken_s
from topview.io.readers.ros_topics import IMAGE_TYPES, TopicChoice
from topview.live.camera import RawFrame
from topview.live.ros_graph import Heard, Newest, RosGraph
from topview.live.sdk import WAITS_S, gone, next_pair
from topview.records import InputError

LISTENS_S: Final = 3.0  # ours; topics are found within a second or two
FPS: Final = 30.0  # ours; where too few images came to tell
METRES_PER_FLOAT_UNIT: Final = 0.00025  # ours; depth in floats is rounded to this, up to 16 m
FARTHEST_UNIT: Final = np.iinfo(np.uint16).max


class Ros2Camera:
    """As `topview.live.DepthCamera`.

    Args:
        words: topics "DEPTH", "DEPTH,INFO" or "DEPTH,INFO,COLOR"; those that are missing, or
            empty, are found.

    Raises:
        InputError: rclpy is missing, no depth images come, or their camera is not told.

    Attributes:
        problems: what is left aside, lines for people.
    """

    def __init__(self, words: str = "") -> None:
        named = [word.strip() for word in words.split(",")]
        if len(named) > 3:
            raise InputError(f"ros2:{words} names {len(named)} topics; it must be DEPTH,INFO,COLOR")
        self.name = f"ros2:{words}"
        self.problems: list[str] = []
        self._graph = RosGraph()
        try:
            with naming(Path(self.name)):
                self._choose(*named, *[""] * (3 - len(named)))
        except BaseException:
            self._graph.close()
            raise

    def _choose(self, depth: str, info: str, color: str) -> None:
        heard = Heard(self._graph, LISTENS_S)
        for topic in filter(None, (depth, info, color)):
            if heard.first(topic) is None:
                came = ", ".join(sorted(filter(heard.first, heard.topics))) or "nothing"
                raise InputError(f"nothing came on {topic} in {LISTENS_S:g} s; it came on {came}")
        heard.leave_out([name for name in heard.topics if _is_other(heard, name, depth, color)])
        choice = TopicChoice(heard, self.problems, info or None)
        rig = choice.rig()
        self.camera, self.color = rig.camera, rig.color_camera
        is_float_depth = is_float(choice.first_depth)
        self.metres_per_unit = METRES_PER_FLOAT_UNIT if is_float_depth else choice.metres_per_unit()
        steps_s = np.diff(heard.times_s(choice.depth.name))
        steps_s = steps_s[steps_s > 0.0]
        self.fps = float(1.0 / np.median(steps_s)) if len(steps_s) else FPS
        topics = [choice.depth, *([choice.color] if choice.color else [])]
        self._newest = [Newest(self._graph, topic.name, topic.message_type) for topic in topics]

    def read(self) -> RawFrame | None:
        """As of `topview.live.DepthCamera`."""
        pair = next_pair(self._next, len(self._newest) > 1, self.fps)
        if pair is None:
            return None
        depth, color = pair
        pixels = None if color is None else image_color(color.data)
        return RawFrame(depth.time_s, self._values(depth.data), pixels)

    def close(self) -> None:
        """As of `topview.live.DepthCamera`."""
        self._graph.close()

    def _next(self, is_color: bool) -> StoredImage | None:
        message = self._newest[is_color].next(WAITS_S)
        if message is not None:
            return StoredImage(taken_s(message) or time(), is_color, message)
        if self._graph.is_open:
            raise gone(self.name, "colour image" if is_color else "depth image")
        return None

    def _values(self, message: Any) -> NDArray[np.uint16]:
        """Depth in units of `metres_per_unit`, whatever it came in."""
        values = np.rint(image_depth_m(message, self.metres_per_unit) / self.metres_per_unit)
        return np.where(values <= FARTHEST_UNIT, values, 0).astype(np.uint16)


def _is_other(heard: Heard, topic: str, depth: str, color: str) -> bool:
    """Whether images of a topic are left aside because others are named."""
    if heard.topics[topic].message_type not in IMAGE_TYPES:
        return False
    first = heard.first(topic)
    if first is None:
        return True
    return bool(
        (depth and is_depth(first) and topic != depth)
        or (color and is_color(first) and topic != color)
    )
