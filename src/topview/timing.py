"""Where the time goes, stage by stage; read by `topview bench`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class StageClock:
    """Seconds per stage and frame.

    Attributes:
        seconds: for each stage, one sum per frame in which it ran.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, list[float]] = defaultdict(list)
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
        for name, seconds in self._frame.items():
            self.seconds[name].append(seconds)
        self._frame.clear()
