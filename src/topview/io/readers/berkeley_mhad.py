"""Berkeley MHAD: one sequence of a Kinect, `Kinect/Kin01/S01/A04/R01`, in the published layout.

F. Ofli, R. Chaudhry, G. Kurillo, R. Vidal and R. Bajcsy, "Berkeley MHAD: a comprehensive
multimodal human action database", WACV 2013; 30 frames a second at 640 x 480.

As the authors' own example reads them: depth is millimetres in 16-bit `.pgm`, seen by the camera
matrix K of `Calibration/camcfg_k01.yml`, whose lens distortion is left aside; `RwTw_k01.txt` holds
the rotation and, in millimetres, the shift from the frame of the motion capture to the Kinect's.
Decided by us: colour is taken to be registered to the depth, as both have the one K.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_bytes, read_text
from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.netpbm import decode_netpbm
from topview.io.readers.notes import Notes
from topview.records import MAX_PLACE_M, Camera, Frame, InputError

FPS: Final = 30.0
SEQUENCE_DEPTH: Final = 5  # folders from a sequence's up to that of the data set
_DEPTH_FILE: Final = re.compile(
    r"kin_k([0-9]+)_s([0-9]+)_a([0-9]+)_r([0-9]+)_depth_([0-9]{1,18})\.pgm"
)
# OpenCV's own parser is strict about versions of the format, and writes to stderr.
_CAMERA_MATRIX: Final = re.compile(
    r"Camera_1\s*:.*?\bK\s*:\s*!!opencv-matrix.*?\bdata\s*:\s*\[([^\]]*)\]", re.DOTALL
)
_ROTATION_ERROR: Final = 1e-3  # ours: the file has nine digits


def recognises(path: Path) -> bool:
    return path.is_dir() and next(path.glob("kin_k*_depth_*.pgm"), None) is not None


class BerkeleyMhadRecording:
    """The frames of one sequence folder; a frame's index is the number in its file's name.

    Attributes:
        indices: of the frames that there are files of, rising.

    Raises:
        InputError: no depth images, or the calibration cannot be read.
    """

    def __init__(self, path: Path, frames: int | None = None) -> None:
        """The frames whose numbers are below `frames`, all of them if None."""
        with naming(path, right="it must be a folder"):
            names = [file.name for file in path.iterdir()]
        matches = [match for name in names if (match := _DEPTH_FILE.fullmatch(name))]
        if not matches:
            raise InputError(
                f"{path}: has no depth images; it must hold kin_k01_s01_a01_r01_depth_00000.pgm ..."
            )
        sequences = {match[0].partition("_depth_")[0] for match in matches}
        if len(sequences) > 1:
            raise InputError(
                f"{path}: has images of {len(sequences)} sequences, "
                f"{', '.join(sorted(sequences)[:2])} ...; it must have those of one"
            )
        root = _root_of(path)
        paths = {int(match[5]): path / match[0] for match in matches}
        self.indices = sorted(n for n in paths if frames is None or n < frames)
        if not self.indices:
            raise InputError(f"{path}: has no frame below {frames}; it must have frame 0, 1, ...")
        self._depth_paths = {index: paths[index] for index in self.indices}
        kinect, subject, action, repetition = (int(matches[0][i]) for i in (1, 2, 3, 4))
        self.name = f"s{subject:02d}_a{action:02d}_r{repetition:02d}"
        self._notes = Notes()
        self.problems = self._notes.lines
        K = read_camera_matrix(root / "Calibration" / f"camcfg_k{kinect:02d}.yml")
        height, width = self._first_shape()
        self.camera = Camera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], width, height)

    @property
    def frame_count(self) -> int:
        """One more than the greatest frame number."""
        return self.indices[-1] + 1

    def __iter__(self) -> Iterator[Frame]:
        for index, path in self._depth_paths.items():
            try:
                depth_mm = self._read(path, np.dtype(np.uint16))
            except InputError as error:
                self._notes.add_alike("depth images cannot be read", str(error))
                continue
            depth_m = depth_image(depth_mm, METRES_PER_MILLIMETRE)
            yield Frame(index, index / FPS, depth_m, self.camera, self._color(path), path.name)

    def _color(self, depth_path: Path) -> NDArray[np.uint8] | None:
        path = depth_path.with_name(depth_path.name.replace("_depth_", "_color_"))
        path = path.with_suffix(".ppm")
        if not path.exists():
            return None
        try:
            return self._read(path, np.dtype(np.uint8), channels=(3,))
        except InputError as error:
            line = f"{error}; the frame comes without colour"
            self._notes.add_alike("frames come without colour", line)
            return None

    def _read(
        self, path: Path, dtype: np.dtype[np.generic], channels: tuple[int, ...] = ()
    ) -> NDArray:
        with naming(Path(path.name)):
            image = decode_netpbm(read_bytes(path))
            shape = (self.camera.height, self.camera.width, *channels)
            if image.shape != shape or image.dtype != dtype:
                raise InputError(f"is {image.dtype} {image.shape}; it must be {dtype} {shape}")
            return image

    def _first_shape(self) -> tuple[int, int]:
        """Height and width of the first depth image that can be read."""
        problems = []
        for path in self._depth_paths.values():
            try:
                with naming(path):
                    height, width = decode_netpbm(read_bytes(path)).shape[:2]
                    return height, width
            except InputError as error:
                problems.append(str(error))
        raise InputError(problems[0])


def _root_of(path: Path) -> Path:
    """The data set's folder, of that of a sequence."""
    above = path.resolve().parents
    if len(above) < SEQUENCE_DEPTH:
        raise InputError(
            f"{path}: is no sequence's folder; it must be Kinect/Kin01/S01/A01/R01 of a data set, "
            "as the camera's calibration lies in Calibration/ beside Kinect/"
        )
    return above[SEQUENCE_DEPTH - 1]


def read_camera_matrix(path: Path) -> NDArray[np.float64]:
    """[3, 3] K of a `camcfg_k01.yml`: OpenCV's YAML, with K under Camera_1.

    Raises:
        InputError: missing, or without a camera matrix.
    """
    right = "it must be OpenCV's YAML with a 3 x 3 matrix K under Camera_1"
    with naming(path, right=right):
        text = read_text(path, right=right)
        if (match := _CAMERA_MATRIX.search(text)) is None:
            raise InputError(f"has no camera matrix; {right}")
        try:
            return np.array(match[1].split(","), np.float64).reshape(3, 3)
        except ValueError as error:
            raise InputError(f"has a damaged camera matrix ({error}); {right}") from None


def read_world_pose(path: Path) -> NDArray[np.float64]:
    """[4, 4] T_camera_world in metres of a `RwTw_k01.txt`: two lines, nine numbers of a rotation
    row by row and three of a shift in millimetres, each line after its name and = or a colon.

    Raises:
        InputError: missing, or without a rotation and a shift.
    """
    right = "it must hold nine numbers of a rotation and three of a shift in mm"
    with naming(path, right=right):
        text = re.sub(r"(?m)^.*[=:]", "", read_text(path, right=right))
        try:
            numbers = np.array(re.split(r"[\s,;\[\]]+", text.strip(" \r\n\t;,[]")), np.float64)
        except ValueError as error:
            raise InputError(f"is damaged ({error}); {right}") from None
        if numbers.shape != (12,) or not np.isfinite(numbers).all():
            raise InputError(f"has {len(numbers)} numbers; {right}")
        T = np.eye(4)
        T[:3, :3] = numbers[:9].reshape(3, 3)
        T[:3, 3] = METRES_PER_MILLIMETRE * numbers[9:]
        R = T[:3, :3]
        with np.errstate(over="ignore", invalid="ignore"):
            off = np.abs(R @ R.T - np.eye(3)).max()
        if not off <= _ROTATION_ERROR or np.linalg.det(R) < 0.0:
            raise InputError("begins with nine numbers that are no rotation; they must be one")
        if not (np.abs(T[:3, 3]) <= MAX_PLACE_M).all():
            raise InputError(
                f"ends with {T[:3, 3]} m; it must be a shift of up to {MAX_PLACE_M:g} m"
            )
        return T
