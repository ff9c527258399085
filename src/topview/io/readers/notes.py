"""What is told of a recording's frames that cannot be read: alike problems share a line."""

from __future__ import annotations

from typing import Final

MAX_LINES_ALIKE: Final = 5  # problems alike beyond these share one line; ours


class Notes:
    """Adds to a list of problems, each once however often the frames are read.

    Attributes:
        lines: that list.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._alike: dict[str, set[str]] = {}

    def add(self, line: str) -> None:
        """A problem of its own."""
        if line not in self.lines:
            self.lines.append(line)

    def add_alike(self, kind: str, line: str) -> None:
        """One of many; `kind` is what the rest is called, such as "frames cannot be read"."""
        alike = self._alike.setdefault(kind, set())
        if line in alike:
            return
        alike.add(line)
        more = len(alike) - MAX_LINES_ALIKE
        if more < 1:
            self.lines.append(line)
            return
        if more > 1:
            self.lines.remove(f"{more - 1} more {kind}")
        self.lines.append(f"{more} more {kind}")
