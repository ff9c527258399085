"""One writer per skeleton format."""

from topview.io.writers.csv import write_skeletons_csv
from topview.io.writers.frames_file import FramesFile, NothingStoredError, StoredFrames
from topview.io.writers.npz import SkeletonFile, read_skeletons_npz, write_skeletons_npz
from topview.io.writers.output import prepare_output_folder, write_atomically

__all__ = [
    "FramesFile",
    "NothingStoredError",
    "SkeletonFile",
    "StoredFrames",
    "prepare_output_folder",
    "read_skeletons_npz",
    "write_atomically",
    "write_skeletons_csv",
    "write_skeletons_npz",
]
