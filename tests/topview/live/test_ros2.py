"""Cameras of ROS 2, against a stand-in for rclpy: no ROS was at hand. The messages are those of
rosbags, which have the fields of ROS's own."""

from __future__ import annotations

import array
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from topview.live import ros_graph
from topview.live.ros2 import METRES_PER_FLOAT_UNIT, Ros2Camera
from topview.records import InputError

tiny_bags = pytest.importorskip("tiny_bags", reason="needs rosbags")
DEPTH, INFO, COLOR = "/cam/depth/image_raw", "/cam/depth/camera_info", "/cam/rgb/image_raw"
HEIGHT, WIDTH = tiny_bags.HEIGHT, tiny_bags.WIDTH
SPIN_S = 0.5  # of the stand-in's clock


class Robot(tiny_bags.BagWriter):
    """Publishes; a spin takes half a second of its clock and gives one message at most."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "db3")
        self.messages: list[tuple[str, Any]] = []
        self.kinds: dict[str, str] = {"/chatter": "std_msgs/msg/String"}
        self.subscribed: dict[str, Any] = {}
        self.quality: dict[str, Any] = {}
        self.clock_s = 0.0
        self.is_shut = False

    def write(self, topic: str, message: Any, time_s: float = 0.0) -> None:
        if hasattr(message, "data"):  # rclpy's own type of byte sequences
            object.__setattr__(message, "data", array.array("B", message.data.tobytes()))
        self.kinds[topic] = message.__msgtype__
        self.messages.append((topic, message))

    def images(self, time_s: float, depth: np.ndarray, encoding: str = "16UC1") -> None:
        self.image(DEPTH, depth, encoding, time_s, "depth")
        color = np.full((HEIGHT, WIDTH, 3), int(10 * time_s), np.uint8)
        self.image(COLOR, color, "rgb8", time_s + 0.01, "rgb")

    # As rclpy's node and executor.

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(topic, [kind]) for topic, kind in self.kinds.items()]

    def create_subscription(self, kind: Any, topic: str, take: Any, quality: Any) -> str:
        assert kind.__msgtype__ == self.kinds[topic]
        self.subscribed[topic], self.quality[topic] = take, quality
        return topic

    def destroy_subscription(self, topic: str) -> None:
        del self.subscribed[topic]

    def spin_once(self, timeout_sec: float) -> None:
        self.clock_s += SPIN_S
        for n, (topic, message) in enumerate(self.messages):
            if topic in self.subscribed:
                del self.messages[n]
                self.subscribed[topic](message)
                return

    def shut(self) -> None:
        self.is_shut = True


@pytest.fixture
def robot(tmp_path, monkeypatch) -> Robot:
    made = Robot(tmp_path)
    context = SimpleNamespace(init=lambda args: None, try_shutdown=made.shut)
    executor = SimpleNamespace(
        add_node=lambda node: None, spin_once=made.spin_once, shutdown=lambda: None
    )
    made.destroy_node = lambda: None
    qos = SimpleNamespace(
        QoSProfile=SimpleNamespace,
        ReliabilityPolicy=SimpleNamespace(RELIABLE="reliable", BEST_EFFORT="best effort"),
        DurabilityPolicy=SimpleNamespace(TRANSIENT_LOCAL="transient local"),
    )
    modules: dict[str, Any] = {
        "rclpy": ModuleType("rclpy"),
        "rclpy.context": SimpleNamespace(Context=lambda: context),
        "rclpy.executors": SimpleNamespace(SingleThreadedExecutor=lambda context: executor),
        "rclpy.node": SimpleNamespace(Node=lambda name, context: made),
        "rclpy.qos": qos,
    }
    for package in ("sensor_msgs", "tf2_msgs"):
        kinds = [name for name in made._store.types if name.startswith(f"{package}/msg/")]
        module = SimpleNamespace(**{k.rsplit("/")[-1]: made._store.types[k] for k in kinds})
        modules |= {package: ModuleType(package), f"{package}.msg": module}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(ros_graph, "monotonic", lambda: made.clock_s)
    return made


def told(robot: Robot, frame: str = "rgb") -> None:
    """Cameras, and where the colour's is."""
    robot.info(INFO, "depth")
    robot.info("/cam/rgb/camera_info", frame, K=np.array([40.0, 0, 16, 0, 40, 12, 0, 0, 1]))
    robot.static("depth", "rgb", 0.05)


def test_what_the_topics_say_and_give(robot):
    told(robot)
    depth = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH)
    for n in range(2):  # while it listens: six spins, with what the cameras say
        robot.image(DEPTH, depth, "16UC1", 1.0 + 0.1 * n, "depth")
    robot.image(COLOR, np.zeros((HEIGHT, WIDTH, 3), np.uint8), "rgb8", 1.0, "rgb")
    camera = Ros2Camera()
    assert robot.messages == []
    assert camera.camera.fx == tiny_bags.K[0]
    assert camera.color is not None
    assert camera.color.camera.fx == 40.0
    np.testing.assert_allclose(camera.color.T_color_depth[:3, 3], [-0.05, 0, 0])
    assert camera.fps == pytest.approx(10.0)
    assert camera.metres_per_unit == 0.001
    assert robot.quality["/tf_static"].durability == "transient local"
    assert {*robot.subscribed} == {DEPTH, COLOR}
    robot.image(DEPTH, depth, "16UC1", 1.9, "depth")  # its colour was lost
    robot.images(2.0, depth + 1)
    frame = camera.read()
    assert frame is not None
    assert frame.timestamp_s == pytest.approx(2.0)
    np.testing.assert_array_equal(frame.depth, depth + 1)
    assert frame.color is not None
    assert np.unique(frame.color) == [20]
    with pytest.raises(InputError, match="ros2:: no depth image for 5 s"):
        camera.read()
    camera.close()
    assert robot.is_shut
    assert camera.read() is None


def test_depth_in_metres_is_rounded_as_a_recording_keeps_it(robot):
    robot.info(INFO, "depth")
    depth_m = np.linspace(0.5, 9.0, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    depth_m[0, :3] = np.nan, np.inf, 20.0
    for n in range(2):
        robot.image(DEPTH, depth_m, "32FC1", 1.0 + n, "depth")
    camera = Ros2Camera()
    assert camera.problems == ["has no colour images"]
    robot.image(DEPTH, depth_m, "32FC1", 3.0, "depth")
    frame = camera.read()
    assert frame is not None
    assert (frame.depth[0, :3] == 0).all()
    np.testing.assert_allclose(
        frame.depth[1:] * camera.metres_per_unit, depth_m[1:], atol=0.51 * METRES_PER_FLOAT_UNIT
    )


def test_topics_that_are_named_are_read_and_no_others(robot):
    told(robot)
    other, other_info = "/other/depth/image_registered", "/other/camera_info"
    robot.info(other_info, "depth", K=np.array([50.0, 0, 16, 0, 50, 12, 0, 0, 1]))
    image = np.full((HEIGHT, WIDTH), 900, np.uint16)
    for topic in (DEPTH, other):
        robot.image(topic, image, "16UC1", 1.0, "depth")
    camera = Ros2Camera(f"{DEPTH},{other_info}")
    assert camera.camera.fx == 50.0
    assert {*robot.subscribed} == {DEPTH}


def test_a_camera_info_of_another_size_is_told(robot):
    robot.info(INFO, "depth", width=2 * WIDTH)
    robot.image(DEPTH, np.full((HEIGHT, WIDTH), 900, np.uint16), "16UC1", 1.0, "depth")
    with pytest.raises(InputError, match=f"{INFO} is no sensor_msgs/CameraInfo of 32 x 24 pixels"):
        Ros2Camera(f"{DEPTH},{INFO}")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "ros2:: has no topic of depth images; it holds /cam"),
        ("/nowhere", "ros2:/nowhere: nothing came on /nowhere in 3 s; it came on /cam/depth"),
        ("a,b,c,d", "names 4 topics; it must be DEPTH,INFO,COLOR"),
    ],
)
def test_what_cannot_be_used_is_told(robot, words, said):
    robot.info(INFO, "depth")
    with pytest.raises(InputError, match=said):
        Ros2Camera(words)
    assert robot.is_shut == (words[:1] != "a")


def test_without_ros_one_line_says_what_is_needed(monkeypatch):
    monkeypatch.setitem(sys.modules, "rclpy.context", None)
    with pytest.raises(InputError, match="ros2: needs ROS 2, whose rclpy cannot be loaded"):
        Ros2Camera()
