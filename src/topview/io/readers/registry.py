"""Which formats there are, and which one a path has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from os.path import exists
from pathlib import Path
from typing import Final

from topview.io.readers import berkeley_mhad, folder, msr_action3d, pcd, tum_rgbd, utd_mhad
from topview.records import InputError, Recording


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
        Reader("pcd", "an organized .pcd", pcd.recognises, pcd.PcdRecording),
    )
}


def open_recording(path: str | PathLike[str], format: str | None = None) -> Recording:
    """Open a recording; the format is told from the path unless it is named.

    Frames are read one by one as they are iterated over.

    Raises:
        InputError: no such path, a format that is not known, or a recording that cannot be used.
    """
    known = ", ".join(f"{reader.name} ({reader.reads})" for reader in READERS.values())
    if format is not None and format not in READERS:
        raise InputError(f"format is {format!r}; it must be one of {known}")
    if not exists(path):
        raise InputError(f"{path}: no such file or folder; it must be one of {known}")
    path = Path(path)
    if format is not None:
        return READERS[format].open(path)
    for reader in reversed(READERS.values()):  # any folder is taken for one of images
        if reader.recognises(path):
            return reader.open(path)
    raise InputError(f"{path}: no format that is known; it must be one of {known}")
