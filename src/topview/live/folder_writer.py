"""A folder recording that is written frame by frame."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io import prepare_output_folder
from topview.io.camera_values import camera_values
from topview.io.writers.output import HAS_ROOM, write_atomically
from topview.live.camera import DepthCamera, RawFrame
from topview.records import Frame, InputError

PNG_SPEED: Final = (cv2.IMWRITE_PNG_COMPRESSION, 1)  # ours: the disk keeps up, files are larger


class FolderWriter:
    """Writes `depth/000000.png`, `rgb/000000.png`, their times in `depth.txt` and `rgb.txt`, and
    `camera.json`. A frame counts once it is confirmed, which writes its time, so that the folder
    holds what was tracked and no other frame, whatever ends the run.

    Raises:
        InputError: the folder holds a recording already, or cannot be written to.
    """

    def __init__(self, folder: Path, source: DepthCamera) -> None:
        self.folder = prepare_output_folder(folder)
        for taken in ("depth", "rgb", "camera.json"):
            if (folder / taken).exists():
                raise InputError(f"{folder / taken}: is there already; record to a new folder")
        about = camera_values(source.camera)
        about |= {"depth_scale": source.metres_per_unit, "fps": source.fps}
        if source.color is not None:
            T = source.color.T_color_depth.tolist()
            about["color"] = {**camera_values(source.color.camera), "T_color_depth": T}
        with naming(folder, "written", HAS_ROOM):
            for name in ("depth", "rgb"):
                (folder / name).mkdir()
            self._lists = {name: (folder / f"{name}.txt").open("w") for name in ("depth", "rgb")}
        write_atomically(folder / "camera.json", json.dumps(about, indent=1).encode() + b"\n")
        self._waiting: list[tuple[str, Frame]] = []

    def append(self, raw: RawFrame, frame: Frame) -> None:
        """Write the images of a frame as the camera gave them.

        Args:
            raw: its images.
            frame: what was made of it, with its time and name.
        """
        if raw.color is not None:
            self._write("rgb", np.ascontiguousarray(raw.color[..., ::-1]), frame)
        self._write("depth", raw.depth, frame)

    def confirm(self) -> None:
        """The frame that was written last was tracked."""
        for kind, frame in self._waiting:
            with naming(self.folder / f"{kind}.txt", "written", HAS_ROOM):
                self._lists[kind].write(f"{frame.timestamp_s!r} {kind}/{frame.name}\n")
                self._lists[kind].flush()
        self._waiting = []

    def close(self) -> None:
        """End it; a frame that was not confirmed is removed."""
        for kind, frame in self._waiting:
            (self.folder / kind / frame.name).unlink(missing_ok=True)
        self._waiting = []
        for file in self._lists.values():
            file.close()

    def _write(self, kind: str, image: NDArray[Any], frame: Frame) -> None:
        path = self.folder / kind / frame.name
        _, png = cv2.imencode(".png", image, PNG_SPEED)
        self._waiting.append((kind, frame))
        with naming(path, "written", HAS_ROOM):
            path.write_bytes(png.tobytes())
