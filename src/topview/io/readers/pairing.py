"""Which colour image belongs to which depth image, where each has a time of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

MOST_APART_S: Final = 0.034
"""Between a depth image and its colour image: half the time between images at 15 per second, by
which a hand at 3 m/s moves 10 cm (ours)."""
MOST_WAITING: Final = 64  # images that wait for others; ours


def nearest_in_time(times_s: Mapping[int, float], wanted_s: Mapping[int, float]) -> dict[int, int]:
    """Of each wanted time the key of the nearest of others, where it is near enough."""
    if not times_s:
        return {}
    keys = sorted(times_s, key=lambda key: times_s[key])
    times = np.array([times_s[key] for key in keys])
    pairs: dict[int, int] = {}
    for wanted, time_s in wanted_s.items():
        after = int(np.searchsorted(times, time_s))
        near = [k for k in (after - 1, after) if 0 <= k < len(keys)]
        best = min(near, key=lambda k: abs(times[k] - time_s))
        if abs(times[best] - time_s) <= MOST_APART_S:
            pairs[wanted] = keys[best]
    return pairs


@dataclass(frozen=True, slots=True)
class StoredImage:
    """An image as a file or a camera holds it.

    Attributes:
        time_s: seconds since whatever, the same for depth and colour.
        is_color: False for depth.
        data: not decoded yet.
    """

    time_s: float
    is_color: bool
    data: Any


def paired(images: Iterable[StoredImage]) -> Iterator[tuple[StoredImage, StoredImage | None]]:
    """Each depth image with the nearest colour image in time, if it is near enough.

    Args:
        images: depth and colour, each rising in time, mixed about as they were taken.
    """
    depths: deque[StoredImage] = deque()
    colors: deque[StoredImage] = deque()
    for image in images:
        (colors if image.is_color else depths).append(image)
        while depths and (len(depths) > MOST_WAITING or _is_settled(depths[0], colors)):
            yield _with_nearest(depths.popleft(), colors)
        if len(colors) > MOST_WAITING:
            colors.popleft()
    while depths:
        yield _with_nearest(depths.popleft(), colors)


def _is_settled(depth: StoredImage, colors: deque[StoredImage]) -> bool:
    """Whether no colour image that is still to come can be nearer."""
    return bool(colors) and colors[-1].time_s >= depth.time_s


def _with_nearest(
    depth: StoredImage, colors: deque[StoredImage]
) -> tuple[StoredImage, StoredImage | None]:
    while len(colors) > 1 and colors[1].time_s <= depth.time_s:
        colors.popleft()
    near = [color for color in colors if abs(color.time_s - depth.time_s) <= MOST_APART_S]
    best = min(near, key=lambda color: abs(color.time_s - depth.time_s), default=None)
    return depth, best
