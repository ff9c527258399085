"""The frame recipe and the full-body tracker."""

from topview.track.run import KeepFrame, TrackingResult, TrackingRun, track_recording
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker

__all__ = [
    "KeepFrame",
    "Tracker",
    "TrackerSettings",
    "TrackingResult",
    "TrackingRun",
    "track_recording",
]
