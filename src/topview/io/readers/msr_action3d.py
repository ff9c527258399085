"""MSR Action3D: one depth sequence, `a01_s01_e01_sdepth.bin`, of a Kinect-like camera.

W. Li, Z. Zhang and Z. Liu, "Action recognition based on a bag of 3D points", CVPR Workshop on
Human Communicative Behavior Analysis 2010. As the authors' sample program reads it: the numbers of
frames, columns and rows, then all frames row by row, everything 32-bit integers, least significant
byte first; the background is 0.

Neither camera nor unit are published. Decided by us: the nominal depth camera of the Kinect SDK;
millimetres, or the multiple of them that puts the person into the Kinect's range.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_bytes
from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.records import Camera, Frame, InputError

# NUI_CAMERA_DEPTH_NOMINAL_FOCAL_LENGTH_IN_PIXELS of the Kinect SDK, for 320 pixels.
FOCAL_SHARE_OF_WIDTH: Final = 285.63 / 320.0
MSR_FPS: Final = 15.0
"""Of the publication, Sec. 5."""
UNITS_MM: Final = (1.0, 2.0, 4.0, 8.0)
"""What one step of the depth may be (ours)."""
NEAREST_PERSON_M, FARTHEST_PERSON_M = 1.8, 4.5
"""A whole person fits into the image from here on; the Kinect does not see much further (ours)."""
_HEADER: Final = np.dtype("<i4")
_MAX_SIDE, _MAX_FRAMES = 4096, 100_000  # ours: more is no such file


def recognises(path: Path) -> bool:
    return path.name.lower().endswith("_sdepth.bin")


class MsrAction3dRecording:
    """The frames of one `*_sdepth.bin`.

    Args:
        path: of the file.
        metres_per_unit: of the depth, told from the depth itself if None.

    Raises:
        InputError: unreadable, truncated, or not such a file.
    """

    def __init__(self, path: Path, metres_per_unit: float | None = None) -> None:
        self.name = path.name.removesuffix("_sdepth.bin")
        self.problems: list[str] = []
        with naming(path):
            self.depth_units = read_depth_units(path)
            self.metres_per_unit = metres_per_unit or likely_unit_m(self.depth_units)
        height, width = self.depth_units.shape[1:]
        focal = FOCAL_SHARE_OF_WIDTH * width
        # The principal point as in the SDK's own conversion: half the size.
        self.camera = Camera(focal, focal, width / 2.0, height / 2.0, width, height)

    @property
    def frame_count(self) -> int:
        return len(self.depth_units)

    def __iter__(self) -> Iterator[Frame]:
        for index, units in enumerate(self.depth_units):
            depth_m = depth_image(units, self.metres_per_unit)
            yield Frame(index, index / MSR_FPS, depth_m, self.camera)


def read_depth_units(path: Path) -> NDArray[np.int32]:
    """[F, H, W] stored depth. Errors do not name the file."""
    right = "it must be an MSR Action3D *_sdepth.bin"
    data = read_bytes(path)
    if len(data) < 3 * _HEADER.itemsize:
        raise InputError(f"has {len(data)} bytes; {right}")
    frames, columns, rows = (int(n) for n in np.frombuffer(data, _HEADER, 3))
    if not (0 < frames <= _MAX_FRAMES and 0 < columns <= _MAX_SIDE and 0 < rows <= _MAX_SIDE):
        raise InputError(f"begins with {frames} frames of {columns} x {rows} pixels; {right}")
    wanted = (3 + frames * columns * rows) * _HEADER.itemsize
    if len(data) != wanted:
        raise InputError(
            f"has {len(data)} bytes for {frames} frames of {columns} x {rows} pixels; "
            f"it must have {wanted}"
        )
    return np.frombuffer(data, _HEADER, offset=3 * _HEADER.itemsize).reshape(frames, rows, columns)


def likely_unit_m(depth_units: NDArray[np.int32]) -> float:
    """Metres in the least unit that puts a person into the Kinect's range. Errors do not name the
    file."""
    readings = depth_units[depth_units > 0]
    if not readings.size:
        raise InputError("has no depth reading at all; it must show a person")
    median = float(np.median(readings))
    for unit_mm in UNITS_MM:
        if NEAREST_PERSON_M <= METRES_PER_MILLIMETRE * unit_mm * median <= FARTHEST_PERSON_M:
            return METRES_PER_MILLIMETRE * unit_mm
    raise InputError(
        f"has a median depth of {median:g}; it must be {NEAREST_PERSON_M:g} to "
        f"{FARTHEST_PERSON_M:g} m in units of {', '.join(f'{unit:g}' for unit in UNITS_MM)} mm"
    )
