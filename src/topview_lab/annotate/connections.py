"""A server whose threads are few, however many connect and whatever they then fail to send."""

from __future__ import annotations

import contextlib
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import ThreadingHTTPServer
from time import monotonic
from typing import Any, Final

MOST_CONNECTIONS: Final = 32
"""At a time, each with a thread; a browser opens six (ours)."""
PATIENCE_S: Final = 10.0
"""For a whole request to come, and for its answer to be taken (ours)."""
LOOK_AGAIN_S: Final = 0.1
"""While every connection is taken (ours)."""


class BoundedServer(ThreadingHTTPServer):
    """Answers `MOST_CONNECTIONS` at a time. A connection on which no whole request comes within
    `patience_s` is closed; where too many connect, so is the one that has waited longest."""

    daemon_threads = True
    request_queue_size = 512

    def __init__(self, *args: Any) -> None:
        self.patience_s = PATIENCE_S
        self._waiting_since_s: dict[socket.socket, float] = {}  # the longest first
        self._lock = threading.Lock()
        self._free = threading.BoundedSemaphore(MOST_CONNECTIONS)
        super().__init__(*args)

    @contextmanager
    def at_work(self, connection: socket.socket) -> Iterator[None]:
        """While its request is worked on, a connection is not closed.

        Raises:
            ConnectionAbortedError: it was closed before.
        """
        with self._lock:
            if self._waiting_since_s.pop(connection, None) is None:
                raise ConnectionAbortedError
        try:
            yield
        finally:
            self._wait_for(connection)

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._free.acquire(blocking=False):
            self._close_longest()
            while not self._free.acquire(timeout=LOOK_AGAIN_S):
                self._close_longest()
        self._wait_for(request)
        try:
            super().process_request(request, client_address)
        except BaseException:  # no thread was to be had
            self._forget(request)
            raise

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._forget(request)

    def service_actions(self) -> None:
        """Called between connections, and every half second."""
        late_s = monotonic() - self.patience_s
        with self._lock:
            for connection, since_s in self._waiting_since_s.items():
                if since_s < late_s:
                    _close(connection)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """One line; nothing where the other side is gone."""
        error = sys.exception()
        if not isinstance(error, ConnectionError | TimeoutError):
            print(f"topview: annotate: {type(error).__name__}: {error}", file=sys.stderr)

    def _wait_for(self, connection: socket.socket) -> None:
        with self._lock:
            self._waiting_since_s[connection] = monotonic()

    def _forget(self, connection: socket.socket) -> None:
        with self._lock:
            self._waiting_since_s.pop(connection, None)
        self._free.release()

    def _close_longest(self) -> None:
        with self._lock:
            if longest := next(iter(self._waiting_since_s), None):
                del self._waiting_since_s[longest]
                _close(longest)


def _close(connection: socket.socket) -> None:
    """Its thread reads the end, and ends."""
    with contextlib.suppress(OSError):  # the other side was quicker
        connection.shutdown(socket.SHUT_RDWR)
