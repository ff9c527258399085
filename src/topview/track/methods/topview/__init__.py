"""The full tracker, the default: all parts refined together, limbs searched as pairs."""

from topview.track.methods.topview.tracker import TopviewSettings, TopviewTracker

__all__ = ["TopviewSettings", "TopviewTracker"]
