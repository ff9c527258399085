"""What the makers' libraries have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, TypeVar

from topview.io.readers.pairing import StoredImage
from topview.records import InputError

WAITS_S: Final = 5.0  # ours; a camera that gives no frame for so long is gone
Known = TypeVar("Known")


def number_of(camera: str, serial: str, serials: Sequence[str]) -> int:
    """Which of the cameras that are connected is meant.

    Args:
        camera: the word of the command line, as "realsense".
        serial: of the one that is meant; empty for the first.
        serials: of those that are there.

    Raises:
        InputError: it is not there.
    """
    if serials and not serial:
        return 0
    if serial not in serials:
        there = f"there are {', '.join(serials)}" if serials else "none is connected"
        raise InputError(f"{camera}:{serial} names no camera that is there; {there}")
    return serials.index(serial)


def known_lens(model: str, lenses: Mapping[str, Known]) -> Known:
    """What a library's name of a lens means here.

    Raises:
        InputError: it is none of the `lenses`.
    """
    if model not in lenses:
        raise InputError(f"the lens is {model}; it must be one of {', '.join(lenses)}")
    return lenses[model]


def gone(camera: str, what: str = "frame") -> InputError:
    """For a camera that gave nothing for `WAITS_S`."""
    return InputError(f"{camera}: no {what} for {WAITS_S:g} s")


def next_pair(
    next_image: Callable[[bool], StoredImage | None], has_color: bool, fps: float
) -> tuple[StoredImage, StoredImage | None] | None:
    """Wait for a depth image, and the colour image taken within half a frame of it.

    Args:
        next_image: waits for the next colour image, or depth image; None once there are no more.
        has_color: colour is waited for.
        fps: frames per second.

    Returns:
        Depth and colour; None once there are no more.
    """
    near_s = 0.5 / fps
    depth, color = next_image(False), None
    while depth is not None and has_color:
        if color is None or color.time_s < depth.time_s - near_s:
            if (color := next_image(True)) is None:
                return None
        elif color.time_s > depth.time_s + near_s:
            depth = next_image(False)
        else:
            break
    return None if depth is None else (depth, color)
