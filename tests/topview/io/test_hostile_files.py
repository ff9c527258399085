"""Files that would be waited for, never end, or claim more than there is: one line, at once."""

from __future__ import annotations

import os
import socket
import struct
import warnings
import zlib
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.io import savemat

import topview
from tiny_berkeley_mhad import write_calibration, write_sequence
from topview.files import MOST_BYTES, naming, read_bytes, read_text
from topview.io.readers.images import decode_color, jpeg_size
from topview.io.readers.matlab import read_variable
from topview.records import InputError

GIB = 2**30


@pytest.fixture(params=["pipe", "device", "socket", "folder"])
def no_file(request, tmp_path, monkeypatch) -> Path:
    """What lies where a file should."""
    if request.param == "device":
        return Path("/dev/zero")
    monkeypatch.chdir(tmp_path)  # a socket's path has at most a hundred characters
    path = tmp_path / "there"
    match request.param:
        case "pipe":
            os.mkfifo(path)
        case "socket":
            with socket.socket(socket.AF_UNIX) as made:
                made.bind("there")
        case _:
            path.mkdir()
    return path


def test_what_is_no_regular_file_is_one_line(no_file):
    for read in (read_bytes, read_text):
        with pytest.raises(InputError, match="is no regular file; it must be"), naming(no_file):
            read(no_file)


def test_a_camera_json_that_is_no_regular_file_is_refused(write_folder, no_file):
    root = write_folder()
    (root / "camera.json").unlink()
    (root / "camera.json").symlink_to(no_file)
    with pytest.raises(InputError, match=r"camera\.json: is no regular file"):
        topview.open(root)


@pytest.mark.parametrize("format", ["utd-mhad", "msr-action3d", "pcd"])
def test_a_recording_that_is_no_regular_file_is_refused(no_file, format):
    with pytest.raises(InputError, match="is no regular file; it must be"):
        topview.open(no_file, format)


def test_an_image_that_is_no_regular_file_costs_its_own_frame(write_folder, no_file):
    root = write_folder()
    (root / "depth" / "000004.png").symlink_to(no_file)
    (root / "rgb").mkdir()
    (root / "rgb" / "000000.jpg").symlink_to(no_file)
    recording = topview.open(root)
    assert [frame.index for frame in recording] == [0, 1, 2, 3]
    told = [problem for problem in recording.problems if "is no regular file" in problem]
    assert [problem.partition(":")[0] for problem in told] == [
        "rgb/000000.jpg",
        "depth/000004.png",
    ]


@pytest.mark.parametrize("name", ["x.mat", "x.pcd", "x_sdepth.bin"])
def test_a_file_of_a_million_gigabytes_is_refused_at_once(tmp_path, name):
    path = tmp_path / name
    path.touch()
    os.truncate(path, 2**43)
    with pytest.raises(InputError, match=f"has {2**43} bytes; it must have at most {MOST_BYTES}"):
        topview.open(path)


def test_an_image_and_a_camera_json_of_as_much_are_too(write_folder):
    root = write_folder()
    os.truncate(root / "depth" / "000001.png", 2**43)
    recording = topview.open(root)
    assert [frame.index for frame in recording] == [0, 2, 3]
    assert "000001.png: has 8796093022208 bytes" in recording.problems[0]
    os.truncate(root / "camera.json", 2**43)
    with pytest.raises(InputError, match=r"camera\.json: has 8796093022208 bytes"):
        topview.open(root)


def test_a_file_is_read_as_long_as_it_was(tmp_path):
    path = tmp_path / "text"
    path.write_bytes(b"\xfftext\r\n")
    assert read_bytes(path) == b"\xfftext\r\n"
    assert read_text(path).splitlines() == ["ÿtext"]
    assert read_bytes(path, 7) == b"\xfftext\r\n"
    with pytest.raises(InputError, match="has 7 bytes; it must have at most 6"):
        read_bytes(path, 6)
    with pytest.raises(InputError, match="is not text; it must be text"):
        read_text(path, "utf-8")


@pytest.mark.parametrize("depth", [500, 900, 2_000, 200_000])
@pytest.mark.parametrize("pair", ["[]", '{"a":}'])
@pytest.mark.parametrize("key", ["", "fx", "color", "distortion", "sensor", "T_world_camera", "x"])
def test_deeply_nested_text_is_one_line_or_not_looked_at(write_folder, depth, pair, key):
    root = write_folder()
    nested = pair[:-1] * depth + ("1" if pair[0] == "{" else "") + pair[-1] * depth
    whole = (root / "camera.json").read_text()
    text = whole[:-1] + f', "{key}": {nested}}}' if key else nested
    (root / "camera.json").write_text(text)
    if key == "x" and depth < 1000:  # nobody looks there
        with suppress(InputError):
            topview.open(root)
        return
    with pytest.raises(InputError, match=r"camera\.json") as error:
        topview.open(root)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600


def pcd(points: np.ndarray, kind: str = "<f8", **changed: object) -> bytes:
    """A binary cloud of [H, W, 3] points."""
    height, width = points.shape[:2]
    size = np.dtype(kind).itemsize
    entries = {
        "FIELDS": "x y z",
        "SIZE": f"{size} {size} {size}",
        "TYPE": "F F F",
        "COUNT": "1 1 1",
        "WIDTH": width,
        "HEIGHT": height,
        "DATA": "binary",
        **changed,
    }
    header = "".join(f"{key} {value}\n" for key, value in entries.items())
    return header.encode() + points.astype(kind).tobytes()


@pytest.fixture
def points() -> np.ndarray:
    rows, columns = np.mgrid[:15, :20]
    z = np.full((15, 20), 2.0)
    return np.stack([(columns - 9.5) / 20.0 * z, (rows - 7.0) / 20.0 * z, z], axis=-1)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("value", [1e300, -1e300, np.inf, -np.inf, np.nan, 1e30, 1e-300])
def test_a_point_where_no_camera_sees_one_is_no_reading(tmp_path, points, axis, value):
    points[3, 4, axis] = value
    (tmp_path / "x.pcd").write_bytes(pcd(points))
    (frame,) = topview.open(tmp_path / "x.pcd")
    is_reading = np.ones((15, 20), bool)
    is_reading[3, 4] = axis < 2 and abs(value) < 1.0
    np.testing.assert_array_equal(frame.depth_m > 0.0, is_reading)
    assert frame.camera.fx == pytest.approx(20.0, rel=2e-3)


@pytest.mark.parametrize("value", [1e300, -1e300, np.inf, np.nan, 1e-300])
def test_a_cloud_of_nothing_else_is_one_line(tmp_path, points, value):
    points[..., 2] = value
    (tmp_path / "x.pcd").write_bytes(pcd(points))
    with pytest.raises(InputError, match=r"x\.pcd: has 0 points with z above 0, up to 100 m"):
        topview.open(tmp_path / "x.pcd")


def lzf_zeros(size: int) -> bytes:
    """LZF of so many zeros, and a few more: runs of 264 bytes."""
    return b"\x00\x00" + b"\xe0\xff\x00" * (size // 264 + 1)


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"WIDTH": 16384, "HEIGHT": 16384}, "6442450944 bytes of points, by its header"),
        ({"WIDTH": 10**9, "HEIGHT": 10**9}, "a cloud of 1000000000 x 1000000000 points"),
        ({"WIDTH": "9" * 4000}, r"a cloud of 9+ \.\.\. x 15 points"),
        ({"WIDTH": "9" * 5000}, "has a damaged header"),
        ({"COUNT": f"1 1 {10**12}"}, "bytes of points, by its header"),
        ({"SIZE": "8 8 800"}, "has a damaged header"),
        ({"WIDTH": -20, "HEIGHT": -15}, "is an unorganized cloud"),
    ],
)
@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_a_header_that_asks_for_too_much_is_refused(tmp_path, points, changed, complaint, encoding):
    (tmp_path / "x.pcd").write_bytes(pcd(points, DATA=encoding, **changed))
    with pytest.raises(InputError, match=rf"x\.pcd: .*{complaint}"):
        topview.open(tmp_path / "x.pcd")


def test_a_number_that_32_bits_do_not_hold_is_no_reading(tmp_path, points):
    points[3, 4] = 1e300
    text = "\n".join(" ".join(map(str, point)) for point in points.reshape(-1, 3).tolist())
    header = pcd(points[:0], "<f4", DATA="ascii", WIDTH=20, HEIGHT=15)
    (tmp_path / "x.pcd").write_bytes(header + text.encode())
    with warnings.catch_warnings(action="error"):
        (frame,) = topview.open(tmp_path / "x.pcd")
    assert np.argwhere(frame.depth_m == 0.0).tolist() == [[3, 4]]


def test_a_small_cloud_that_says_that_it_unpacks_to_gigabytes_is_refused(tmp_path, points):
    packed = lzf_zeros(10_000_000)
    whole = pcd(points, DATA="binary_compressed")
    header = whole[: whole.index(b"compressed\n") + len(b"compressed\n")]
    (tmp_path / "x.pcd").write_bytes(header + struct.pack("<II", len(packed), 2**32 - 1) + packed)
    with pytest.raises(InputError, match="unpacks to 4294967295 bytes, as it says"):
        topview.open(tmp_path / "x.pcd")


def test_a_small_cloud_that_unpacks_to_more_than_it_says_is_refused(tmp_path, points):
    packed = lzf_zeros(10_000_000)
    sizes = struct.pack("<II", len(packed), 15 * 20 * 24)
    whole = pcd(points, DATA="binary_compressed")
    header = whole[: whole.index(b"compressed\n") + len(b"compressed\n")]
    (tmp_path / "x.pcd").write_bytes(header + sizes + packed)
    with pytest.raises(InputError, match="is damaged: it decompresses to"):
        topview.open(tmp_path / "x.pcd")


def mat_element(kind: int, content: bytes) -> bytes:
    return struct.pack("<II", kind, len(content)) + content


def packed_mat(path: Path, *streams: bytes) -> Path:
    """A `.mat` file of these deflated elements."""
    header = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    path.write_bytes(header + b"".join(mat_element(15, stream) for stream in streams))
    return path


def deflated_zeros(prefix: bytes, size: int) -> bytes:
    """A prefix and so many zeros, without ever holding them all."""
    deflate, block = zlib.compressobj(9), bytes(2**20)
    parts = [deflate.compress(prefix)]
    parts += [deflate.compress(block) for _ in range(size // len(block))]
    return b"".join([*parts, deflate.flush()])


def test_a_mat_that_unpacks_to_a_gigabyte_is_refused(tmp_path):
    stream = deflated_zeros(struct.pack("<II", 14, GIB), GIB)
    path = packed_mat(tmp_path / "x.mat", stream)
    assert path.stat().st_size < 2**21
    with pytest.raises(InputError, match=f"unpacks to more than {MOST_BYTES} bytes"):
        topview.open(path)


def test_a_mat_whose_element_unpacks_to_more_than_it_says_is_refused(tmp_path):
    stream = deflated_zeros(struct.pack("<II", 14, 800), 2**26)
    with pytest.raises(InputError, match=r"truncated or damaged .*than the 800 bytes that it says"):
        topview.open(packed_mat(tmp_path / "x.mat", stream))


def test_many_elements_are_bounded_together(tmp_path, monkeypatch):
    monkeypatch.setattr("topview.io.readers.matlab.MOST_BYTES", 2**20)
    stream = zlib.compress(struct.pack("<II", 14, 3 * 2**18) + bytes(3 * 2**18))
    path = packed_mat(tmp_path / "x.mat", stream, stream)
    with pytest.raises(InputError, match="unpacks to more than 1048576 bytes"):
        topview.open(path)


@pytest.mark.parametrize("shape", [(240, 320, 2**31 - 1), (2**31 - 1,) * 3, (240, 320, -1)])
def test_a_mat_that_claims_more_numbers_than_it_has_is_refused(tmp_path, shape):
    path = tmp_path / "x.mat"
    savemat(path, {"d_depth": np.ones((240, 320, 2), np.uint16)})
    data = path.read_bytes().replace(struct.pack("<3i", 240, 320, 2), struct.pack("<3i", *shape))
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"x\.mat: ") as error:
        topview.open(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("packed", [False, True])
def test_a_whole_mat_is_read_packed_or_not(tmp_path, packed):
    d_depth = np.random.default_rng(0).integers(0, 4000, (240, 320, 2)).astype(np.uint16)
    other = {"note": "text", "many": np.array([{}, 1], object)}
    savemat(tmp_path / "x.mat", {**other, "d_depth": d_depth}, do_compression=packed)
    read = read_variable(tmp_path / "x.mat", "d_depth", (240, 320, None), "a *_depth.mat")
    np.testing.assert_array_equal(read, d_depth)


def test_an_mhad_sequence_outside_of_the_data_set_is_one_line(tmp_path, monkeypatch):
    folder = write_sequence(tmp_path, "s01_a01_r01", [0])
    write_calibration(tmp_path)
    assert len(list(topview.open(folder))) == 1
    for depth in range(6):
        above = Path("/", *"abcde"[:depth])
        monkeypatch.setattr(Path, "resolve", lambda path, above=above: above)
        with pytest.raises(InputError, match=r"camcfg_k01|be Kinect/Kin01") as e:
            topview.open(folder)
        assert "\n" not in str(e.value)


def test_an_mhad_folder_of_two_sequences_is_refused(tmp_path):
    folder = write_sequence(tmp_path, "s01_a01_r01", [0, 1])
    write_calibration(tmp_path)
    (image, _) = sorted(folder.glob("*.pgm"))
    image.rename(image.with_name("kin_k01_s02_a01_r01_depth_00000.pgm"))
    with pytest.raises(InputError, match=r"has images of 2 sequences, .*; it must have those"):
        topview.open(folder)


def test_an_mhad_image_that_is_no_regular_file_costs_its_own_frame(tmp_path, no_file):
    folder = write_sequence(tmp_path, "s01_a01_r01", [0, 1])
    write_calibration(tmp_path)
    (folder / "kin_k01_s01_a01_r01_depth_00002.pgm").symlink_to(no_file)
    recording = topview.open(folder)
    assert [frame.index for frame in recording] == [0, 1]
    assert "is no regular file" in recording.problems[0]
    (tmp_path / "Calibration" / "camcfg_k01.yml").unlink()
    (tmp_path / "Calibration" / "camcfg_k01.yml").symlink_to(no_file)
    with pytest.raises(InputError, match=r"camcfg_k01\.yml: is no regular file"):
        topview.open(folder)


def encoded(suffix: str, *parameters: int) -> bytes:
    return cv2.imencode(suffix, np.zeros((48, 64, 3), np.uint8), parameters)[1].tobytes()


def test_the_size_of_a_jpeg_is_read_before_it_is_decoded():
    plain = encoded(".jpg")
    assert jpeg_size(plain) == (64, 48)
    assert jpeg_size(encoded(".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, 1)) == (64, 48)
    assert jpeg_size(plain[:2] + b"\xff\xff\xff" + plain[3:]) == (64, 48)  # filled
    for length in range(len(plain)):
        assert jpeg_size(plain[:length]) in ((64, 48), (0, 0))


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_a_small_colour_image_that_claims_gigabytes_is_not_decoded(suffix):
    data = bytearray(encoded(suffix))
    if suffix == ".jpg":
        at = data.index(b"\xff\xc0") + 5
        data[at : at + 4] = struct.pack(">HH", 30_000, 30_000)
    else:
        data[16:24] = struct.pack(">II", 30_000, 30_000)
        data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    with pytest.raises(InputError, match=r"is 30000 x 30000 pixels; it must have at most 33554432"):
        decode_color(bytes(data))
