"""One reader per recording format."""

from topview.io.readers.registry import READERS, Reader, open_recording
from topview.io.readers.utd_mhad import read_utd_skeleton

__all__ = ["READERS", "Reader", "open_recording", "read_utd_skeleton"]
