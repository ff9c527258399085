"""Whatever a file holds, it gives a record or one line."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays, scalar_dtypes

import topview
from skeleton_sequences import people_standing, predicted_of, reference_of, rendered_groundtruth
from topview.camera import undistorted_camera
from topview.files import naming
from topview.io import read_utd_skeleton, write_skeletons_npz
from topview.io.readers.camera_json import read_camera_json
from topview.io.readers.images import decode_color, decode_depth_png
from topview.io.readers.netpbm import decode_netpbm
from topview.records import InputError
from topview_lab.datasets import read_groundtruth
from topview_lab.datasets.bvh import read_bvh
from topview_lab.evaluate.predictions import read_predictions


def record_or_line(read: Callable[[], Any]) -> Any:
    """What is read; None where an error of one line was raised, and nothing was warned of."""
    with warnings.catch_warnings(action="error"):
        try:
            return read()
        except InputError as error:
            line = str(error)
    assert line
    assert line.isprintable()
    return None


NUMBERS = st.integers() | st.floats() | st.sampled_from([10**400, -(10**400), 1e-300, 5e-324])
JSON = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(),
    lambda inside: st.lists(inside, max_size=5) | st.dictionaries(st.text(), inside, max_size=5),
    max_leaves=30,
)
CAMERA: dict[str, Any] = {
    "fx": 9.0,
    "fy": 9.5,
    "cx": 3.5,
    "cy": 2.5,
    "width": 8,
    "height": 6,
    "depth_scale": 0.001,
}
COLOR = {**CAMERA, "T_color_depth": np.eye(4).tolist()}
KEYS = [*CAMERA, "fps", "sensor", "distortion", "T_world_camera", "color", "T_color_depth"]
CHANGED = st.dictionaries(st.sampled_from(KEYS) | st.text(), JSON | NUMBERS, max_size=4)


@given(JSON)
def test_any_json_is_a_camera_or_one_line(tmp_path_factory, value):
    check_camera(tmp_path_factory, value)


@given(CHANGED, CHANGED, st.sampled_from(KEYS))
def test_any_values_of_its_keys_are(tmp_path_factory, changed, of_color, dropped):
    values = {**CAMERA, "color": {**COLOR, **of_color}, **changed}
    check_camera(tmp_path_factory, values)
    values.pop(dropped, None)
    check_camera(tmp_path_factory, values)


@given(
    st.sampled_from(["brown_conrady", "rational", "inverse_brown_conrady", "none", "x"]),
    st.lists(st.floats(-10.0, 10.0) | NUMBERS, max_size=9),
)
def test_any_lens_is(tmp_path_factory, model, coefficients):
    lens = {"model": model, "coefficients": coefficients}
    check_camera(tmp_path_factory, {**CAMERA, "distortion": lens})


def check_camera(tmp_path_factory: pytest.TempPathFactory, value: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "camera.json"
    path.write_text(json.dumps(value))
    file = record_or_line(lambda: read_camera_json(path))
    if file is not None:
        camera = file.camera
        assert np.isfinite([camera.fx, camera.fy, camera.cx, camera.cy, file.fps]).all()
        assert camera.width * camera.height > 0
        record_or_line(lambda: undistorted_camera(camera))


ANY_ARRAY = scalar_dtypes().flatmap(
    lambda dtype: arrays(dtype, st.lists(st.integers(0, 3), max_size=5).map(tuple))
)
LIKE_IT = st.sampled_from(
    ["f4", "f8", "i8", "u1", "?", "U3", "S3", "c16", "f2", "M8[s]"]
)  # fmt: skip


def changed_arrays(whole: Mapping[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Some of the arrays are others: any at all, or of the same shape."""

    def other(key: str) -> st.SearchStrategy[Any]:
        shape = np.shape(whole[key])
        return ANY_ARRAY | LIKE_IT.flatmap(lambda dtype: arrays(dtype, shape))

    some = st.lists(st.sampled_from(sorted(whole)), unique=True, max_size=3)
    chosen = some.flatmap(lambda keys: st.fixed_dictionaries({key: other(key) for key in keys}))
    dropped = st.lists(st.sampled_from(sorted(whole)), max_size=1)
    return st.builds(
        lambda new, gone: {k: v for k, v in {**whole, **new}.items() if k not in gone},
        chosen,
        dropped,
    )


TRUTH = rendered_groundtruth(
    [2.5, 2.6],
    ids=np.array([3]),
    actions=np.array([["a"], ["b"]]),
    bodies=np.array(["c"]),
    part_names=np.array(["head", "torso"]),
    Ts_camera_part=np.tile(np.eye(4), (2, 1, 2, 1, 1)),
)
COMPOSITE = {
    "joint_names": TRUTH["names"],
    "joints": np.swapaxes(TRUTH["joints"], 0, 1),
    "joint_not_behind_other": np.ones((1, 2, len(TRUTH["names"])), bool),
}


@given(changed_arrays(TRUTH) | changed_arrays(COMPOSITE))
def test_any_arrays_of_truth_are_truth_or_one_line(tmp_path_factory, changed):
    path = tmp_path_factory.getbasetemp() / "truth.npz"
    np.savez(path, allow_pickle=False, **changed)
    reference = record_or_line(lambda: read_groundtruth(path))
    if reference is not None:
        assert np.isfinite(reference.joints_camera[reference.present]).all()


@cache
def predictions() -> dict[str, Any]:
    """The arrays of a file that `topview track` writes."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "skeletons.npz"
        write_skeletons_npz(predicted_of(people_standing(2, 0.0)), path)
        with np.load(path) as whole:
            return dict(whole)


@given(st.deferred(lambda: changed_arrays(predictions())))
def test_any_arrays_of_predictions_are_skeletons_or_one_line(tmp_path_factory, changed):
    path = tmp_path_factory.getbasetemp() / "predicted.npz"
    np.savez(path, allow_pickle=False, **changed)
    reference = reference_of(people_standing(2, 0.0))
    record_or_line(lambda: read_predictions(path, reference))


def named(read: Callable[[bytes], Any]) -> Callable[[Path], Any]:
    """A decoder of bytes as a reader of a file."""

    def of_file(path: Path) -> Any:
        with naming(path):
            return read(path.read_bytes())

    return of_file


READERS: dict[str, Callable[[Path], Any]] = {
    "x.pcd": topview.open,
    "x.mat": topview.open,
    "x_sdepth.bin": topview.open,
    "x_skeleton.mat": read_utd_skeleton,
    "camera.json": read_camera_json,
    "truth.npz": read_groundtruth,
    "x.bvh": read_bvh,
    "x.png": named(lambda data: decode_depth_png(data, 8, 6)),
    "x.jpg": named(decode_color),
    "x.pgm": named(decode_netpbm),
}
BEGINNINGS = {
    "x.pcd": b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 8\nHEIGHT 6\nDATA ",
    "x.mat": b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\x0f\x00\x00\x00",
    "x_skeleton.mat": b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\x0e\x00\x00\x00",
    "x_sdepth.bin": b"\x01\x00\x00\x00\x08\x00\x00\x00\x06\x00\x00\x00",
    "camera.json": b'{"fx": ',
    "truth.npz": b"PK\x03\x04",
    "x.bvh": b"HIERARCHY ROOT Hips { OFFSET ",
    "x.png": b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR",
    "x.jpg": b"\xff\xd8\xff\xe0\x00\x10JFIF\x00",
    "x.pgm": b"P5\n8 6\n65535\n",
}


@pytest.mark.parametrize("name", READERS)
@given(st.binary(max_size=400), st.booleans())
def test_any_bytes_are_read_or_one_line(tmp_path_factory, name, data, begins_right):
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(BEGINNINGS[name] + data if begins_right else data)
    record_or_line(lambda: READERS[name](path))
