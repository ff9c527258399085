"""The frame recipe and the full-body tracker."""

from topview.track.run import TrackingResult, track_recording
from topview.track.settings import TrackerSettings
from topview.track.tracker import Tracker

__all__ = ["Tracker", "TrackerSettings", "TrackingResult", "track_recording"]
