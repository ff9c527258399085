"""Depth as one array of an HDF5 file, by h5py; ITOP's files as they are published.

https://docs.h5py.org. ITOP (A. Haque et al., "Towards viewpoint invariant 3D human pose
estimation", ECCV 2016) holds `id` [N] (`00_00001`: person and frame) and `data` [N, 240, 320]
float16 metres; the authors' projection is column = x / (z C) + 160, row = 120 - y / (z C), with
C = 3.50666662e-3.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import MOST_BYTES, check_regular, naming, unharmed
from topview.io.readers.arrays import RIGHT_ARRAY, ArrayRecording
from topview.io.readers.camera_json import DEFAULT_FPS, CameraFile, read_camera_json
from topview.io.readers.notes import Notes
from topview.records import Camera, InputError

HDF5_SIGNATURE: Final = b"\x89HDF\r\n\x1a\n"
ITOP_CAMERA: Final = Camera(
    fx=1.0 / 3.50666662e-3, fy=1.0 / 3.50666662e-3, cx=160.0, cy=120.0, width=320, height=240
)
ITOP_KEYS: Final = {"id", "data"}
DEPTH_NAME: Final = "depth"
_RIGHT: Final = "it must be a whole HDF5 file"


def recognises(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE


class Hdf5Recording(ArrayRecording):
    """The frames of the one array that may be depth; of several, of that whose name has "depth".

    Raises:
        InputError: h5py is not installed, truncated, damaged, no such array or several, or
            camera.json is missing or wrong.
    """

    def __init__(self, path: Path) -> None:
        with naming(path):
            check_regular(path, _RIGHT)
            file = open_hdf5(path, _RIGHT)
            with unharmed(_RIGHT):
                is_itop = set(file) == ITOP_KEYS and file["data"].shape[1:] == (240, 320)
                self._stored = _chosen(_arrays(file))
        beside = path.with_name("camera.json")
        is_itop = is_itop and not beside.exists()
        camera_file = CameraFile(ITOP_CAMERA, 1.0, DEFAULT_FPS) if is_itop else None
        super().__init__(path, self._stored, camera_file or read_camera_json(beside, is_float=True))
        self._notes = Notes()
        self.problems = self._notes.lines
        if is_itop:
            self._notes.add(
                "camera.json is missing; taken for ITOP, whose people follow one after the other"
            )

    def _image(self, index: int) -> NDArray[Any] | None:
        try:
            with unharmed(_RIGHT):
                return np.asarray(self._stored[index])
        except InputError as error:
            self._notes.add_alike("frames cannot be read", f"frame {index}: {error}")
            return None


class _Images:
    """[F, H, W] of a data set that may be a single image."""

    def __init__(self, stored: Any) -> None:
        self._stored = stored
        self._is_one = stored.ndim == 2
        self.dtype = stored.dtype
        self.shape = (1, *stored.shape) if self._is_one else stored.shape

    def __len__(self) -> int:
        return int(self.shape[0])

    def __getitem__(self, index: int) -> Any:
        return self._stored[...] if self._is_one else self._stored[index]


def _arrays(file: Any) -> dict[str, Any]:
    """By name, the data sets that may be depth."""
    found: dict[str, Any] = {}

    def look(name: str, stored: Any) -> None:
        is_array = hasattr(stored, "chunks") and stored.dtype.kind in "iuf"
        if is_array and stored.ndim in (2, 3) and min(stored.shape[-2:]) > 1 and stored.size:
            found[name] = stored

    file.visititems(look)
    return found


def _chosen(arrays: dict[str, Any]) -> _Images:
    """The one that is depth."""
    named = {name: stored for name, stored in arrays.items() if DEPTH_NAME in name.lower()}
    candidates = named or arrays
    if len(candidates) != 1:
        names = ", ".join(sorted(candidates)) or "none"
        raise InputError(
            f'its arrays that may be depth are {names}; one must be, or have "depth" in its name: '
            f"{RIGHT_ARRAY}"
        )
    (stored,) = candidates.values()
    at_once = int(np.prod(stored.chunks or stored.shape[-2:], dtype=object)) * stored.dtype.itemsize
    if at_once > MOST_BYTES:
        raise InputError(f"has chunks of {at_once} bytes; they must have at most {MOST_BYTES}")
    return _Images(stored)


def open_hdf5(path: Path, right: str) -> Any:
    """An HDF5 file; errors do not name it.

    Raises:
        InputError: h5py is not installed, or no whole file; `right` says what it must be.
    """
    try:
        import h5py
    except ImportError:
        raise InputError(
            "HDF5 needs h5py; install it with: pip install 'topview[datasets]'"
        ) from None
    with unharmed(right):
        return h5py.File(path, "r")
