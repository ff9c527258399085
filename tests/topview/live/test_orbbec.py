"""Orbbec cameras, against a stand-in for their SDK: no camera was at hand."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview.live.orbbec import OrbbecCamera
from topview.records import InputError

DEPTH = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH)
COLOR = np.tile(np.array([200, 100, 0], np.uint8), (HEIGHT, WIDTH, 1))


class OBError(Exception):
    pass


def kinds(*names: str) -> Any:
    return SimpleNamespace(**{name: SimpleNamespace(name=name) for name in names})


class Profile:
    def __init__(self, format: Any, model: str, k1: float) -> None:
        bends = dict.fromkeys(("k2", "k3", "k4", "k5", "k6", "p1", "p2"), 0.0) | {"k6": k1 / 2}
        self._bends = SimpleNamespace(model=SimpleNamespace(name=model), k1=k1, **bends)
        self._format = format

    def get_fps(self) -> int:
        return 30

    def get_format(self) -> Any:
        return self._format

    def get_intrinsic(self) -> Any:
        return SimpleNamespace(**CAMERA)

    def get_distortion(self) -> Any:
        return self._bends

    def get_extrinsic_to(self, other: Profile) -> Any:
        return SimpleNamespace(rot=np.eye(3, dtype=np.float32), transform=np.array([-32.0, 0, 0]))


def image(data: np.ndarray, format: Any) -> Any:
    raw = np.frombuffer(data.tobytes(), np.uint8)
    return SimpleNamespace(
        get_data=lambda: raw,
        get_format=lambda: format,
        get_width=lambda: WIDTH,
        get_height=lambda: HEIGHT,
        get_depth_scale=lambda: 0.25,
        get_timestamp_us=lambda: 2_500_000,
    )


def sdk(color_format: str, waits: list[str]) -> Any:
    """The parts of `pyorbbecsdk` that are used; `waits` is what each wait gives."""
    formats = kinds("Y16", "Z16", "RGB", "MJPG")
    sensors = kinds("DEPTH_SENSOR", "COLOR_SENSOR")
    jpeg = cv2.imencode(".jpg", COLOR[..., ::-1])[1]
    pixels = COLOR if color_format == "RGB" else jpeg
    own = getattr(formats, color_format)

    class Pipeline:
        stopped = 0

        def __init__(self, device: Any) -> None: ...

        def get_stream_profile_list(self, sensor: Any) -> Any:
            profile = (
                Profile(formats.Y16, "BROWN_CONRADY_K6", 0.02)
                if sensor is sensors.DEPTH_SENSOR
                else Profile(own, "BROWN_CONRADY", 0.0)
            )
            return SimpleNamespace(get_default_video_stream_profile=lambda: profile)

        def enable_frame_sync(self) -> None: ...

        def start(self, config: Any) -> None:
            if not waits:
                raise OBError("in use")

        def stop(self) -> None:
            Pipeline.stopped += 1

        def wait_for_frames(self, timeout_ms: int) -> Any:
            if waits.pop(0) == "nothing":
                return None
            return SimpleNamespace(
                get_depth_frame=lambda: image(DEPTH, formats.Y16),
                get_color_frame=lambda: image(pixels, own),
            )

    devices = SimpleNamespace(
        get_count=lambda: 1,
        get_device_serial_number_by_index=lambda n: "CL8",
        get_device_by_index=lambda n: SimpleNamespace(
            get_device_info=lambda: SimpleNamespace(get_name=lambda: "Femto Bolt")
        ),
    )

    class Context:
        @staticmethod
        def set_logger_to_file(level: Any, folder: str) -> None: ...

        def query_devices(self) -> Any:
            return devices

    return SimpleNamespace(
        OBError=OBError,
        OBFormat=formats,
        OBSensorType=sensors,
        OBFrameAggregateOutputMode=kinds("FULL_FRAME_REQUIRE"),
        Pipeline=Pipeline,
        Context=Context,
        OBLogLevel=kinds("NONE"),
        Config=lambda: SimpleNamespace(
            enable_stream=lambda profile: None, set_frame_aggregate_output_mode=lambda mode: None
        ),
    )


@pytest.mark.parametrize("color_format", ["RGB", "MJPG"])
def test_what_the_camera_says_and_gives(monkeypatch, color_format):
    own = sdk(color_format, ["frame", "frame", "nothing"])
    monkeypatch.setitem(sys.modules, "pyorbbecsdk", own)
    camera = OrbbecCamera("CL8")
    assert (camera.name, camera.camera.sensor) == ("Femto Bolt", "tof")
    assert camera.metres_per_unit == pytest.approx(0.00025)
    lens = camera.camera.distortion
    assert lens is not None
    assert (lens.model, lens.coefficients[0], lens.coefficients[7]) == ("rational", 0.02, 0.01)
    assert camera.color is not None
    np.testing.assert_allclose(camera.color.T_color_depth[:3, 3], [-0.032, 0, 0])
    frame = camera.read()
    assert frame is not None
    assert frame.color is not None
    assert frame.timestamp_s == pytest.approx(2.5)
    np.testing.assert_array_equal(frame.depth, DEPTH)
    np.testing.assert_allclose(frame.color.astype(int), COLOR, atol=3)  # a JPEG loses a little
    with pytest.raises(InputError, match="Femto Bolt: no frame for 5 s"):
        camera.read()
    camera.close()
    camera.close()
    assert own.Pipeline.stopped == 1
    assert camera.read() is None


def test_what_cannot_be_used_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyorbbecsdk", sdk("RGB", []))
    with pytest.raises(InputError, match="orbbec:7 names no camera that is there; there are CL8"):
        OrbbecCamera("7")
    with pytest.raises(InputError, match="cannot be started: in use"):
        OrbbecCamera()
