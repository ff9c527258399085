"""Depth as one array of images, with `camera.json` beside it: what its readers share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io.readers.camera_json import CameraFile
from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.rig import Rig
from topview.records import Frame, InputError

RIGHT_ARRAY: Final = (
    "it must be [frames, height, width] or [height, width], uint16 mm or float metres"
)


class ArrayRecording:
    """The frames of one array, of which only those that are looked at are read; without colour.

    Integers are in the unit of camera.json's depth_scale, millimetres if it says none; floating
    point numbers are metres unless it says otherwise. Time is index / fps.

    Args:
        path: of the file with the array; camera.json is beside it.
        array: [F, H, W], in memory or not.
        camera_file: what camera.json says.

    Raises:
        InputError: camera.json tells another size, or a lens that cannot be undone.
    """

    def __init__(self, path: Path, array: Any, camera_file: CameraFile) -> None:
        self.name = path.stem
        self.problems: list[str] = []
        self.camera = camera_file.camera
        self.fps = camera_file.fps
        is_integer = array.dtype.kind in "iu"
        scale = camera_file.metres_per_unit
        self._metres_per_unit = METRES_PER_MILLIMETRE if is_integer and scale == 1.0 else scale
        wanted = (self.camera.height, self.camera.width)
        if array.shape[1:] != wanted:
            raise InputError(
                f"{path}: images are {array.shape[2]} x {array.shape[1]} pixels; they must be "
                f"{wanted[1]} x {wanted[0]}, as camera.json says"
            )
        with naming(path.with_name("camera.json")):
            self._rig = Rig(self.camera)
        self.frame_count = len(array)

    def _image(self, index: int) -> NDArray[Any] | None:
        """[H, W] values of a frame; None where they cannot be read."""
        raise NotImplementedError

    @property
    def indices(self) -> range:
        """Of all frames."""
        return range(self.frame_count)

    def frame(self, index: int) -> Frame | None:
        """One frame by its index; None where it cannot be read."""
        image = self._image(index)
        if image is None:
            return None
        if image.dtype == np.float16:  # too few digits to be multiplied
            image = image.astype(np.float32)
        depth_m = self._rig.depth(depth_image(image, self._metres_per_unit))
        return Frame(index, index / self.fps, depth_m, self._rig.pinhole)

    def __iter__(self) -> Iterator[Frame]:
        for index in self.indices:
            if (frame := self.frame(index)) is not None:
                yield frame
