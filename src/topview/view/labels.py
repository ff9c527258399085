"""Texts in one picture that keep off each other."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.view.drawing import Image, draw_label, text_width
from topview.view.palette import Color

# The look of labels: all ours.
LINE_SHARE: Final = 1.6  # of the capitals' height, from one line of text to the next
MOST_LINES: Final = 6  # that a label moves up or down before it lies where it may


Box = tuple[float, float, float, float]  # left, top, right, bottom


class Labels:
    """Puts labels into a picture, each as near to its place as those before it leave room.

    Args:
        image: that is drawn into.
    """

    def __init__(self, image: Image) -> None:
        self._image = image
        self._taken: list[Box] = []

    def avoid(self, at: NDArray[np.floating], radius_px: float) -> None:
        """Keep all labels off a mark; one at NaN is nowhere."""
        x, y = at.tolist()
        self._taken.append((x - radius_px, y - radius_px, x + radius_px, y + radius_px))

    def put(
        self,
        text: str,
        at: tuple[float, float],
        color: Color,
        height_px: float = 8,
        most_lines: int | None = None,
    ) -> None:
        """Draw text centred on a place, or on the nearest free one, rather above or beside than
        below; all of it lies in the picture, if it is not wider. Where none is free it lies over
        others; it is left out if `most_lines` tells how far it may move."""
        half = text_width(text, height_px) / 2 + 2
        height, width = self._image.shape[:2]
        lowest, rightmost = max(height - 3.0, height_px + 3.0), max(width - half, half)
        x, y = min(max(at[0], half), rightmost), min(max(at[1], height_px + 3.0), lowest)
        reach = MOST_LINES if most_lines is None else most_lines
        boxes = [
            _box(x + 2 * half * aside, y + line * LINE_SHARE * height_px, half, height_px)
            for aside, line in sorted(product((0, -1, 1), range(-reach, reach + 1)), key=_effort)
        ]
        boxes = [
            (left, top, right, bottom)
            for left, top, right, bottom in boxes
            if left >= min(x - half, 0.0)
            and right <= max(x + half, width)
            and top >= 1.0
            and bottom <= lowest + 2.0
        ]
        box = next((box for box in boxes if not self._is_taken(box)), None)
        if box is None:
            if most_lines is not None:
                return
            box = _box(x, y, half, height_px)
        self._taken.append(box)
        draw_label(self._image, text, ((box[0] + box[2]) / 2, box[3] - 2), color, height_px)

    def _is_taken(self, box: Box) -> bool:
        left, top, right, bottom = box
        return any(
            left < other[2] and other[0] < right and top < other[3] and other[1] < bottom
            for other in self._taken
        )


def _box(x: float, baseline: float, half: float, height_px: float) -> Box:
    """What a label takes whose text is centred on a place."""
    return x - half, baseline - height_px - 2, x + half, baseline + 2


def _effort(move: tuple[int, int]) -> float:
    """Of a move by widths aside and lines down: rather up than aside than down."""
    aside, line = move
    return (2 * line + 1 if line > 0 else -line) + 1.5 * abs(aside)
