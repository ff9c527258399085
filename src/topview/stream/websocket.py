"""JSON over WebSocket, and a page that draws it: the newest frame to whoever listens.

Each listener is sent a frame when it has taken the one before, so that a slow one misses some and
nothing piles up. A message is a line of the `.jsonl` format. Browsers may connect only from the
page that is served here, other programs as they like.
"""

from __future__ import annotations

import asyncio
import logging
import re
import threading
from base64 import b64encode
from hashlib import sha256
from http import HTTPStatus
from importlib.resources import files
from typing import Any, Final

import msgspec

from topview.body import OUTPUT_JOINT_NAMES, OUTPUT_JOINTS, PART_NAMES
from topview.io.writers.extras import needed
from topview.io.writers.jsonl import frame_as_json
from topview.lines import as_line
from topview.records import InputError
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.stream.outlets import ENDS_S, LOOPBACK

CLOSES_S: Final = 0.2  # ours; so long a listener may take to say goodbye
MOST_BUFFERED_BYTES: Final = 2**16  # ours; of a listener that does not read
_LOGGER: Final = logging.getLogger(__name__)
_ABOUT: Final = About(OUTPUT_JOINT_NAMES, PART_NAMES)


class WebSocketOutlet:
    """Serves until it is closed; `http://HOST:PORT/` is the page.

    Attributes:
        problem: as of `topview.stream.Outlet`.

    Raises:
        InputError: websockets is missing, or the port cannot be had.
    """

    def __init__(self, host: str, port: int) -> None:
        needed("websockets", "--stream websocket", "stream")
        self.problem = ""
        self._host, self._port = host, port
        self._newest: TrackedFrame | None = None
        self._encoded: tuple[TrackedFrame, str] | None = None
        self._loop = asyncio.new_event_loop()
        self._came, self._ends = asyncio.Event(), asyncio.Event()
        self._started = threading.Event()
        self._refused: OSError | None = None
        self._thread = threading.Thread(target=self._run, daemon=True, name="topview-websocket")
        self._thread.start()
        self._started.wait()
        if self._refused is not None:
            raise InputError(
                f"stream websocket:{host}:{port}: cannot be had: "
                f"{as_line(self._refused.strerror or str(self._refused))}; it must be a free port"
            )

    def send(self, frame: TrackedFrame) -> None:
        """As of `topview.stream.Outlet`."""
        self._newest = frame
        self._call(self._tell)

    def close(self) -> None:
        """As of `topview.stream.Outlet`."""
        self._call(self._ends.set)
        self._thread.join(ENDS_S + CLOSES_S)

    def _call(self, function: Any) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function)

    def _run(self) -> None:
        try:
            with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
                runner.run(self._serve())
        except OSError as error:
            self._refused = error
        except Exception as error:  # of ours; tracking goes on
            self.problem = f"{type(error).__name__}: {error}"
        finally:
            self._started.set()

    async def _serve(self) -> None:
        from websockets.asyncio.server import serve

        async with serve(
            self._listen,
            self._host,
            self._port,
            process_request=self._admit,
            close_timeout=CLOSES_S,
            write_limit=MOST_BUFFERED_BYTES,
            compression=None,
            logger=_LOGGER,
            max_size=MOST_BUFFERED_BYTES,
        ):
            self._started.set()
            await self._ends.wait()

    def _tell(self) -> None:
        came, self._came = self._came, asyncio.Event()
        came.set()

    async def _listen(self, listener: Any) -> None:
        """Send each frame that is new when the one before has been taken."""
        from websockets.exceptions import ConnectionClosed

        sent = None
        try:
            while True:
                came = self._came
                frame = self._newest
                if frame is None or frame is sent:
                    await came.wait()
                    continue
                await listener.send(self._text_of(frame))
                sent = frame
        except ConnectionClosed:
            return

    def _text_of(self, frame: TrackedFrame) -> str:
        """Its message, made once for all listeners."""
        if self._encoded is None or self._encoded[0] is not frame:
            block = SkeletonSequence.from_frames([frame], _ABOUT)
            text = msgspec.json.encode(frame_as_json(block, 0)).decode()
            self._encoded = (frame, text)
        return self._encoded[1]

    def _admit(self, connection: Any, request: Any) -> Any:
        """None for a listener; an answer for a browser that asks for the page, and for one whose
        page is not from here."""
        host = request.headers.get("Host", "")
        is_local_name = host.rpartition(":")[0] in (LOOPBACK, "localhost", "[::1]")
        if self._host == LOOPBACK and not is_local_name:  # a name that was pointed at this machine
            return connection.respond(HTTPStatus.FORBIDDEN, f"the host must be {LOOPBACK}\n")
        if request.headers.get("Origin", f"http://{host}") != f"http://{host}":
            return connection.respond(HTTPStatus.FORBIDDEN, "the page must be from here\n")
        if "Upgrade" in request.headers:
            return None
        if request.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "there is only /\n")
        page, policy = _page()
        answer = connection.respond(HTTPStatus.OK, page)
        del answer.headers["Content-Type"]
        answer.headers["Content-Type"] = "text/html; charset=utf-8"
        answer.headers["Content-Security-Policy"] = policy
        return answer


def _page() -> tuple[str, str]:
    """The page, and what it may do: run its own script, connect to here."""
    page = files("topview.stream").joinpath("page.html").read_text("utf-8")
    bones = [[joint.bone_to, j] for j, joint in enumerate(OUTPUT_JOINTS) if joint.bone_to >= 0]
    about = msgspec.json.encode({"joints": OUTPUT_JOINT_NAMES, "bones": bones}).decode()
    page = page.replace("__ABOUT__", about)
    (script,) = re.findall("<script>(.*?)</script>", page, re.DOTALL)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "connect-src 'self'; base-uri 'none'; frame-ancestors 'none'"
    )
    return page, policy
