"""Depth in HDF5 files: every value comes back, and damage is one line."""

from __future__ import annotations

import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import topview
from damage import cut, flipped
from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview import InputError
from topview.io.readers.hdf5 import ITOP_CAMERA

h5py = pytest.importorskip("h5py", reason="needs the extra datasets")
MM = np.random.default_rng(0).integers(0, 6000, (3, HEIGHT, WIDTH), np.uint16)
METRES = (MM / 1e3).astype(np.float32)


def write(folder: Path, arrays: dict[str, Any], **camera: Any) -> Path:
    (folder / "camera.json").write_text(json.dumps(CAMERA | camera))
    path = folder / "walk.h5"
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file.create_dataset(name, data=array, compression="gzip" if array.size > 99 else None)
    return path


@pytest.mark.parametrize(
    "arrays",
    [
        {"frames": MM},
        {"a/b": METRES},
        {"camera/Depth": MM, "infrared": MM // 2, "time": np.arange(3.0), "K": np.eye(3)},
    ],
)
def test_the_one_array_that_may_be_depth_is_read(tmp_path, arrays):
    recording = topview.open(write(tmp_path, arrays, fps=10))
    assert recording.frame_count == 3
    for index, frame in enumerate(recording):
        assert (frame.index, frame.timestamp_s) == (index, index / 10.0)
        np.testing.assert_allclose(frame.depth_m, METRES[index], rtol=2.4e-7)  # two roundings


def test_a_single_image_is_one_frame(tmp_path):
    (frame,) = topview.open(write(tmp_path, {"depth": MM[0]}))
    np.testing.assert_allclose(frame.depth_m, METRES[0], rtol=2.4e-7)


def test_itop_needs_no_camera_json(tmp_path):
    path = write(tmp_path, {})
    (tmp_path / "camera.json").unlink()
    depth_m = np.full((2, 240, 320), 2.5, np.float16)
    with h5py.File(path, "w") as file:
        file["data"], file["id"] = depth_m, np.array([b"00_00000", b"01_00000"])
    recording = topview.open(path)
    assert recording.camera == ITOP_CAMERA
    assert "taken for ITOP" in recording.problems[0]
    np.testing.assert_array_equal([frame.depth_m for frame in recording], depth_m)


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"a": MM, "b": METRES}, 'arrays that may be depth are a, b; one must be, or have "depth"'),
        ({"depth": MM, "raw_depth": MM}, "are depth, raw_depth;"),
        ({"rgb": np.zeros((3, HEIGHT, WIDTH, 3), np.uint8), "x": np.zeros(9)}, "are none;"),
        ({"depth": MM[:, 1:]}, "images are 64 x 47 pixels; they must be 64 x 48, as camera.json"),
    ],
)
def test_what_is_no_depth_is_one_line(tmp_path, arrays, told):
    with pytest.raises(InputError, match=rf"walk\.h5: .*{told}"):
        topview.open(write(tmp_path, arrays))


def test_cut_or_spoiled_anywhere_it_is_one_line_or_what_can_be_read(tmp_path, capfd):
    path = write(tmp_path, {"depth": MM})
    whole = path.read_bytes()
    for data in (*cut(whole), *flipped(whole)):
        path.write_bytes(data)
        with suppress(InputError):
            recording = topview.open(path)
            frames = list(recording)
            assert len(frames) == 3 or recording.problems
    assert capfd.readouterr().err == ""


def test_a_chunk_of_gigabytes_is_refused(tmp_path):
    path = write(tmp_path, {})
    with h5py.File(path, "w") as file:
        file.create_dataset("depth", (2**17, HEIGHT, WIDTH), "f4", chunks=(2**17, HEIGHT, WIDTH))
    with pytest.raises(InputError, match=r"has chunks of \d+ bytes; they must have at most"):
        topview.open(path)


def test_without_h5py_one_line_says_what_to_install(tmp_path, monkeypatch):
    path = write(tmp_path, {"depth": MM})
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"walk\.h5: .*pip install 'topview\[datasets\]'"):
        topview.open(path)
