"""Depth as one NumPy array, `depth.npy`, with `camera.json` beside it.

https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import check_regular, naming
from topview.io.readers.arrays import RIGHT_ARRAY, ArrayRecording
from topview.io.readers.camera_json import read_camera_json
from topview.records import InputError

NPY_SIGNATURE: Final = b"\x93NUMPY"
DEPTH_NPY: Final = "depth.npy"


def recognises(path: Path) -> bool:
    if path.is_dir():
        return (path / DEPTH_NPY).is_file() and not (path / "depth").exists()
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(NPY_SIGNATURE)) == NPY_SIGNATURE


class NpyRecording(ArrayRecording):
    """The frames of one array, as `ArrayRecording` tells; of a folder, of its `depth.npy`.

    Raises:
        InputError: truncated, damaged, no such array, or camera.json is missing or wrong.
    """

    def __init__(self, path: Path) -> None:
        file = path / DEPTH_NPY if path.is_dir() else path
        with naming(file):
            self._stored = _array(file)
        camera_file = read_camera_json(file.with_name("camera.json"), is_float=True)
        super().__init__(file, self._stored, camera_file)
        self.name = path.stem

    def _image(self, index: int) -> NDArray[Any]:
        return self._stored[index]


def _array(path: Path) -> NDArray[Any]:
    """[F, H, W], mapped. Errors do not name the file."""
    check_regular(path)
    try:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    except OSError:
        raise
    except Exception as error:  # a damaged header raises SyntaxError, ValueError, OverflowError ...
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"is truncated or damaged ({reason}); {RIGHT_ARRAY}") from None
    if stored.dtype.kind not in "iuf" or stored.ndim not in (2, 3) or not stored.size:
        raise InputError(f"is {stored.dtype} {stored.shape}; {RIGHT_ARRAY}")
    return stored if stored.ndim == 3 else stored[None]
