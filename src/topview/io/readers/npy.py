"""Depth as one NumPy array, `depth.npy`, with `camera.json` beside it.

https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import check_regular, naming
from topview.io.readers.camera_json import read_camera_json
from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.rig import Rig
from topview.records import Frame, InputError

NPY_SIGNATURE: Final = b"\x93NUMPY"
_RIGHT: Final = "it must be [frames, height, width] or [height, width], uint16 mm or float metres"


def recognises(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(NPY_SIGNATURE)) == NPY_SIGNATURE


class NpyRecording:
    """The frames of one array, of which only those that are looked at are read; without colour.

    Integers are in the unit of camera.json's depth_scale, millimetres if it says none; floating
    point numbers are metres unless it says otherwise. Time is index / fps.

    Raises:
        InputError: truncated, damaged, no such array, or camera.json is missing or wrong.
    """

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self.problems: list[str] = []
        with naming(path):
            stored = _array(path)
        camera_file = read_camera_json(path.with_name("camera.json"), is_float=True)
        self.camera = camera_file.camera
        self.fps = camera_file.fps
        is_integer = stored.dtype.kind in "iu"
        scale = camera_file.metres_per_unit
        self._metres_per_unit = METRES_PER_MILLIMETRE if is_integer and scale == 1.0 else scale
        wanted = (self.camera.height, self.camera.width)
        if stored.shape[1:] != wanted:
            raise InputError(
                f"{path}: images are {stored.shape[2]} x {stored.shape[1]} pixels; they must be "
                f"{wanted[1]} x {wanted[0]}, as camera.json says"
            )
        with naming(path.with_name("camera.json")):
            self._rig = Rig(self.camera)
        self._stored = stored

    @property
    def frame_count(self) -> int:
        return len(self._stored)

    @property
    def indices(self) -> range:
        """Of all frames."""
        return range(len(self._stored))

    def frame(self, index: int) -> Frame:
        """One frame by its index."""
        depth_m = self._rig.depth(depth_image(self._stored[index], self._metres_per_unit))
        return Frame(index, index / self.fps, depth_m, self._rig.pinhole)

    def __iter__(self) -> Iterator[Frame]:
        for index in self.indices:
            yield self.frame(index)


def _array(path: Path) -> NDArray[Any]:
    """[F, H, W], mapped. Errors do not name the file."""
    check_regular(path)
    try:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    except OSError:
        raise
    except Exception as error:  # a damaged header raises SyntaxError, ValueError, OverflowError ...
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"is truncated or damaged ({reason}); {_RIGHT}") from None
    if stored.dtype.kind not in "iuf" or stored.ndim not in (2, 3) or not stored.size:
        raise InputError(f"is {stored.dtype} {stored.shape}; {_RIGHT}")
    return stored if stored.ndim == 3 else stored[None]
