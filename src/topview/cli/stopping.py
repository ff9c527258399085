"""An orderly end: Ctrl-C, `kill`, a closed terminal and a batch system's time limit alike."""

from __future__ import annotations

import os
import signal
import threading
from time import monotonic
from types import FrameType
from typing import Any, Final, Self

SIGNALS: Final = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
INSISTENT: Final = 3  # this signal ends what is being written, too; ours
INSISTENT_AFTER_S: Final = 2.0  # if it comes so long after the first; ours


class Stopped(KeyboardInterrupt):
    """A signal asks the run to end; raised wherever it is, once."""


class OrderlyEnd:
    """While it is entered, the first signal raises `Stopped` in the main thread. A second one
    changes nothing, so that what was computed is written; a third, later, raises again.

    Signals that were ignored when it was entered (`nohup`, a shell's background) stay ignored.

    Attributes:
        signal: the first that came; None if none did.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        self._first_s = 0.0
        self._count = 0
        self._before: dict[int, Any] = {}
        self._process = 0

    @property
    def status(self) -> int:
        """The exit status that shells give a signal."""
        return 128 + (self.signal or signal.SIGINT)

    def __enter__(self) -> Self:
        self._process = os.getpid()
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                if (before := signal.getsignal(number)) not in (signal.SIG_IGN, None):
                    self._before[number] = before
                    signal.signal(number, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        if os.getpid() != self._process:  # a child that was forked; its parent writes
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
            return
        self._count += 1
        if self._count == 1:
            self.signal, self._first_s = number, monotonic()
            raise Stopped
        if self._count >= INSISTENT and monotonic() - self._first_s > INSISTENT_AFTER_S:
            raise Stopped
