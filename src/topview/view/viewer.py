"""What a viewer is: it is shown each frame with its people while tracking runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from topview.records import Frame, Person


class Viewer(Protocol):
    """Anything that can be shown tracked frames."""

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Take note of one tracked frame; called once for each, in order."""
        ...


class NullViewer:
    """Looks away: for when no pictures are wanted."""

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Do nothing."""
