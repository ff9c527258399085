"""Which formats there are, and which one a path has."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from os.path import exists
from pathlib import Path
from typing import Final

from topview.files import naming
from topview.io.readers import (
    azure_mkv,
    berkeley_mhad,
    folder,
    hdf5,
    msr_action3d,
    npy,
    pcd,
    ros_bag,
    tum_rgbd,
    utd_mhad,
)
from topview.records import InputError, Recording

_LOGGER: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Reader:
    """A format: what it is in words, whether a path looks like it, and how to open one."""

    name: str
    reads: str
    recognises: Callable[[Path], bool]
    open: Callable[[Path], Recording]


READERS: Final[dict[str, Reader]] = {
    reader.name: reader
    for reader in (
        Reader(
            "folder",
            "a folder with depth/000000.png ... and camera.json",
            folder.recognises,
            folder.FolderRecording,
        ),
        Reader(
            "tum",
            "a folder of TUM RGB-D with depth/, depth.txt, rgb/, rgb.txt",
            tum_rgbd.recognises,
            tum_rgbd.TumRecording,
        ),
        Reader("utd-mhad", "a *_depth.mat", utd_mhad.recognises, utd_mhad.UtdMhadRecording),
        Reader(
            "msr-action3d",
            "a *_sdepth.bin",
            msr_action3d.recognises,
            msr_action3d.MsrAction3dRecording,
        ),
        Reader(
            "berkeley-mhad",
            "a folder Kinect/Kin01/S01/A01/R01 of the data set",
            berkeley_mhad.recognises,
            berkeley_mhad.BerkeleyMhadRecording,
        ),
        Reader(
            "ros",
            "a ROS .bag, .db3 or .mcap, or a folder of ROS 2",
            ros_bag.recognises,
            ros_bag.RosRecording,
        ),
        Reader(
            "azure-kinect",
            "an .mkv of an Azure Kinect or Orbbec Femto",
            azure_mkv.recognises,
            azure_mkv.AzureRecording,
        ),
        Reader("npy", "a depth .npy with camera.json", npy.recognises, npy.NpyRecording),
        Reader(
            "hdf5", "an HDF5 file with camera.json, or of ITOP", hdf5.recognises, hdf5.Hdf5Recording
        ),
        Reader("pcd", "an organized .pcd", pcd.recognises, pcd.PcdRecording),
    )
}


RIGHT_SOURCE: Final = "docs/recordings.md says what is read, docs/live.md which cameras"
# What formats that are not read are, and what to do with them: by the file's suffix.
NOT_READ: Final = {
    (".oni",): "is an OpenNI recording; export its frames as images with OpenNI 2",
    (".xef", ".xed"): "is a Kinect Studio recording; export its frames as images",
    (".mp4", ".avi", ".mov", ".webm"): "is a video without depth; depth is needed",
    (".npz",): "is an archive of arrays; save the depth alone as depth.npy",
    (".svo", ".svo2"): "is a ZED recording; export depth as images with the ZED SDK",
}


def format_of(path: Path) -> Reader:
    """The reader that recognises what is at a path.

    Raises:
        InputError: none does; says how to convert it where that is known.
    """
    with naming(path):
        for reader in reversed(READERS.values()):  # any folder is taken for one of images
            if reader.recognises(path):
                return reader
    if path.is_file() and not path.stat().st_size:
        raise InputError(f"{path}: is empty; it must be one of {_known()}")
    for suffixes, what in NOT_READ.items():
        if path.suffix.lower() in suffixes:
            raise InputError(f"{path}: {what} (docs/recordings.md says how)")
    raise InputError(f"{path}: no format that is known; it must be one of {_known()}")


def open_recording(path: str | PathLike[str], format: str | None = None) -> Recording:
    """Open a recording; the format is told from the path unless it is named.

    Frames are read one by one as they are iterated over.

    Raises:
        InputError: no such path, a format that is not known, or a recording that cannot be used.
    """
    if format is not None and format not in READERS:
        raise InputError(f"format is {format!r}; it must be one of {_known()}")
    if not exists(path):
        raise InputError(f"{path}: no such file or folder; {RIGHT_SOURCE}")
    path = Path(path)
    reader = format_of(path) if format is None else READERS[format]
    recording = reader.open(path)
    _LOGGER.info("%s: %s", path, reader.reads)
    for problem in recording.problems:
        _LOGGER.warning("%s: %s", path, problem)
    return recording


def _known() -> str:
    return ", ".join(f"{reader.name} ({reader.reads})" for reader in READERS.values())
