"""Tables and texts on a terminal, with names as they are."""

from __future__ import annotations

from rich.console import Console


def plain_console(*, stderr: bool = False) -> Console:
    """One to which brackets and colons of a recording's name mean nothing."""
    return Console(stderr=stderr, markup=False, emoji=False)
