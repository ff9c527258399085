"""What is in a recording, by a look at a few of its frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from os import PathLike
from pathlib import Path
from statistics import median
from typing import Any, Final

import numpy as np

from topview.io.camera_values import camera_values
from topview.io.depth_range import DepthRange
from topview.io.readers import format_of, open_recording
from topview.records import Frame, InputError, Recording

FRAMES_LOOKED_AT: Final = 8  # ours


@dataclass(frozen=True, slots=True)
class Contents:
    """What a recording holds; plain JSON types.

    Attributes:
        name: of the recording.
        format: the name of its reader.
        reads: what that reads, in words.
        camera: of the depth images, as `camera.json` would say it.
        color: "none", "registered" where the source's colour is registered to the depth, or
            "registered here".
        color_camera: of colour that is registered here; None otherwise.
        frames: how many there should be; None if only reading all of them would tell.
        frames_per_s: None of a single frame.
        length_s: from the first frame to the last; None if only reading all would tell.
        frames_looked_at: what the rest is told by.
        nearest_m, median_m, farthest_m: of 1, 50 and 99 % of the readings; None without any.
        valid_share: of the pixels, those that have a reading.
        problems: what is missing or odd.
    """

    name: str
    format: str
    reads: str
    camera: dict[str, Any]
    color: str
    color_camera: dict[str, Any] | None
    frames: int | None
    frames_per_s: float | None
    length_s: float | None
    frames_looked_at: int
    nearest_m: float | None
    median_m: float | None
    farthest_m: float | None
    valid_share: float
    problems: list[str]


def contents_of(path: str | PathLike[str]) -> Contents:
    """Look at a recording.

    Raises:
        InputError: it cannot be used, or none of the frames that were looked at can be read.
    """
    recording = open_recording(path)
    reader = format_of(Path(path))
    frames = list(_some_frames(recording))
    if not frames:
        why = f": {recording.problems[0]}" if recording.problems else ""
        raise InputError(f"{path}: none of the frames looked at can be read{why}")
    depths = DepthRange()
    for frame in frames:
        depths.add(frame.depth_m)
    has_readings = depths.valid_share > 0.0
    color_camera = getattr(recording, "color_camera", None)
    rate, length_s = _rate_and_length(recording, frames)
    color = "registered here" if color_camera is not None else "registered"
    if all(frame.color is None for frame in frames):
        color, color_camera = "none", None
    problem = [depths.problem] if depths.problem else []
    near_m, middle_m, far_m = (
        depths.quantile_m(q) if has_readings else None for q in (0.01, 0.5, 0.99)
    )
    return Contents(
        name=recording.name,
        format=reader.name,
        reads=reader.reads,
        camera=camera_values(recording.camera),
        color=color,
        color_camera=None if color_camera is None else camera_values(color_camera),
        frames=recording.frame_count,
        frames_per_s=rate,
        length_s=length_s,
        frames_looked_at=len(frames),
        nearest_m=near_m,
        median_m=middle_m,
        farthest_m=far_m,
        valid_share=depths.valid_share,
        problems=[*recording.problems, *problem],
    )


def _some_frames(recording: Recording) -> Iterator[Frame]:
    """From the first to the last where the reader can leap to them; else the first ones."""
    leap, indices = getattr(recording, "frame", None), getattr(recording, "indices", None)
    if leap is None or indices is None:
        yield from islice(recording, FRAMES_LOOKED_AT)
        return
    count = min(FRAMES_LOOKED_AT, len(indices))
    for at in np.linspace(0, len(indices) - 1, count).round().astype(int).tolist():
        if (frame := leap(indices[at])) is not None:
            yield frame


def _rate_and_length(
    recording: Recording, frames: list[Frame]
) -> tuple[float | None, float | None]:
    """Frames per second and seconds, as far as these frames tell."""
    times_s = [frame.timestamp_s for frame in frames]
    count, told_s = recording.frame_count, getattr(recording, "length_s", None)
    looked_s = times_s[-1] - times_s[0]
    if len(frames) < 2 or looked_s <= 0.0:
        return None, told_s if count is None else 0.0
    if hasattr(recording, "indices") and count is not None:
        return (count - 1) / looked_s, looked_s
    rate = 1.0 / median(np.diff(times_s).tolist())
    return rate, (told_s if count is None else (count - 1) / rate)
