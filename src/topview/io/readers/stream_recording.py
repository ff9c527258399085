"""A file of depth and colour images one after the other, each with its own time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.io.readers.notes import Notes
from topview.io.readers.pairing import StoredImage, paired
from topview.io.readers.rig import Rig
from topview.records import Frame, InputError


class StreamRecording(ABC):
    """Its frames in order of time, each with the colour nearest to it, undistorted.

    An image that cannot be decoded costs its own frame. Where the file itself is damaged, the
    frames before are kept.

    Attributes:
        name: the file's, without its suffix.
        camera: what took the depth images, with its lens.
        color_camera: what took the colour images; None where they are registered or missing.
        problems: relative to the file.
    """

    def __init__(self, path: Path, rig: Rig, frame_count: int | None) -> None:
        self.path = path
        self.name = path.stem
        self.camera = rig.camera
        self.color_camera = None if rig.color_camera is None else rig.color_camera.camera
        self.notes = Notes()
        self.problems = self.notes.lines
        self._rig = rig
        self._frame_count = frame_count

    @property
    def frame_count(self) -> int | None:
        """How many depth images there should be."""
        return self._frame_count

    @abstractmethod
    def images(self) -> Iterator[StoredImage]:
        """Depth and colour, in the file's order. Raises InputError where it is damaged."""

    @abstractmethod
    def depth_m(self, data: Any) -> NDArray[np.float32]:
        """[H, W] metres, decoded. Raises InputError for what is no depth image."""

    @abstractmethod
    def color(self, data: Any) -> NDArray[np.uint8]:
        """[H, W, 3] RGB, decoded. Raises InputError for what is no colour image."""

    def __iter__(self) -> Iterator[Frame]:
        start_s = before_s = None
        for index, (depth, color) in enumerate(paired(self._until_damage())):
            if before_s is not None and depth.time_s <= before_s:
                told = f"its time is {depth.time_s - before_s:.3f} s after the frame before"
                self._left_out(index, f"{told}; it must be later")
                continue
            try:
                depth_m = self._rig.depth(self._of_size(self.depth_m(depth.data)))
                seen = None if color is None else self._registered(index, color.data, depth_m)
                start_s = depth.time_s if start_s is None else start_s
                frame = Frame(index, depth.time_s - start_s, depth_m, self._rig.pinhole, seen)
            except InputError as error:
                self._left_out(index, str(error))
                continue
            before_s = depth.time_s
            yield frame

    def _until_damage(self) -> Iterator[StoredImage]:
        try:
            yield from self.images()
        except InputError as error:
            self.notes.add(f"{error}; the frames before are kept")

    def _left_out(self, index: int, why: str) -> None:
        line = f"frame {index}: {why.removeprefix(f'frame {index}: ')}; left out"
        self.notes.add_alike("frames cannot be read", line)

    def _of_size(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        size = (self.camera.height, self.camera.width)
        if depth_m.shape != size:
            raise InputError(
                f"depth is {depth_m.shape[1]} x {depth_m.shape[0]} pixels; it must be "
                f"{size[1]} x {size[0]}, as the calibration says"
            )
        return depth_m

    def _registered(
        self, index: int, data: Any, depth_m: NDArray[np.float32]
    ) -> NDArray[np.uint8] | None:
        """[H, W, 3] registered to an undistorted depth image; None where that cannot be."""
        try:
            color = self.color(data)
        except InputError as error:
            line = f"frame {index}: colour {error}; the frame comes without"
            self.notes.add_alike("frames come without colour", line)
            return None
        size = (color.shape[1], color.shape[0])
        if size != self._rig.color_size:
            self.notes.add(
                f"colour images are {size[0]} x {size[1]} pixels; {self._rig.right_color}; "
                "going on without colour"
            )
            return None
        return self._rig.color(color, depth_m)
