"""The same recording as it would have come at another rate, or with a pause."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from topview.records import Frame

FPS = 30
"""Of what is taken."""


def at_rate(frames: Sequence[Frame], fps: int) -> list[Frame]:
    """Frames are left out, or shown several times."""
    if fps <= FPS:
        return list(frames[:: FPS // fps])
    times = fps // FPS
    return [
        replace(frame, timestamp_s=frame.timestamp_s + k / fps, index=times * frame.index + k)
        for frame in frames
        for k in range(times)
    ]


def after_pause(frames: Iterable[Frame], pause_s: float) -> list[Frame]:
    """The same frames, so much later."""
    return [replace(frame, timestamp_s=frame.timestamp_s + pause_s) for frame in frames]


def renumbered(frames: Iterable[Frame], first: int, step: int) -> list[Frame]:
    """The same frames with other numbers."""
    return [replace(frame, index=first + step * k) for k, frame in enumerate(frames)]
