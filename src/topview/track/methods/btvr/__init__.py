"""The upper-body tracker of Sec. 5.1: the torso by basic TVR, the arms by their rendered depth."""

from topview.track.methods.btvr.tracker import BTVR_AS_PRINTED, BtvrSettings, BtvrTracker

__all__ = ["BTVR_AS_PRINTED", "BtvrSettings", "BtvrTracker"]
