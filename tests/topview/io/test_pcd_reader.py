"""Organized clouds: the picture that was unprojected comes back, with its camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import topview
from topview import Camera, InputError
from topview.camera.projection import unproject_depth
from topview.io.readers.lzf import lzf_decompress

CAMERA = Camera(fx=30.0, fy=31.0, cx=9.25, cy=6.5, width=20, height=15)
FIELDS = "x y z rgba"


def lzf_compress(data: bytes) -> bytes:
    """Greedy LZF: the nearest earlier match of 3 to 264 bytes, else literals."""
    out, literals, i = bytearray(), bytearray(), 0

    def flush() -> None:
        for start in range(0, len(literals), 32):
            run = literals[start : start + 32]
            out.extend([len(run) - 1, *run])
        literals.clear()

    while i < len(data):
        start = data.rfind(data[i : i + 3], max(0, i - 8192), i + 2) if i + 3 <= len(data) else -1
        if start < 0:
            literals.append(data[i])
            i += 1
            continue
        flush()
        length = 3
        while length < 264 and i + length < len(data) and data[start + length] == data[i + length]:
            length += 1
        back, stored = i - start - 1, length - 2
        head = [stored << 5 | back >> 8] if stored < 7 else [7 << 5 | back >> 8, stored - 7]
        out.extend([*head, back & 255])
        i += length
    flush()
    return bytes(out)


@given(
    st.lists(st.tuples(st.binary(max_size=40), st.integers(1, 60))).map(
        lambda runs: b"".join(text * times for text, times in runs)
    )
)
def test_lzf_gives_back_what_was_compressed(data):
    assert lzf_decompress(lzf_compress(data), len(data)) == data


@given(st.binary(max_size=200), st.integers(0, 400))
def test_lzf_refuses_or_answers_but_never_breaks(data, size):
    try:
        answer = lzf_decompress(data, size)
    except InputError:
        return
    assert len(answer) == size


@pytest.fixture
def depth_m() -> np.ndarray:
    depth_m = np.random.default_rng(3).uniform(0.5, 4.0, (15, 20)).astype(np.float32)
    depth_m[2, 3:6] = 0.0
    return depth_m


@pytest.fixture
def points(depth_m) -> np.ndarray:
    """[H, W, 3], NaN where there is no reading, as PCL writes it."""
    points = unproject_depth(depth_m, CAMERA)
    points[depth_m == 0.0] = np.nan
    return points


@pytest.fixture
def color() -> np.ndarray:
    return np.random.default_rng(4).integers(0, 256, (15, 20, 3)).astype(np.uint8)


def header(encoding: str, points: np.ndarray, fields: str, kinds: str, **changed: str) -> bytes:
    height, width = points.shape[:2]
    count = len(fields.split())
    entries = {
        "VERSION": "0.7",
        "FIELDS": fields,
        "SIZE": " ".join(["4"] * count),
        "TYPE": kinds,
        "COUNT": " ".join(["1"] * count),
        "WIDTH": str(width),
        "HEIGHT": str(height),
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": str(width * height),
        "DATA": encoding,
        **changed,
    }
    lines = "\n".join(f"{key} {value}" for key, value in entries.items() if value)
    return f"# .PCD v0.7 - Point Cloud Data file format\n{lines}\n".encode()


def write_pcd(
    path: Path,
    points: np.ndarray,
    color: np.ndarray | None = None,
    encoding: str = "binary",
    **changed: str,
) -> Path:
    columns = [points[..., axis].ravel().astype("<f4") for axis in range(3)]
    fields, kinds = "x y z", "F F F"
    if color is not None:
        r, g, b = color.reshape(-1, 3).T.astype("<u4")
        columns.append(255 << 24 | r << 16 | g << 8 | b)
        fields, kinds = "x y z rgba", "F F F U"
    match encoding:
        case "ascii":
            rows = zip(*(column.tolist() for column in columns), strict=True)
            body = "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode()
        case "binary":
            body = np.stack([column.view("<u4") for column in columns], axis=-1).tobytes()
        case _:
            plain = b"".join(column.tobytes() for column in columns)
            packed = lzf_compress(plain)
            body = len(packed).to_bytes(4, "little") + len(plain).to_bytes(4, "little") + packed
    path.write_bytes(header(encoding, points, fields, kinds, **changed) + body)
    return path


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_the_picture_and_its_camera_come_back(tmp_path, points, depth_m, color, encoding):
    recording = topview.open(write_pcd(tmp_path / "room.pcd", points, color, encoding))
    for _ in range(2):
        (frame,) = recording
        assert (frame.index, frame.timestamp_s) == (0, 0.0)
        np.testing.assert_array_equal(frame.depth_m, depth_m)
        np.testing.assert_array_equal(frame.color, color)
    found, true = recording.camera, CAMERA
    assert (found.width, found.height) == (true.width, true.height)
    np.testing.assert_allclose(
        (found.fx, found.fy, found.cx, found.cy), (true.fx, true.fy, true.cx, true.cy), rtol=1e-4
    )
    assert (recording.name, recording.frame_count, recording.problems) == ("room", 1, [])


def test_color_is_optional(tmp_path, points, depth_m):
    (frame,) = topview.open(write_pcd(tmp_path / "room.pcd", points))
    np.testing.assert_array_equal(frame.depth_m, depth_m)
    assert frame.color is None


def test_color_packed_into_a_float_and_padding_are_understood(tmp_path, points, depth_m, color):
    r, g, b = color.reshape(-1, 3).T.astype("<u4")
    rows = np.zeros(
        points[..., 0].size, [("pad", "<u4"), ("p", "<f4", 3), ("c", "<u4"), ("q", "<u4", 2)]
    )
    rows["p"], rows["c"] = points.reshape(-1, 3), r << 16 | g << 8 | b
    layout = header("binary", points, "_ x y z rgb _", "U F F F F U", COUNT="1 1 1 1 1 2")
    (tmp_path / "room.pcd").write_bytes(layout + rows.tobytes())
    (frame,) = topview.open(tmp_path / "room.pcd")
    np.testing.assert_array_equal(frame.depth_m, depth_m)
    np.testing.assert_array_equal(frame.color, color)


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_a_cloud_cut_anywhere_is_refused_in_one_line(tmp_path, points, color, encoding):
    path = write_pcd(tmp_path / "room.pcd", points, color, encoding)
    whole = path.read_bytes()
    for length in [*range(0, 300, 11), len(whole) // 2, len(whole) - 20]:
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"room\.pcd: ") as error:
            topview.open(path)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"WIDTH": "300", "HEIGHT": "1"}, "is an unorganized cloud, 300 x 1 points"),
        ({"HEIGHT": "16"}, "is truncated: it holds 3600 bytes of points; .*must have 3840"),
        ({"FIELDS": "x y intensity"}, r"has no fields z of type F \(it has x y intensity\)"),
        ({"TYPE": "F F U"}, "has no fields z of type F"),
        ({"WIDTH": "many"}, "has a damaged header"),
        ({"SIZE": "4 4"}, "has a damaged header"),
        ({"COUNT": "1 1 0"}, "has a damaged header"),
        ({"TYPE": "F F Q"}, "has a damaged header"),
        ({"SIZE": ""}, "has no SIZE in its header"),
        ({"DATA": "zipped"}, "has DATA zipped; it must be ascii, binary or binary_compressed"),
    ],
)
def test_a_header_of_no_organized_cloud_is_refused(tmp_path, points, changed, message):
    path = write_pcd(tmp_path / "room.pcd", points, **changed)
    with pytest.raises(InputError, match=rf"room\.pcd: {message}"):
        topview.open(path)


def scattered(points: np.ndarray) -> np.ndarray:
    return points + np.random.default_rng(6).normal(scale=0.2, size=points.shape)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda points: points * [1, -1, 1], "both must be positive"),
        (lambda points: points * [-1, 1, 1], "both must be positive"),
        (lambda points: points * [1, -1, -1], "has 0 points with z above 0, up to 100 m"),
        (lambda points: points * np.nan, "has 0 points with z above 0, up to 100 m"),
        (scattered, "is no pinhole image: points lie .* px from their pixels"),
    ],
    ids=["y up", "mirrored", "z backward", "no points", "scattered"],
)
def test_points_that_are_no_picture_are_refused(tmp_path, points, spoil, message):
    with pytest.raises(InputError, match=rf"room\.pcd: .*{message}"):
        topview.open(write_pcd(tmp_path / "room.pcd", spoil(points)))


def test_the_real_cloud_is_its_depth_and_color_image(recordings):
    data = recordings / "five_people"
    (cloud,), (image,) = topview.open(data / "five_people.pcd"), topview.open(data)
    np.testing.assert_allclose(cloud.depth_m, image.depth_m, atol=2e-6)
    np.testing.assert_array_equal(cloud.color, image.color)
    for name in ("fx", "fy", "cx", "cy", "width", "height"):
        assert getattr(cloud.camera, name) == pytest.approx(getattr(image.camera, name), abs=1e-3)
