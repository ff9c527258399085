"""The upper-body tracker of Sec. 5.1: the torso by basic TVR, the arms by their rendered depth."""

from topview.track.upper_body.tracker import UpperBodySettings, UpperBodyTracker

__all__ = ["UpperBodySettings", "UpperBodyTracker"]
