"""Where the time goes, stage by stage; collected by `topview bench`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class StageClock:
    """Seconds that each stage took in the last frame; whoever wants more collects them.

    Attributes:
        seconds: of the stages that ran in it.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._frame: dict[str, float] = {}
        self._inner: list[float] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count what happens inside towards `name`, save for what inner stages count."""
        self._inner.append(0.0)
        start = perf_counter()
        try:
            yield
        finally:
            elapsed = perf_counter() - start
            own = elapsed - self._inner.pop()
            self._frame[name] = self._frame.get(name, 0.0) + own
            if self._inner:
                self._inner[-1] += elapsed

    def end_frame(self) -> None:
        """Close the frame's sums."""
        self.seconds, self._frame = self._frame, {}
