"""Depth as TIFF or OpenEXR: every value comes back, and damage is one line."""

from __future__ import annotations

import re
from contextlib import suppress

import cv2
import numpy as np
import pytest

import topview
from damage import cut, flipped
from topview import InputError
from topview.io.readers.float_images import decode_depth


@pytest.fixture
def metres(depths) -> np.ndarray:
    image = (depths[1] / 1e3).astype(np.float32)
    image[0, :3] = np.nan, np.inf, -1.0
    return image


def tiff_folder(write_folder, image: np.ndarray, **camera):
    root = write_folder({}, **camera)
    cv2.imwrite(str(root / "depth" / "000000.tiff"), image)
    return root


@pytest.mark.parametrize(("scale", "unit_m"), [(1, 1.0), (0.001, 0.001), (1000, 0.001)])
def test_floats_are_metres_unless_camera_json_says_otherwise(write_folder, metres, scale, unit_m):
    stored = metres / np.float32(unit_m)
    (frame,) = topview.open(tiff_folder(write_folder, stored, depth_scale=scale))
    is_reading = np.isfinite(metres) & (metres > 0.0)
    expected = np.where(is_reading, stored * unit_m, 0.0).astype(np.float32)
    np.testing.assert_array_equal(frame.depth_m, expected)


def test_16_bits_are_stored_units(write_folder, depths):
    (frame,) = topview.open(tiff_folder(write_folder, depths[1], depth_scale=1000))
    np.testing.assert_array_equal(frame.depth_m, (depths[1] / 1e3).astype(np.float32))


def test_16_bits_without_a_unit_are_named(write_folder, depths):
    recording = topview.open(tiff_folder(write_folder, depths[1], depth_scale=1))
    assert list(recording) == []
    (problem,) = recording.problems
    assert re.fullmatch(r"depth/000000\.tiff: is 16-bit depth; .*depth_scale: 0\.001 .*", problem)


def test_millimetres_taken_for_metres_are_one_line_with_the_range(write_folder):
    stored = np.linspace(1500, 4000, 48, dtype=np.float32).reshape(6, 8)
    recording = topview.open(tiff_folder(write_folder, stored, depth_scale=1))
    told = r"camera\.json: depth_scale is 1 m per unit; .*1500 to 4000 m.*millimetres"
    with pytest.raises(InputError, match=told):
        list(recording)


@pytest.mark.parametrize("suffix", [".tiff", ".png"])
def test_cut_or_spoiled_anywhere_it_is_an_image_or_one_line(suffix, depths, metres, capfd):
    image = metres if suffix == ".tiff" else depths[1]
    whole = cv2.imencode(suffix, image)[1].tobytes()
    for data in cut(whole):
        with pytest.raises(InputError):
            decode_depth(data, 8, 6)
    for data in flipped(whole, 40):
        with suppress(InputError):
            assert decode_depth(data, 8, 6).shape == (6, 8)
    assert capfd.readouterr().err == ""


def test_a_tiff_that_claims_gigabytes_is_not_decoded(metres):
    data = cv2.imencode(".tiff", metres)[1].tobytes()
    start = int.from_bytes(data[4:8], "little")
    at = next(k for k in range(start + 2, len(data)) if data[k : k + 4] == b"\0\1\3\0")
    huge = data[: at + 2] + b"\4\0" + data[at + 4 : at + 8] + b"\0\0\0\x7f" + data[at + 12 :]
    with pytest.raises(InputError, match="pixels; it must have at most 33554432"):
        decode_depth(huge, 8, 6)


def test_an_exr_is_read_where_opencv_reads_it(metres):
    header = b"\x76\x2f\x31\x01" + b"dataWindow\0box2i\0\x10\0\0\0"
    sides = np.array([0, 0, 7, 5], "<i4").tobytes()
    with pytest.raises(InputError, match="whole OpenEXR image"):
        decode_depth(header + sides, 8, 6)
    with pytest.raises(InputError, match="is 8 x 6 pixels; it must be 9 x 6"):
        decode_depth(header + sides, 9, 6)
