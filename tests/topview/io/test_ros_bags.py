"""ROS bags: every value comes back from what rosbags wrote, and damage is one line."""

from __future__ import annotations

import struct
import sys
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest

import topview
from damage import cut, flipped
from tiny_bags import HEIGHT, KINDS, WIDTH, BagWriter, depth_mm, shade
from topview import InputError
from topview.io.readers.ros_places import extrinsic_of

START_S = 1_305_031_102.0


def write_room(folder: Path, kind: str, frames: int = 3, encoding: str = "bgr8") -> BagWriter:
    """Depth at 10 frames per second and colour 8 ms later, of a camera 5 cm to the right."""
    with BagWriter(folder, kind) as bag:
        bag.info("/cam/depth/camera_info", "depth_optical")
        bag.info("/cam/color/camera_info", "color_optical")
        bag.static("base", "/depth_optical", 0.1)
        bag.static("base", "color_optical", 0.15)
        for index in range(frames):
            time_s = START_S + 0.1 * index
            image = depth_mm(index)
            bag.image("/cam/depth/image_raw", image, "16UC1", time_s, "depth_optical")
            color = shade(index)[..., ::-1] if encoding == "bgr8" else shade(index)
            color = np.ascontiguousarray(color)
            bag.image("/cam/color/image_raw", color, encoding, time_s + 0.008, "color_optical")
            infrared = np.zeros((HEIGHT, WIDTH), np.uint8)
            bag.image("/cam/infra1/image_raw", infrared, "mono8", time_s, "depth_optical")
    return bag


@pytest.mark.parametrize("kind", KINDS)
def test_depth_comes_back_exactly_with_its_times_and_colour(tmp_path, kind):
    recording = topview.open(write_room(tmp_path, kind).path)
    frames = list(recording)
    assert recording.frame_count == len(frames) == 3
    assert (recording.camera.fx, recording.camera.fy) == (30.0, 31.0)
    for index, frame in enumerate(frames):
        expected = (depth_mm(index) / 1e3).astype(np.float32)
        np.testing.assert_array_equal(frame.depth_m, expected)
        assert frame.timestamp_s == pytest.approx(0.1 * index, abs=1e-6)
        assert frame.color is not None
        is_seen = frame.color.max(-1) > 0
        assert (frame.color[is_seen] == shade(index)[0, 0]).all()
        # Near points of the first columns lie left of what the colour camera sees.
        assert 0.5 < is_seen.mean() < 1.0
        assert is_seen[:, 0].mean() < is_seen[:, -1].mean()
    assert recording.problems == []
    assert len(list(recording)) == 3


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_gravity_is_that_of_an_accelerometer_at_rest(tmp_path, kind):
    """Its frame is turned by 90 degrees about x: what it has as z, the camera has as -y."""
    cases = {(0.0, 1.0, 9.7): True, (0.0, 1.0, -9.7): False, (0.0, 0.0, 3.0): False}
    for number, (acceleration, is_told) in enumerate(cases.items()):
        (tmp_path / f"{number}").mkdir()
        with BagWriter(tmp_path / f"{number}", kind) as bag:
            bag.info("/cam/depth/camera_info", "depth_optical")
            bag.image("/cam/depth/image_raw", depth_mm(0), "16UC1", START_S, "depth_optical")
            bag.static("depth_optical", "imu", 0.0, np.pi / 2)
            for _ in range(3):
                bag.imu("/cam/imu", "imu", acceleration)
        recording = topview.open(bag.path)
        told = recording.camera.gravity_camera
        if is_told:
            assert told == pytest.approx(np.array([0.0, 9.7, -1.0]) / np.hypot(1.0, 9.7))
            (frame,) = recording
            assert frame.camera.gravity_camera is not None
        else:
            assert told is None
            assert "gravity is left to the floor" in "".join(recording.problems)


def test_a_bare_file_of_ros_2_is_a_bag_too(tmp_path):
    for kind in ("db3", "mcap"):
        bag = write_room(tmp_path / kind, kind) if not (tmp_path / kind).mkdir() else None
        assert bag is not None
        assert topview.open(bag.file).frame_count == 3
        (bag.path / "metadata.yaml").unlink()
        assert len(list(topview.open(bag.path))) == 3


def test_float_and_compressed_depth_and_colour(tmp_path):
    metres = (depth_mm(0) / 1e3).astype(np.float32)
    scale, offset = 20_000.0, 5.0
    inverse = np.where(metres > 0.1, scale / np.maximum(metres, 0.1) + offset, 0).astype(np.uint16)
    header = struct.pack("<iff", 0, scale, offset)
    images = {
        "16UC1; compressedDepth png": struct.pack("<iff", 0, 0, 0) + png(depth_mm(0)),
        "32FC1; compressedDepth": header + png(inverse),
    }
    for number, (encoding, data) in enumerate(images.items()):
        folder = tmp_path / str(number)
        folder.mkdir()
        with BagWriter(folder, "bag") as bag:
            bag.info("/depth/camera_info", "a")
            bag.compressed("/depth/image/compressedDepth", data, encoding, 1.0, "a")
            bag.compressed("/rgb/image/compressed", png(shade(3)[..., ::-1]), "png", 1.0, "a")
            bag.info("/rgb/camera_info", "a")
        (frame,) = topview.open(bag.path)
        if number == 0:
            np.testing.assert_array_equal(frame.depth_m, metres)
        else:
            is_reading = inverse > 0
            np.testing.assert_array_equal(frame.depth_m > 0, is_reading)
            steps = scale / frame.depth_m[is_reading] - scale / metres[is_reading]
            assert np.abs(steps).max() <= 1.01
        assert frame.color is not None
        np.testing.assert_array_equal(frame.color, shade(3))
    with BagWriter(tmp_path, "mcap") as bag:
        bag.info("/depth/camera_info", "a")
        bag.image("/depth/image", metres, "32FC1", 0.0, "a")
    (frame,) = topview.open(bag.path)
    np.testing.assert_array_equal(frame.depth_m, metres)


def png(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", np.ascontiguousarray(image))[1].tobytes()


@pytest.mark.parametrize("trailing", [b"", b"\0\0\0\0"])
def test_a_bag_of_librealsense_with_bytes_left_over(tmp_path, trailing):
    with BagWriter(tmp_path, "bag") as bag:
        bag.trailing = trailing
        depth, color = "/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0"
        scale = bag.make("std_msgs/msg/Float32", data=0.00025)
        bag.write("/device_0/sensor_0/option/Depth_Units/value", scale)
        for stream, x_m in ((depth, 0.0), (color, -0.05)):
            bag.info(f"{stream}/info/camera_info", "0", distortion_model="Inverse Brown Conrady")
            bag.write(f"{stream}/tf/0", bag.transform(x_m))
        bag.image(f"{depth}/image/data", depth_mm(0), "mono16", 1.0, "0")
        bag.image(f"{color}/image/data", shade(0), "rgb8", 1.0, "0")
    recording = topview.open(bag.path)
    (frame,) = recording
    assert recording.camera.sensor == "stereo"
    np.testing.assert_array_equal(frame.depth_m, (depth_mm(0) * 0.00025).astype(np.float32))
    assert frame.color is not None
    is_seen = frame.color.max(-1) > 0
    assert is_seen[:, 0].mean() < is_seen[:, -1].mean()


def test_librealsense_s_transforms_as_text_are_by_columns():
    T = extrinsic_of("rotation=0,1,0,-1,0,0,0,0,1;translation=0.1,0.2,0.3")
    np.testing.assert_array_equal(
        T, [[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]
    )
    for broken in ("", "rotation=1;translation=1,2,3", "rotation=a;translation=b"):
        assert extrinsic_of(broken) is None


def test_a_lens_is_that_of_the_camera_info(tmp_path):
    for number, (model, named, count) in enumerate(
        [("plumb_bob", "brown_conrady", 5), ("rational_polynomial", "rational", 8)]
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        with BagWriter(folder, "mcap") as bag:
            bag.info("/camera_info", "a", distortion_model=model, D=np.full(count, 0.01))
            bag.image("/depth", depth_mm(0), "16UC1", 1.0, "a")
        lens = topview.open(bag.path).camera.distortion
        assert lens is not None
        assert (lens.model, lens.coefficients) == (named, (0.01,) * count)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"K": np.zeros(9)}, "has K of zeros; the camera must be calibrated"),
        ({"distortion_model": "equidistant", "D": np.ones(4)}, "must be one of plumb_bob"),
        ({"width": 99}, "has no sensor_msgs/CameraInfo for /depth; it must be recorded with it"),
        (None, "has no topic of depth images; it holds /camera_info"),
    ],
)
def test_what_cannot_be_used_is_one_line(tmp_path, changed, told):
    with BagWriter(tmp_path, "bag") as bag:
        bag.info("/camera_info", "a", **(changed or {}))
        if changed is not None:
            bag.image("/depth", depth_mm(0), "16UC1", 1.0, "a")
    with pytest.raises(InputError, match=rf"walk\.bag: .*{told}"):
        topview.open(bag.path)


def test_colour_from_nobody_knows_where_is_left_aside(tmp_path):
    with BagWriter(tmp_path, "bag") as bag:
        for name in ("depth", "rgb"):
            bag.info(f"/{name}/camera_info", name)
        for time_s in (1.0, 1.1):
            bag.image("/depth/image", depth_mm(0), "16UC1", time_s, "depth")
            bag.image("/rgb/image", shade(0), "rgb8", time_s, "rgb")
    recording = topview.open(bag.path)
    assert [frame.color for frame in recording] == [None, None]
    assert recording.problems == [
        "/rgb/image: no static transform leads from 'depth' to its frame 'rgb'; going on without "
        "colour"
    ]


def test_times_that_do_not_rise_cost_their_frames(tmp_path):
    with BagWriter(tmp_path, "bag") as bag:
        bag.info("/camera_info", "a")
        for n, time_s in enumerate((1.0, 1.1, 1.1, 1.05, 1.2)):
            bag.image("/depth", depth_mm(n), "16UC1", time_s, "a", received_s=2.0 + n)
    recording = topview.open(bag.path)
    assert len(list(recording)) == 3
    assert len([p for p in recording.problems if "it must be later; left out" in p]) == 2


@pytest.mark.parametrize("kind", KINDS)
def test_cut_or_spoiled_anywhere_it_is_one_line_or_the_frames_before(tmp_path, kind, capfd):
    bag = write_room(tmp_path, kind)
    whole = bag.file.read_bytes()
    cuts = list(cut(whole))
    for data in (*cuts, *flipped(whole)):
        bag.file.write_bytes(data)
        with suppress(InputError):
            recording = topview.open(bag.file)
            frames = list(recording)
            assert recording.problems or len(frames) == 3 or data not in cuts
            for frame in frames:
                assert frame.depth_m.shape == (HEIGHT, WIDTH)
    assert capfd.readouterr().err == ""


def test_without_rosbags_one_line_says_what_to_install(tmp_path, monkeypatch):
    bag = write_room(tmp_path, "bag", 1)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InputError, match=r"walk\.bag: .*pip install 'topview\[ros\]'"):
        topview.open(bag.path)
