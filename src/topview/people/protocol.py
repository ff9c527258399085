"""What a tracker wants of whoever finds the people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from topview.camera.pyramid import Pyramid
from topview.detect.faces_and_hands import SkinDetections
from topview.people.told import NOTHING_TOLD, Told
from topview.people.users import HandCandidate, User
from topview.room.floor import FloorPlane
from topview.timing import StageClock


class Finder(Protocol):
    """Finds people in one frame after the other, segments them, and knows them again."""

    @property
    def clock(self) -> StageClock:
        """Seconds spent in each stage of each frame."""
        ...

    @property
    def floor(self) -> FloorPlane | None:
        """The floor as far as it is known."""
        ...

    @property
    def skin_detections(self) -> SkinDetections | None:
        """The skin detections of the last frame; None if colour is not used."""
        ...

    @property
    def hands(self) -> tuple[HandCandidate, ...]:
        """The hands that the last frame's colours show, whosesoever they are."""
        ...

    @property
    def doubtful(self) -> Sequence[User]:
        """Who may be people, with ids below 0: of the first the finder wants to know whether it
        is."""
        ...

    @property
    def found(self) -> Any:
        """All that is known of the last frame, for pictures of it."""
        ...

    def update(self, image: Pyramid, told: Told = NOTHING_TOLD) -> list[User]:
        """The people in the next frame; `told` is what is known of the last one."""
        ...
