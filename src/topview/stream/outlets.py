"""Where frames are sent to, by the words of `--stream`."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Final, Protocol

from topview.records import InputError, shown
from topview.skeletons import TrackedFrame

MOST_QUEUED: Final = 2  # ours; frames that wait to be sent: older ones are of no use
ENDS_S: Final = 1.0  # ours; so long is waited for the last frame to be sent
MOST_PORT: Final = 65535
LOOPBACK: Final = "127.0.0.1"
KNOWN_WORDS: Final = "it must be osc:HOST:PORT, websocket:PORT or websocket:HOST:PORT"


class Outlet(Protocol):
    """Sends frames to other programs, and never waits for one.

    Attributes:
        problem: why nothing is sent any more, a line; empty while all is well.
    """

    problem: str

    def send(self, frame: TrackedFrame) -> None:
        """Give it the next frame."""
        ...

    def close(self) -> None:
        """Send what waits, if that takes no time, and end."""
        ...


class Background:
    """An outlet with a thread that sends; it keeps the newest frames.

    Args:
        deliver: sends one frame, and may take its time. Its errors of the system cost one frame,
            any other ends it.
        end: called when it is closed.

    Attributes:
        problem: as of `Outlet`.
    """

    def __init__(self, deliver: Callable[[TrackedFrame], None], end: Callable[[], None]) -> None:
        self.problem = ""
        self._end = end
        self._deliver = deliver
        self._waiting: deque[TrackedFrame] = deque(maxlen=MOST_QUEUED)
        self._changed = threading.Event()
        self._ends = False
        self._thread = threading.Thread(target=self._run, daemon=True, name="topview-stream")
        self._thread.start()

    def send(self, frame: TrackedFrame) -> None:
        self._waiting.append(frame)
        self._changed.set()

    def close(self) -> None:
        self._ends = True
        self._changed.set()
        self._thread.join(ENDS_S)

    def _run(self) -> None:
        try:
            while not self._ends or self._waiting:
                self._changed.wait()
                self._changed.clear()
                while self._waiting:
                    try:
                        self._deliver(self._waiting.popleft())
                    except OSError:  # nobody listens, a network that is down
                        continue
        except Exception as error:  # of ours; tracking goes on
            self.problem = f"{type(error).__name__}: {error}"
        finally:
            self._end()


def open_stream(words: str) -> Outlet:
    """An outlet.

    Args:
        words: "osc:HOST:PORT", "websocket:PORT" (this machine alone) or "websocket:HOST:PORT".

    Raises:
        InputError: other words, a library that is missing, a port that cannot be had.
    """
    kind, _, place = words.partition(":")
    host, _, port = place.rpartition(":")
    is_port = port.isdecimal() and 0 < int(port) <= MOST_PORT
    if not is_port or (kind, bool(host)) not in (
        ("osc", True), ("websocket", True), ("websocket", False),
    ):  # fmt: skip
        raise InputError(f"stream is {shown(words)}; {KNOWN_WORDS}")
    host = host.removeprefix("[").removesuffix("]")
    if kind == "osc":
        from topview.stream.osc import OscSender

        sender = OscSender(host, int(port))
        return Background(sender.deliver, sender.close)
    from topview.stream.websocket import WebSocketOutlet

    return WebSocketOutlet(host or LOOPBACK, int(port))
