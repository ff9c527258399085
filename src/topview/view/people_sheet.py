"""One picture of how people were found in a recording: some moments, each a row of panels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import BinaryIO, Final

import numpy as np

from topview.people.output import Found
from topview.records import Frame, InputError, Person
from topview.view.drawing import Image, draw_text, png_of
from topview.view.even_choice import EvenChoice
from topview.view.found_panels import GAP_PX, paint_found, row_px
from topview.view.palette import GROUND, MUTED, TEXT

# The look of the sheet: all ours.
EVEN_MOMENTS: Final = 5
CHANGED_MOMENTS: Final = 5  # at most: when somebody comes or goes
PANELS: Final = 6  # in a row: one moment with colours, two without
MOST_ROWS: Final = 6
FOUND_HEADER_PX: Final = 48


class PeopleSheet:
    """A viewer that keeps pictures of how people were found, and joins them when it is painted.

    Args:
        title: the recording's name.
        frame_count: how many frames the recording should have; None if nobody knows.
        found: gives what was found in the frame that is shown.
    """

    def __init__(
        self, title: str, frame_count: int | None, found: Callable[[], Found | None]
    ) -> None:
        self.title = title
        self._found = found
        self._even: EvenChoice[tuple[int, Image]] = EvenChoice(EVEN_MOMENTS, frame_count)
        self._changes: list[tuple[int, Image]] = []
        self._ids: set[int] = set()
        self._shown = 0

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Keep a picture if the frame's turn has come, or if somebody has come or gone."""
        found = self._found()
        if found is None:
            return
        ids = {user.id for user in found.users}
        has_changed = self._shown > 0 and ids != self._ids and len(self._changes) < CHANGED_MOMENTS
        if self._even.next_is_due():
            self._even.keep((self._shown, paint_found(found)))
        elif has_changed:
            self._changes.append((self._shown, paint_found(found)))
        self._ids = ids
        self._shown += 1

    @property
    def tiles(self) -> list[Image]:
        """The pictures, in the order of the recording."""
        kept = sorted([*self._even.kept, *self._changes], key=lambda shown: shown[0])
        return [picture for _, picture in kept]

    @property
    def is_blank(self) -> bool:
        return not self.tiles

    def paint(self) -> Image:
        """The sheet as [H, W, 3] RGB: up to 36 panels in rows of six. Of more pictures the first,
        the last and those evenly between are shown.

        Raises:
            InputError: no frame was shown.
        """
        tiles = self.tiles
        if not tiles:
            raise InputError(f"{self.title}: no frame was read, so there is nothing to picture")
        per_row = 1 if any(tile.shape[1] == row_px(PANELS) for tile in tiles) else 2
        shown = np.linspace(0, len(tiles) - 1, min(len(tiles), per_row * MOST_ROWS)).round()
        chosen = [tiles[int(number)] for number in shown]
        header = np.full((FOUND_HEADER_PX, row_px(PANELS), 3), GROUND, np.uint8)
        used = draw_text(header, self.title, (14, 30), 14, TEXT)
        draw_text(header, "how people were found", (14 + used + 16, 30), 10, MUTED)
        rows = [_row(chosen[k : k + per_row]) for k in range(0, len(chosen), per_row)]
        return np.vstack([header, *rows])

    def png(self) -> bytes:
        """The sheet as a PNG file.

        Raises:
            InputError: no frame was shown.
        """
        return png_of(self.paint())

    def write(self, file: BinaryIO) -> None:
        """Write the PNG file. Errors as of `png`."""
        file.write(self.png())


def _row(tiles: Sequence[Image]) -> Image:
    """Moments side by side."""
    height = max(tile.shape[0] for tile in tiles)
    row = np.full((height, row_px(PANELS), 3), GROUND, np.uint8)
    for k, tile in enumerate(tiles):
        left = k * (tile.shape[1] - GAP_PX)
        row[: tile.shape[0], left : left + tile.shape[1]] = tile
    return row
