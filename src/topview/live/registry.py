"""Which live cameras there are, by the words of the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name
from typing import Final

from topview.live.camera import DepthCamera
from topview.live.folder_writer import FolderWriter
from topview.live.recording import LiveRecording
from topview.records import InputError

# Name: what opens one, given what stands after the colon.
LIVE_CAMERAS: Final[dict[str, str]] = {
    "realsense": "topview.live.realsense:RealSenseCamera",
    "orbbec": "topview.live.orbbec:OrbbecCamera",
    "oak": "topview.live.oak:OakCamera",
    "ros2": "topview.live.ros2:Ros2Camera",
}


def is_camera(source: str) -> bool:
    """Whether words such as "realsense:" name a live camera."""
    return source.partition(":")[0] in LIVE_CAMERAS and ":" in source


def open_camera(source: str, record: Path | None = None) -> LiveRecording:
    """Start a camera.

    Args:
        source: its name, a colon, and maybe which one: "realsense:", "realsense:923322071108",
            "ros2:/camera/depth/image_raw".
        record: folder to record the frames to that are tracked.

    Raises:
        InputError: there is no such camera, or its library is missing.
    """
    name, _, which = source.partition(":")
    if name not in LIVE_CAMERAS:
        known = ", ".join(f"{camera}:" for camera in LIVE_CAMERAS)
        raise InputError(f"camera is {source!r}; it must be one of {known}")
    make: Callable[[str], DepthCamera] = resolve_name(LIVE_CAMERAS[name])
    camera = make(which)
    try:
        return LiveRecording(camera, None if record is None else FolderWriter(record, camera))
    except BaseException:
        camera.close()
        raise
