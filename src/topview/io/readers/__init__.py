"""One reader per recording format."""

from topview.io.readers.registry import READERS, Reader, format_of, open_recording
from topview.io.readers.utd_mhad import read_utd_skeleton

__all__ = ["READERS", "Reader", "format_of", "open_recording", "read_utd_skeleton"]
