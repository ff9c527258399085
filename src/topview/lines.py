"""What is said, as one line."""

from __future__ import annotations

from typing import Final

MOST_CHARACTERS: Final = 2000
"""Of a line; of a longer one the middle is left out (ours)."""


def as_line(text: str) -> str:
    """Any text as one line that a terminal can show: control characters are escaped."""
    line = " ".join(text.split())
    if len(line) > MOST_CHARACTERS:
        half = MOST_CHARACTERS // 2
        line = f"{line[:half]} ... {line[-half:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)
