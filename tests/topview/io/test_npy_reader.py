"""Depth as one NumPy array: every value comes back, and damage is one line."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import topview
from damage import cut, flipped
from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview import InputError

MM = np.random.default_rng(0).integers(0, 6000, (3, HEIGHT, WIDTH), np.uint16)


def write(folder: Path, array: Any, **camera: Any) -> Path:
    (folder / "camera.json").write_text(json.dumps(CAMERA | camera))
    np.save(folder / "depth.npy", array)
    return folder / "depth.npy"


@pytest.mark.parametrize(
    ("array", "camera"),
    [
        (MM, {}),
        (MM.astype(np.int32), {}),
        (MM, {"depth_scale": 0.001}),
        ((MM / 1e3).astype(np.float32), {}),
        (MM / 1e3, {}),
        (MM.astype(np.float32), {"depth_scale": 1000}),
        (MM.astype(np.float16), {"depth_scale": 1000}),
        (np.asfortranarray(MM), {}),
    ],
)
def test_every_value_comes_back(tmp_path, array, camera):
    recording = topview.open(write(tmp_path, array, **camera))
    assert recording.frame_count == 3
    for index, frame in enumerate(recording):
        assert (frame.index, frame.timestamp_s) == (index, index / 30.0)
        values = MM[index] if array.dtype != np.float16 else array[index].astype(np.float64)
        expected = (values / 1e3).astype(np.float32)
        np.testing.assert_allclose(frame.depth_m, expected, rtol=2.4e-7)  # two roundings


def test_a_single_image_is_one_frame(tmp_path):
    (frame,) = topview.open(write(tmp_path, MM[0]))
    assert frame.index == 0


def test_the_folder_may_be_given(tmp_path):
    write(tmp_path, MM)
    recording = topview.open(tmp_path)
    assert (recording.name, recording.frame_count) == (tmp_path.name, 3)


@pytest.mark.parametrize(
    ("array", "told"),
    [
        (MM[:, :-1], "images are 64 x 47 pixels; they must be 64 x 48, as camera.json says"),
        (np.zeros((2, 2, 2, 2)), r"is float64 \(2, 2, 2, 2\); it must be \[frames, height, width"),
        (np.array(["a"]), "is <U1"),
        (np.array([{}], object), "is truncated or damaged"),
        (np.zeros((0, HEIGHT, WIDTH)), "is float64"),
    ],
)
def test_what_is_no_depth_is_one_line(tmp_path, array, told):
    with pytest.raises(InputError, match=rf"depth\.npy: {told}"):
        topview.open(write(tmp_path, array))


def test_millimetres_as_floats_are_one_line_with_the_range(tmp_path):
    recording = topview.open(write(tmp_path, MM.astype(np.float32)))
    with pytest.raises(InputError, match=r"lie beyond 30 m, from 1 to 59\d\d m; .* millimetres"):
        list(recording)


def test_cut_or_spoiled_anywhere_it_is_an_array_or_one_line(tmp_path):
    path = write(tmp_path, MM)
    whole = path.read_bytes()
    for data in cut(whole):
        path.write_bytes(data)
        with pytest.raises(InputError):
            topview.open(path)
    for data in flipped(whole[:128], 60):
        path.write_bytes(data + whole[128:])
        with suppress(InputError):
            list(topview.open(path))


def test_without_camera_json_it_is_one_line(tmp_path):
    path = write(tmp_path, MM)
    (tmp_path / "camera.json").unlink()
    with pytest.raises(InputError, match=r"camera\.json: cannot be read"):
        topview.open(path)
