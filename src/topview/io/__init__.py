"""Recordings in, skeletons out: one file per format."""

from topview.io.contents import Contents, contents_of
from topview.io.depth_range import DepthRange
from topview.io.mirrored import MirroredRecording
from topview.io.readers import open_recording, read_utd_skeleton
from topview.io.writers import (
    FramesFile,
    NothingStoredError,
    SkeletonFile,
    StoredFrames,
    prepare_output_folder,
    read_skeletons_npz,
    write_atomically,
    write_skeletons_csv,
    write_skeletons_npz,
)

__all__ = [
    "Contents",
    "DepthRange",
    "FramesFile",
    "MirroredRecording",
    "NothingStoredError",
    "SkeletonFile",
    "StoredFrames",
    "contents_of",
    "open_recording",
    "prepare_output_folder",
    "read_skeletons_npz",
    "read_utd_skeleton",
    "write_atomically",
    "write_skeletons_csv",
    "write_skeletons_npz",
]
