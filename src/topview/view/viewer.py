"""The protocol of viewers, which are shown each frame with its people while tracking runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import BinaryIO, Protocol

from topview.records import Frame, Person


class Viewer(Protocol):
    """Anything that can be shown tracked frames."""

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Show one tracked frame; called once for each, in order."""
        ...


class Viewers:
    """Shows each frame to several viewers, or to none."""

    def __init__(self, viewers: Iterable[Viewer] = ()) -> None:
        self._viewers = tuple(viewers)

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Pass the frame on."""
        for viewer in self._viewers:
            viewer.show(frame, people)


class Sheet(Viewer, Protocol):
    """A viewer that makes one picture, or one video, of a whole recording."""

    @property
    def is_blank(self) -> bool:
        """True while no frame was kept."""
        ...

    def write(self, file: BinaryIO) -> None:
        """Write it, once and at the end; InputError where it is blank."""
        ...
