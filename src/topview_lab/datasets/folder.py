"""Recordings in the folder layout with a `groundtruth.npz` beside `depth/` and `camera.json`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from topview.io import MirroredRecording, open_recording
from topview.records import InputError, Recording
from topview_lab.datasets.base import select_by_name
from topview_lab.datasets.groundtruth import read_groundtruth
from topview_lab.datasets.true_heads import read_true_heads
from topview_lab.metrics import ReferenceSequence
from topview_lab.metrics.heads import TrueHeads

GROUNDTRUTH: Final = "groundtruth.npz"


@dataclass(frozen=True, slots=True)
class FolderRecording:
    """A folder with `depth/`, `camera.json` and `groundtruth.npz`.

    Attributes:
        path: of the folder.
        mirrored: the images are flipped left-right, the ground truth is not.
    """

    path: Path
    mirrored: bool = False

    @property
    def name(self) -> str:
        return self.path.name

    def open(self) -> Recording:
        recording = open_recording(self.path)
        return MirroredRecording(recording) if self.mirrored else recording

    def reference(self) -> ReferenceSequence:
        return read_groundtruth(self.path / GROUNDTRUTH, action=self.name)

    def true_heads(self) -> TrueHeads:
        """Of all frames."""
        return read_true_heads(self.path / GROUNDTRUTH)


def find_folder_recordings(
    paths: Sequence[Path], pattern: str = "*", mirrored: bool = False
) -> list[FolderRecording]:
    """The recordings at `paths`: each is one, or a folder of them; by path, then by name.

    Raises:
        InputError: a path is, and holds, no recording with a `groundtruth.npz`, or none matches.
    """
    recordings = [
        FolderRecording(path.resolve(), mirrored) for given in paths for path in _recordings(given)
    ]
    return select_by_name(recordings, pattern, ", ".join(map(str, paths)))


def _recordings(path: Path) -> list[Path]:
    if not path.is_dir():
        raise InputError(f"{path} is not a folder; give a recording's folder, or a folder of them")
    if (path / GROUNDTRUTH).is_file():
        return [path]
    inside = sorted(file.parent for file in path.glob(f"*/{GROUNDTRUTH}"))
    if not inside:
        raise InputError(
            f"{path}: no {GROUNDTRUTH} in it or in a folder of it; "
            "there is nothing to compare the tracker with"
        )
    return inside
