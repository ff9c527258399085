"""topview: 3D body tracking of several people from one depth camera. It needs no data of yours.

tracker = topview.Tracker()
for frame in topview.open(path):
    people = tracker.update(frame)
"""

from __future__ import annotations

from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any

from topview.records import (
    Camera,
    Distortion,
    Frame,
    InputError,
    JointState,
    Person,
    Recording,
)
from topview.skeletons import SkeletonSequence

if TYPE_CHECKING:
    from topview.track.settings import TrackerSettings
    from topview.track.tracker import Tracker

__all__ = [
    "Camera",
    "Distortion",
    "Frame",
    "InputError",
    "JointState",
    "Person",
    "Recording",
    "SkeletonSequence",
    "Tracker",
    "TrackerSettings",
    "open",
]

# Loaded when first asked for: the tracker brings numba, which takes a second.
_LAZY = {"Tracker": "topview.track.tracker", "TrackerSettings": "topview.track.settings"}


def open(path: str | PathLike[str], format: str | None = None) -> Recording:
    """Open a depth recording: a folder of images, a UTD-MHAD `*_depth.mat`, an organized `.pcd`.

    Iterate over it to get its `Frame`s, again if need be; frames that cannot be read are left out
    and named in its `problems`. See `topview.io.readers` for the formats and their names.

    Raises:
        InputError: the recording cannot be used at all; one line says why.
    """
    from topview.io.readers import open_recording

    return open_recording(path, format)


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_LAZY[name]), name)
