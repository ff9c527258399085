"""RealSense cameras, by librealsense's own software device: no hardware is needed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview.live.realsense import RealSenseCamera
from topview.records import InputError

rs: Any = pytest.importorskip(
    "pyrealsense2", reason="needs pyrealsense2 and its libusb", exc_type=ImportError
)
DEPTH_UNIT_M = 0.0005
BASELINE_M = 0.015


class SoftwareCamera:
    """A depth and a colour sensor that give what they are told to."""

    def __init__(self) -> None:
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "Software Camera")
        self.device.register_info(rs.camera_info.serial_number, "123")
        self.sensors = [self.device.add_sensor(name) for name in ("Depth", "Color")]
        formats = (rs.stream.depth, rs.format.z16, 2), (rs.stream.color, rs.format.rgb8, 3)
        self.profiles = [
            sensor.add_video_stream(self._stream(n, *kind)).as_video_stream_profile()
            for n, (sensor, kind) in enumerate(zip(self.sensors, formats, strict=True))
        ]
        self.sensors[0].add_read_only_option(rs.option.depth_units, DEPTH_UNIT_M)
        shift = rs.extrinsics()
        shift.rotation, shift.translation = [1, 0, 0, 0, 1, 0, 0, 0, 1], [BASELINE_M, 0, 0]
        self.profiles[0].register_extrinsics_to(self.profiles[1], shift)
        self.device.create_matcher(rs.matchers.dlr_c)

    def _stream(self, uid: int, type: Any, format: Any, bpp: int) -> Any:
        stream, lens = rs.video_stream(), rs.intrinsics()
        lens.width, lens.height = WIDTH, HEIGHT
        lens.fx, lens.fy, lens.ppx, lens.ppy = (CAMERA[key] for key in ("fx", "fy", "cx", "cy"))
        lens.model, lens.coeffs = rs.distortion.inverse_brown_conrady, [0.01 * uid, 0, 0, 0, 0]
        stream.type, stream.uid, stream.fmt, stream.bpp = type, uid, format, bpp
        stream.width, stream.height, stream.fps, stream.intrinsics = WIDTH, HEIGHT, 30, lens
        return stream

    def give(self, number: int, *images: np.ndarray) -> None:
        for sensor, profile, image in zip(self.sensors, self.profiles, images, strict=True):
            frame = rs.software_video_frame()
            frame.pixels, frame.bpp = np.ascontiguousarray(image), image.itemsize * image[0, 0].size
            frame.stride = frame.bpp * WIDTH
            frame.timestamp, frame.frame_number = 1000.0 + 33.0 * number, number
            frame.domain, frame.profile = rs.timestamp_domain.hardware_clock, profile
            sensor.on_video_frame(frame)


def test_what_the_camera_says_and_gives():
    software = SoftwareCamera()
    camera = RealSenseCamera(device=software.device)
    assert camera.name == "Software Camera"
    assert camera.metres_per_unit == pytest.approx(DEPTH_UNIT_M)
    assert (camera.camera.fx, camera.camera.cy) == (CAMERA["fx"], CAMERA["cy"])
    assert camera.camera.sensor == "stereo"
    assert camera.camera.is_pinhole
    assert camera.color is not None
    lens = camera.color.camera.distortion
    assert lens is not None
    assert lens.model == "inverse_brown_conrady"
    np.testing.assert_allclose(camera.color.T_color_depth[:3, 3], [BASELINE_M, 0, 0], atol=1e-7)
    rng = np.random.default_rng(0)
    for number in (1, 2):
        depth = rng.integers(0, 9000, (HEIGHT, WIDTH), np.uint16)
        color = rng.integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
        software.give(number, depth, color)
        frame = camera.read()
        assert frame is not None
        assert frame.timestamp_s == pytest.approx(1.0 + 0.033 * number)
        np.testing.assert_array_equal(frame.depth, depth)
        assert frame.color is not None
        np.testing.assert_array_equal(frame.color, color)
    camera.close()
    camera.close()


def test_a_camera_that_is_not_there_is_told():
    with pytest.raises(
        InputError, match="realsense:77 names no camera that is there; none is connected"
    ):
        RealSenseCamera("77")
