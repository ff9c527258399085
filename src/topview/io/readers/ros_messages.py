"""Messages of ROS bags, of ROS 1 and of ROS 2 (SQLite, MCAP), by the library rosbags.

https://ternaris.gitlab.io/rosbags. Standard messages are read by their standard definitions, so
that those of a bag's own, however odd, do no harm.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, Protocol, Self

from topview.files import unharmed
from topview.records import InputError

ROS1_SIGNATURE: Final = b"#ROSBAG V"
BAG_SIGNATURES: Final = (ROS1_SIGNATURE, b"SQLite format 3\0", b"\x89MCAP0\r\n")
BAG_SUFFIXES: Final = (".db3", ".mcap")  # of ROS 2, by which rosbags tells them apart
TRANSFORMS_TYPE: Final = "tf2_msgs/msg/TFMessage"
TRANSFORMS: Final = "geometry_msgs/TransformStamped[] transforms"  # not among rosbags' of ROS 1
TRAILING_BYTES: Final = 4
"""That librealsense leaves after some messages."""
_RIGHT: Final = (
    "it must be a whole bag of ROS 1 or 2; `rosbag reindex` or `mcap recover` may mend it"
)


@dataclass(frozen=True, slots=True)
class Topic:
    """What one topic of a bag holds: the type of its messages, and how many."""

    name: str
    message_type: str
    count: int


class Messages(Protocol):
    """What can be asked about ROS messages, whether they lie in a bag or came just now."""

    @property
    def topics(self) -> Mapping[str, Topic]:
        """By name."""
        ...

    def messages(self, topics: Collection[str], /) -> Iterator[tuple[str, float, Any]]:
        """Name of the topic, seconds at which it came, and message, of some topics."""
        ...

    def first(self, topic: str, /) -> Any | None:
        """The first message of a topic; None where there is none."""
        ...


class Bag:
    """A bag, as `Messages`, open while it is entered. Errors do not name the file.

    Raises:
        InputError: rosbags is not installed; from everything: no bag, truncated or damaged.
    """

    def __init__(self, path: Path) -> None:
        self._is_ros1 = starts_with(path) == ROS1_SIGNATURE
        try:
            from rosbags import rosbag1, rosbag2
        except ImportError:
            raise InputError(
                "ROS bags need rosbags; install it with: pip install 'topview[ros]'"
            ) from None
        self._store = standard_types(self._is_ros1)
        with unharmed(_RIGHT):
            self._reader: Any = (rosbag1.Reader if self._is_ros1 else rosbag2.Reader)(path)

    def __enter__(self) -> Self:
        with unharmed(_RIGHT):
            self._reader.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    @property
    def topics(self) -> dict[str, Topic]:
        """By name."""
        with unharmed(_RIGHT):
            return {
                name: Topic(name, str(info.msgtype), info.msgcount)
                for name, info in self._reader.topics.items()
            }

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, float, Any]]:
        """Name of the topic, seconds at which it was recorded, and message, of some topics."""
        wanted = [c for c in self._reader.connections if c.topic in topics]
        if not wanted:
            return
        with unharmed(_RIGHT):
            for connection, time_ns, data in self._reader.messages(wanted):
                yield connection.topic, time_ns / 1e9, self._decoded(data, connection.msgtype)

    def first(self, topic: str) -> Any | None:
        """The first message of a topic; None where there is none."""
        return next((message for _, _, message in self.messages([topic])), None)

    def _decoded(self, data: Any, message_type: str) -> Any:
        if not self._is_ros1:
            return self._store.deserialize_cdr(data, message_type)
        from rosbags.serde import SerdeError

        try:
            return self._store.deserialize_ros1(data, message_type)
        except SerdeError:
            return self._store.deserialize_ros1(data[:-TRAILING_BYTES], message_type)


def taken_s(message: Any) -> float:
    """Seconds at which an image was taken, by its header."""
    return message.header.stamp.sec + message.header.stamp.nanosec / 1e9


@cache
def standard_types(is_ros1: bool) -> Any:
    """The definitions of standard messages; made once, as that takes longer than to read a few."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.LATEST)
    store.register(get_types_from_msg(TRANSFORMS, TRANSFORMS_TYPE))
    return store


def starts_with(path: Path) -> bytes | None:
    """The signature of a bag that a file begins with."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        beginning = file.read(max(map(len, BAG_SIGNATURES)))
    return next((s for s in BAG_SIGNATURES if beginning.startswith(s)), None)
