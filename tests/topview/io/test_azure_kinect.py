"""Azure Kinect recordings: what PyAV muxed comes back, both cameras are the SDK's."""

from __future__ import annotations

import json
import re
import struct
import sys
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest

import topview
from damage import cut, flipped
from topview import InputError
from topview.io.readers.azure_calibration import AzureCalibration
from topview.io.readers.azure_mkv import AzureRecording

WIDTH, HEIGHT = 320, 288
COLOR_WIDTH, COLOR_HEIGHT = 1280, 720
# Of one device: the shares that its calibration.json has, and what the SDK says of 640 x 576 and of
# 1920 x 1080.
DEPTH_SHARES = [0.5122697949409485, 0.49451231956481934, 0.4921168386936188, 0.4921667277812958]
DEPTH_BENT = [3.130577, 2.324939, 0.130416, 3.458652, 3.350115, 0.662942, 0, 0, -0.000051, 0.000081]
DEPTH_SDK = [332.064270, 325.880615, 503.927643, 503.978729]
COLOR_SHARES = [0.4967627227306366, 0.5108628273010254, 0.470907062292099, 0.6274453997612]
COLOR_SDK = [953.284424, 555.142456, 904.141541, 903.521362]


FOURCC = {"nv12": "NV12", "yuyv422": "YUY2"}  # as k4arecorder writes them


def calibration(bent: list[float] | None = None, shift_m: float = -0.032) -> dict[str, Any]:
    def camera(location: str, shares: list[float], x_m: float, size: tuple[int, int]) -> Any:
        return {
            "Location": f"CALIBRATION_CameraLocation{location}",
            "Intrinsics": {
                "ModelType": "CALIBRATION_LensDistortionModelBrownConrady",
                "ModelParameterCount": 14,
                "ModelParameters": [*shares, *(bent or [0.0] * 10)],
            },
            "Rt": {"Rotation": np.eye(3).ravel().tolist(), "Translation": [x_m, 0.0, 0.0]},
            "SensorWidth": size[0],
            "SensorHeight": size[1],
        }

    cameras = [
        camera("D0", DEPTH_SHARES, 0.0, (1024, 1024)),
        camera("PV0", COLOR_SHARES, shift_m, (4096, 3072)),
    ]
    return {"CalibrationInformation": {"Cameras": cameras}}


def depth_mm(index: int) -> np.ndarray:
    image = np.random.default_rng(index).integers(500, 6000, (HEIGHT, WIDTH), np.uint16)
    image[0, :3] = 0, 1, 65535
    image[-1, -1] = 0x1234
    return image


def jpeg(_: int) -> bytes:
    image = np.full((COLOR_HEIGHT, COLOR_WIDTH, 3), (20, 60, 200), np.uint8)
    return cv2.imencode(".jpg", image)[1].tobytes()


def raw(format: str) -> Callable[[int], bytes]:
    """A picture of one colour, red, in a raw format."""
    y, u, v = 76, 85, 255
    if format == "nv12":
        chroma = np.tile(np.array([u, v], np.uint8), COLOR_WIDTH * COLOR_HEIGHT // 4)
        data = np.full(COLOR_WIDTH * COLOR_HEIGHT, y, np.uint8).tobytes() + chroma.tobytes()
    else:
        pair = np.array([y, u, y, v], np.uint8)
        data = np.tile(pair, COLOR_WIDTH * COLOR_HEIGHT // 2).tobytes()
    return lambda _: data


def write_mkv(
    path: Path,
    told: dict[str, Any] | None = None,
    color: Callable[[int], bytes] | None = jpeg,
    color_codec: tuple[str, str] = ("mjpeg", "yuvj422p"),
    frames: int = 2,
    step_ms: int = 33,
    imu: bytes = b"",
) -> Path:
    """As k4arecorder writes it: depth and infrared alike but for their titles."""
    options = {"allow_raw_vfw": "1"}
    with av.open(str(path), "w", format="matroska", options=options) as container:
        tracks = {}
        for title, codec, pixels, size in (
            ("COLOR", *color_codec, (COLOR_WIDTH, COLOR_HEIGHT)),
            ("IR", "rawvideo", "gray16be", (WIDTH, HEIGHT)),
            ("DEPTH", "rawvideo", "gray16be", (WIDTH, HEIGHT)),
        ):
            if title == "COLOR" and color is None:
                continue
            stream: Any = container.add_stream(codec, rate=30)
            (stream.width, stream.height), stream.pix_fmt = size, pixels
            stream.codec_context.time_base = stream.time_base = Fraction(1, 1000)
            stream.metadata["title"] = title
            if pixels in FOURCC:
                stream.codec_context.codec_tag = FOURCC[pixels]
            tracks[title] = stream
        if imu:
            tracks["IMU"] = container.add_mux_stream("subrip")
            tracks["IMU"].metadata["title"] = "IMU"
        if told is not None:
            data = json.dumps(told).encode() + b"\0"
            container.add_attachment("calibration.json", "application/octet-stream", data)
        for index in range(frames):
            for title, stream in tracks.items():
                images = {"DEPTH": depth_mm(index), "IR": depth_mm(index + 50)}
                data = images[title].astype(">u2").tobytes() if title in images else b""
                data = imu if title == "IMU" else data
                packet = av.Packet(data or (color or jpeg)(index))
                packet.stream = stream
                packet.pts = packet.dts = step_ms * index + (5 if title == "COLOR" else 0)
                packet.time_base = Fraction(1, 1000)
                packet.is_keyframe = True
                container.mux(packet)
    # The muxer leaves the FourCC of 16-bit images empty.
    written = struct.pack("<iiihhi", 40, WIDTH, -HEIGHT, 1, 16, 0)
    right = struct.pack("<iiihh4s", 40, WIDTH, HEIGHT, 1, 16, b"b16g")
    data = path.read_bytes().replace(written, right)
    path.write_bytes(data.replace(b"S_TEXT/UTF8", b"S_K4A/IMU\0\0"))
    return path


def test_depth_comes_back_bit_exact_and_colour_registered(tmp_path):
    recording = topview.open(write_mkv(tmp_path / "walk.mkv", calibration()))
    assert isinstance(recording, AzureRecording)
    frames = list(recording)
    assert [frame.timestamp_s for frame in frames] == pytest.approx([0.0, 0.033])
    for index, frame in enumerate(frames):
        expected = (depth_mm(index) / 1e3).astype(np.float32)
        np.testing.assert_array_equal(frame.depth_m, expected)
        assert frame.color is not None
        is_seen = frame.color.any(-1)
        assert is_seen.mean() > 0.3
        red = np.median(frame.color[is_seen], axis=0)
        np.testing.assert_allclose(red, (200, 60, 20), atol=4)
    assert recording.problems == []
    assert recording.camera.sensor == "tof"


@pytest.mark.parametrize("format", ["nv12", "yuyv422"])
def test_raw_colour_is_rgb(tmp_path, format):
    codec = ("rawvideo", format)
    recording = topview.open(write_mkv(tmp_path / "w.mkv", calibration(), raw(format), codec, 1))
    assert isinstance(recording, AzureRecording)
    color = recording.color(raw(format)(0))
    assert color.shape == (COLOR_HEIGHT, COLOR_WIDTH, 3)
    np.testing.assert_allclose(color.reshape(-1, 3).mean(0), (255, 0, 0), atol=6)
    (frame,) = recording
    assert frame.color is not None


def test_the_cameras_are_those_of_the_sdk():
    both = AzureCalibration(json.dumps(calibration(DEPTH_BENT)).encode())
    depth, color = both.depth_camera(640, 576), both.color_camera(1920, 1080)
    assert color is not None
    for camera, sdk in ((depth, DEPTH_SDK), (color.camera, COLOR_SDK)):
        own = [camera.cx, camera.cy, camera.fx, camera.fy]
        np.testing.assert_allclose(own, sdk, atol=1e-4)
    k1, k2, k3, k4, k5, k6, _, _, p2, p1 = DEPTH_BENT
    assert depth.distortion is not None
    assert depth.distortion.coefficients == (k1, k2, p1, p2, k3, k4, k5, k6)
    np.testing.assert_allclose(color.T_color_depth[:3, 3], (-0.032, 0.0, 0.0))


# Of one device: by x, y and z the sensor looks backwards, to the left and down.
R_ACCELEROMETER_DEVICE = [
    -0.0023786, 0.1078378, -0.9941657, -0.9999966, 0.0008232, 0.0024819, 0.0010860, 0.9941682,
    0.1078355,
]  # fmt: skip


def test_gravity_is_that_of_an_accelerometer_at_rest(tmp_path):
    """The depth camera is mounted to look down by six degrees."""
    told = calibration()
    told["CalibrationInformation"]["InertialSensors"] = [
        {"SensorType": "CALIBRATION_InertialSensorType_Gyro"},
        {
            "SensorType": "CALIBRATION_InertialSensorType_Accelerometer",
            "Rt": {"Rotation": R_ACCELEROMETER_DEVICE, "Translation": [-0.05, 0.0035, 0.0017]},
        },
    ]
    for is_still in (True, False):
        sample = struct.pack("<Q3fQ3f", 0, 0.0, 0.0, -9.81 if is_still else -20.0, 0, 0, 0, 0)
        path = write_mkv(tmp_path / "level.mkv", told, None, imu=8 * sample)
        recording = topview.open(path)
        gravity = recording.camera.gravity_camera
        if is_still:
            assert gravity is not None
            tilt_rad = np.arctan2(gravity[2], gravity[1])
            assert np.degrees(tilt_rad) == pytest.approx(6.2, abs=0.1)
            assert abs(gravity[0]) < 0.01
        else:
            assert gravity is None
            assert "the accelerometer tells 20.0 m/s^2" in recording.problems[0]
        assert len(list(recording)) == 2


def without(*keys: str) -> dict[str, Any]:
    """A calibration whose depth camera lacks something."""
    told = calibration()
    inner = told["CalibrationInformation"]["Cameras"][0]
    for key in keys[:-1]:
        inner = inner[key]
    del inner[keys[-1]]
    return told


@pytest.mark.parametrize(
    ("told", "complaint"),
    [
        (None, r"has no calibration\.json attached"),
        ({}, r"calibration\.json: has no depth camera"),
        (without("Rt"), r"calibration\.json: has no Rt"),
        (without("Intrinsics", "ModelType"), r"calibration\.json: has no ModelType"),
        (without("Location"), r"calibration\.json: has no depth camera"),
    ],
)
def test_a_calibration_that_cannot_be_used_is_one_line(tmp_path, told, complaint):
    with pytest.raises(InputError, match=rf"walk\.mkv: {complaint}"):
        topview.open(write_mkv(tmp_path / "walk.mkv", told, frames=1))


def test_cut_or_spoiled_anywhere_it_is_one_line_or_the_frames_before(tmp_path, capfd):
    path = write_mkv(tmp_path / "walk.mkv", calibration(), None)
    whole = path.read_bytes()
    counts = []
    for data in (*cut(whole), *flipped(whole, 10)):
        path.write_bytes(data)
        with suppress(InputError):
            counts.append(len(list(topview.open(path))))
    assert 1 in counts  # the frames before the damage
    assert capfd.readouterr().err == ""


def test_a_file_that_ends_too_early_is_told_and_its_frames_are_kept(tmp_path):
    path = write_mkv(tmp_path / "walk.mkv", calibration(), None, frames=3, step_ms=1000)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    recording = topview.open(path)
    assert len(list(recording)) == 1
    (problem,) = recording.problems[1:]
    assert re.match(
        r"ends after 0\.0 s of the 2\.0 s that it says; .*frames before are kept", problem
    )


def test_without_pyav_one_line_says_what_to_install(tmp_path, monkeypatch):
    path = write_mkv(tmp_path / "walk.mkv", calibration(), None, frames=1)
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r"walk\.mkv: .*pip install 'topview\[mkv\]'"):
        topview.open(path)
