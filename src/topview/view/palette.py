"""The colours of every picture: RGB in 0..255, on a dark neutral ground.

People are told apart by the palette of Okabe and Ito, "Color Universal Design" (2008), which
colour-blind people can tell apart too, without its black and its dark blue, which would drown in
the ground.
"""

from __future__ import annotations

from typing import Final

Color = tuple[int, int, int]

GROUND: Final[Color] = (18, 20, 24)
PANEL: Final[Color] = (27, 30, 36)
GRID_LINE: Final[Color] = (58, 64, 74)
GRID_LINE_STRONG: Final[Color] = (92, 100, 114)
MUTED: Final[Color] = (150, 158, 170)
TEXT: Final[Color] = (232, 235, 240)
OUTLINE: Final[Color] = (8, 9, 11)

PEOPLE: Final[tuple[Color, ...]] = (
    (86, 180, 233),  # sky blue
    (230, 159, 0),  # orange
    (0, 178, 132),  # bluish green, a little brighter than printed
    (240, 228, 66),  # yellow
    (213, 94, 0),  # vermilion
    (204, 121, 167),  # reddish purple
)


def person_color(person_id: int) -> Color:
    """The colour of a person for as long as the id lasts; colours repeat after six people."""
    return PEOPLE[(person_id - 1) % len(PEOPLE)]


def mix(color: Color, other: Color, share: float) -> Color:
    """`color` with `share` (0..1) of `other` in it."""
    r, g, b = (round(c + (o - c) * share) for c, o in zip(color, other, strict=True))
    return r, g, b
