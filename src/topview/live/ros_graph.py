"""What comes on the topics of ROS 2, by rclpy, which comes with ROS."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Collection, Iterator
from importlib import import_module
from time import monotonic
from typing import Any, Final

from topview.io.readers.gravity import MOST_SAMPLES
from topview.io.readers.ros_messages import TRANSFORMS_TYPE, Topic, taken_s
from topview.io.readers.ros_topics import IMAGE_TYPES, IMU_TYPE, INFO_TYPE
from topview.records import InputError

SPINS_S: Final = 0.1  # ours; so soon is seen that the camera was closed
LISTENED_TYPES: Final = (*IMAGE_TYPES, INFO_TYPE, IMU_TYPE, TRANSFORMS_TYPE)
STATIC_TRANSFORMS: Final = "/tf_static"
MOST_WAITING_MESSAGES: Final = 2  # ours; of each topic, the oldest is dropped first


class RosGraph:
    """A node of ROS 2 that listens.

    Raises:
        InputError: rclpy is missing.
    """

    def __init__(self) -> None:
        try:
            context, executors = (
                import_module(f"rclpy.{name}") for name in ("context", "executors")
            )
            self._qos, node = import_module("rclpy.qos"), import_module("rclpy.node")
        except ImportError as error:
            raise InputError(
                f"ros2: needs ROS 2, whose rclpy cannot be loaded ({error}); source the setup.bash "
                "of a ROS that has the Python of topview"
            ) from None
        self._context = context.Context()  # of our own: ROS then leaves signals alone
        self._context.init(args=[])
        self._node = node.Node("topview", context=self._context)
        self._executor = executors.SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._spins = threading.Lock()
        self._subscriptions: list[Any] = []
        self.is_open = True

    def types(self) -> dict[str, str]:
        """What kind of message comes on each topic that is there now."""
        told = self._node.get_topic_names_and_types()
        return {name: types[0] for name, types in told if types}

    def subscribe(self, topic: str, message_type: str, take: Callable[[Any], None]) -> None:
        """Have each message of a topic taken while it spins."""
        package, _, name = message_type.partition("/msg/")
        try:
            kind = getattr(import_module(f"{package}.msg"), name)
        except ImportError:
            return  # this ROS has no such messages
        self._subscriptions.append(
            self._node.create_subscription(kind, topic, take, self._quality(topic))
        )

    def _quality(self, topic: str) -> Any:
        """What is asked of the transport: images as they come, what is static whenever it was."""
        qos = self._qos
        if topic == STATIC_TRANSFORMS:
            return qos.QoSProfile(
                depth=100,
                durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
                reliability=qos.ReliabilityPolicy.RELIABLE,
            )
        return qos.QoSProfile(
            depth=MOST_WAITING_MESSAGES, reliability=qos.ReliabilityPolicy.BEST_EFFORT
        )

    def forget(self) -> None:
        """End all subscriptions."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())

    def spin(self) -> None:
        """Take a message, or wait for it for a moment."""
        with self._spins:
            if self.is_open:
                self._executor.spin_once(timeout_sec=SPINS_S)

    def close(self) -> None:
        """Leave the graph; `spin` in another thread ends before."""
        if not self.is_open:
            return
        self.is_open = False
        with self._spins:
            self._executor.shutdown()
            self._node.destroy_node()
            self._context.try_shutdown()


class Heard:
    """What came while a graph was listened to, as `topview.io.readers.ros_messages.Messages`.

    Args:
        graph: is listened to.
        seconds: for so long.
    """

    def __init__(self, graph: RosGraph, seconds: float) -> None:
        self._types: dict[str, str] = {}
        self._came: dict[str, list[Any]] = {}
        self._times_s: dict[str, list[float]] = {}
        end_s = monotonic() + seconds
        while monotonic() < end_s:
            for topic, kind in graph.types().items():
                if topic not in self._types and kind in LISTENED_TYPES:
                    self._types[topic] = kind
                    graph.subscribe(topic, kind, lambda message, at=topic: self._take(at, message))
            graph.spin()
        graph.forget()

    def _take(self, topic: str, message: Any) -> None:
        kept, kind = self._came.setdefault(topic, []), self._types[topic]
        if not kept or (kind in (IMU_TYPE, TRANSFORMS_TYPE) and len(kept) < MOST_SAMPLES):
            kept.append(message)
        if kind in IMAGE_TYPES:
            self._times_s.setdefault(topic, []).append(taken_s(message))

    @property
    def topics(self) -> dict[str, Topic]:
        return {
            name: Topic(name, kind, len(self._came.get(name, ())))
            for name, kind in self._types.items()
        }

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, float, Any]]:
        for topic in topics:
            for message in self._came.get(topic, ()):
                yield topic, 0.0, message

    def first(self, topic: str) -> Any | None:
        return next(iter(self._came.get(topic, ())), None)

    def leave_out(self, topics: Collection[str]) -> None:
        """As if they were not there."""
        for topic in topics:
            del self._types[topic]

    def times_s(self, topic: str) -> list[float]:
        """When each image that came was taken."""
        return self._times_s.get(topic, [])


class Newest:
    """The newest messages of a topic, while a graph spins."""

    def __init__(self, graph: RosGraph, topic: str, message_type: str) -> None:
        self._waiting: deque[Any] = deque(maxlen=MOST_WAITING_MESSAGES)
        self._graph = graph
        graph.subscribe(topic, message_type, self._waiting.append)

    def next(self, seconds: float) -> Any | None:
        """Wait for a message; None if none comes for so long, or the graph is closed."""
        end_s = monotonic() + seconds
        while not self._waiting and self._graph.is_open and monotonic() < end_s:
            self._graph.spin()
        return self._waiting.popleft() if self._waiting and self._graph.is_open else None
