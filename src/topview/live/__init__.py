"""Cameras that are live: recordings whose frames are dropped where the tracker is slower."""

from topview.live.camera import DepthCamera, RawFrame
from topview.live.recording import LiveRecording
from topview.live.registry import LIVE_CAMERAS, is_camera, open_camera

__all__ = [
    "LIVE_CAMERAS",
    "DepthCamera",
    "LiveRecording",
    "RawFrame",
    "is_camera",
    "open_camera",
]
