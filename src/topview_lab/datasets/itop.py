"""ITOP, side view: 20 people, one Asus Xtion Pro, 15 joints a frame, in HDF5 files.

A. Haque, B. Peng, Z. Luo, A. Alahi, S. Yeung and L. Fei-Fei, "Towards viewpoint invariant 3D human
pose estimation", ECCV 2016. `ITOP_side_test_depth_map.h5` holds `id` [N] (`00_00001`: person and
frame) and `data` [N, 240, 320] float16 metres; `ITOP_side_test_labels.h5` holds `id`, `is_valid`
[N], `visible_joints` [N, 15] and `real_world_coordinates` [N, 15, 3] metres, y up. The authors'
projection is column = x / (z C) + 160, row = 120 - y / (z C), C = 3.50666662e-3.

Decided by us: each person is one recording of 30 frames a second, up to its last valid frame; a
joint that is not visible is hidden by the own body, as people are alone; a foot is our ankle; left
and right as if facing the camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming
from topview.io.readers.depth import depth_image
from topview.io.readers.hdf5 import ITOP_CAMERA, open_hdf5
from topview.io.readers.notes import Notes
from topview.records import Frame, InputError
from topview_lab.datasets.base import select_by_name
from topview_lab.datasets.joints import facing_sides
from topview_lab.metrics import ReferenceSequence

ITOP_FPS: Final = 30.0
ITOP_JOINTS: Final = (
    "head", "neck", "right_shoulder", "left_shoulder", "right_elbow", "left_elbow", "right_hand",
    "left_hand", "torso", "right_hip", "left_hip", "right_knee", "left_knee", "right_ankle",
    "left_ankle",
)  # fmt: skip
_RIGHT: Final = "it must be an HDF5 file of ITOP"


@dataclass(frozen=True, slots=True)
class ItopSequence:
    """One person of one split.

    Attributes:
        root: folder of the files.
        split: train or test.
        person: such as `00`.
    """

    root: Path
    split: str
    person: str

    @property
    def name(self) -> str:
        return f"{self.split}_{self.person}"

    def open(self) -> ItopRecording:
        rows, is_valid = self._rows()
        last = np.flatnonzero(is_valid)[-1] if is_valid.any() else -1
        return ItopRecording(_file(self.root, self.split, "depth_map"), self.name, rows[: last + 1])

    def reference(self) -> ReferenceSequence:
        """The joints of the valid frames."""
        path = _file(self.root, self.split, "labels")
        rows, is_valid = self._rows()
        with _opened(path) as file:
            joints = _read(file, "real_world_coordinates", (len(ITOP_JOINTS), 3))[rows[is_valid]]
            visible = _read(file, "visible_joints", (len(ITOP_JOINTS),))[rows[is_valid]]
        joints_camera = joints.astype(np.float64) * (1.0, -1.0, 1.0)
        F = len(joints)
        return ReferenceSequence(
            frame_index=np.flatnonzero(is_valid),
            person_ids=np.array([1]),
            joint_names=facing_sides(ITOP_JOINTS, joints_camera),
            joints_camera=joints_camera[:, None],
            present=np.ones((F, 1), bool),
            occluded_by_self=(visible[:, None] == 0).astype(np.float64),
            bodies=(f"person {self.person}",),
        )

    def _rows(self) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Rows of this person in the files, in the order of its frames, and which are valid."""
        with _opened(_file(self.root, self.split, "labels")) as file:
            ids = _ids(file)
            is_valid = _read(file, "is_valid", ()) != 0
        rows = np.array([n for n, name in enumerate(ids) if name.partition("_")[0] == self.person])
        rows = rows[np.argsort([ids[n] for n in rows], kind="stable")]
        return rows, is_valid[rows]


class ItopRecording:
    """Rows of an `ITOP_side_*_depth_map.h5` as frames 0, 1, ..."""

    def __init__(self, path: Path, name: str, rows: NDArray[np.int64]) -> None:
        self.name = name
        self.camera = ITOP_CAMERA
        self._notes = Notes()
        self.problems = self._notes.lines
        self._path = path
        self._rows = rows
        if not len(rows):
            raise InputError(f"{path}: has no valid frame of {name}; it must have one")
        with _opened(path) as file:
            _array(file, "data", (ITOP_CAMERA.height, ITOP_CAMERA.width))

    @property
    def frame_count(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[Frame]:
        with _opened(self._path) as file:
            data = _array(file, "data", (ITOP_CAMERA.height, ITOP_CAMERA.width))
            for index, row in enumerate(self._rows):
                try:
                    depth_m = depth_image(data[row].astype(np.float32), 1.0)
                except (OSError, IndexError, ValueError) as error:
                    line = f"{self._path}: row {row} cannot be read ({error})"
                    self._notes.add_alike("rows cannot be read", line)
                    continue
                yield Frame(index, index / ITOP_FPS, depth_m, ITOP_CAMERA)


def find_itop(root: Path, split: str = "test", pattern: str = "*") -> list[ItopSequence]:
    """The people of a split, train or test, whose names (`test_00`) match `pattern`.

    Raises:
        InputError: h5py is not installed, files are missing or damaged, or nothing matches.
    """
    if split not in ("train", "test"):
        raise InputError(f"split is {split!r}; it must be train or test")
    files = [_file(root, split, kind) for kind in ("depth_map", "labels")]
    if missing := [file.name for file in files if not file.is_file()]:
        is_top = any(root.glob("ITOP_top_*.h5"))
        hint = (
            "the top view is not for this tracker, whose camera is about as high as a person"
            if is_top
            else "they must be ITOP's files, unpacked"
        )
        raise InputError(f"{root} lacks {' and '.join(missing)}; {hint}")
    with _opened(files[1]) as labels:
        people = sorted({name.partition("_")[0] for name in _ids(labels)})
    return select_by_name([ItopSequence(root, split, p) for p in people], pattern, str(root))


def _file(root: Path, split: str, kind: str) -> Path:
    return root / f"ITOP_side_{split}_{kind}.h5"


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """An HDF5 file; errors name it."""
    with naming(path, right=_RIGHT):
        if not path.exists():
            raise InputError(f"is not there; {_RIGHT}")
        with open_hdf5(path, _RIGHT) as file:
            yield file


def _array(file: Any, key: str, shape: tuple[int, ...]) -> Any:
    """A data set of [N, *shape], not read yet."""
    if key not in file:
        raise InputError(f"has no {key} (it has {', '.join(file) or 'nothing'}); {_RIGHT}")
    if file[key].shape[1:] != shape:
        raise InputError(f"{key} has shape {file[key].shape}; it must be {('N', *shape)}")
    return file[key]


def _read(file: Any, key: str, shape: tuple[int, ...]) -> NDArray[Any]:
    return np.asarray(_array(file, key, shape)[:])


def _ids(file: Any) -> list[str]:
    names = [n.decode() if isinstance(n, bytes) else str(n) for n in _read(file, "id", ())]
    if wrong := [name for name in names if "_" not in name]:
        raise InputError(f"has the id {wrong[0]!r}; ids must be like 00_00001")
    return names
