"""OAK cameras, against a stand-in for depthai: no camera was at hand."""

from __future__ import annotations

import sys
from datetime import timedelta
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tiny_recordings import CAMERA, HEIGHT, WIDTH
from topview.live.oak import FPS, SIZE, OakCamera
from topview.records import InputError

DEPTH_MM = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH)
COLOR = np.tile(np.array([200, 100, 0], np.uint8), (HEIGHT, WIDTH, 1))
K = [[CAMERA["fx"], 0, CAMERA["cx"]], [0, CAMERA["fy"], CAMERA["cy"]], [0, 0, 1]]


class Port:
    """An input or output of a node; what is linked is noted."""

    def __init__(self, name: str, links: list[str]) -> None:
        self.name, self._links = name, links

    def link(self, other: Port) -> None:
        self._links.append(f"{self.name} > {other.name}")


class Image:
    def __init__(self, pixels: np.ndarray) -> None:
        self._pixels = pixels

    def getFrame(self) -> np.ndarray:
        return self._pixels

    def getWidth(self) -> int:
        return self._pixels.shape[1]

    def getHeight(self) -> int:
        return self._pixels.shape[0]

    def getTransformation(self) -> Any:
        return SimpleNamespace(getIntrinsicMatrix=lambda: K)

    def getTimestampDevice(self) -> timedelta:
        return timedelta(seconds=2.5)


class Group:
    def __init__(self, **images: np.ndarray) -> None:
        self._images = {name: Image(pixels) for name, pixels in images.items()}

    def getMessageNames(self) -> list[str]:
        return [*self._images]

    def __getitem__(self, name: str) -> Image:
        return self._images[name]


class Sdk:
    """The parts of `depthai` that are used.

    Args:
        sensors: kinds of the camera's sensors.
        groups: what each wait gives; an error is raised.
        platform: the camera's.
    """

    Platform = SimpleNamespace(RVC2="RVC2", RVC4="RVC4")
    CameraSensorType = SimpleNamespace(COLOR="color", MONO="mono", TOF="tof")
    ImgFrame = SimpleNamespace(Type=SimpleNamespace(RGB888i="RGB888i"))
    node = SimpleNamespace(
        Camera="Camera", StereoDepth="StereoDepth", Sync="Sync", ToF="ToF", ImageAlign="ImageAlign"
    )

    def __init__(self, sensors: list[str], groups: list[Any], platform: str = "RVC2") -> None:
        self.links: list[str] = []
        self.asked: dict[str, tuple[Any, ...]] = {}
        self.ended: list[str] = []
        sdk = self

        class Device:
            def __init__(self, info: Any) -> None: ...

            @staticmethod
            def getAllAvailableDevices() -> list[Any]:
                return [SimpleNamespace(getDeviceId=lambda: "14442C")]

            def getDeviceName(self) -> str:
                return "OAK-D-PRO"

            def getPlatform(self) -> str:
                return platform

            def getConnectedCameraFeatures(self) -> list[Any]:
                return [
                    SimpleNamespace(socket=f"CAM_{n}", supportedTypes=[kind])
                    for n, kind in enumerate(sensors)
                ]

            def close(self) -> None:
                sdk.ended.append("device")

        self.Device = Device
        self._groups = groups

    def Pipeline(self, device: Any) -> Any:
        return SimpleNamespace(
            create=self._node, start=lambda: None, stop=lambda: self.ended.append("pipeline")
        )

    def _node(self, kind: str) -> Any:
        ports = {
            name: Port(f"{kind}.{name}", self.links)
            for name in ("depth", "inputAlignTo", "input", "outputAligned")
        }
        node = SimpleNamespace(**ports)
        node.inputs = {name: Port(f"{kind}.{name}", self.links) for name in ("depth", "color")}
        node.out = SimpleNamespace(createOutputQueue=lambda maxSize, blocking: self)
        node.setSyncThreshold = node.setRunOnHost = lambda value: None

        def build(*words: Any, **options: Any) -> Any:
            self.asked[kind] = (*words, options)
            return node

        def request(*words: Any, **options: Any) -> Port:
            self.asked["pixels"] = (*words, options)
            return Port(f"{kind}.pixels", self.links)

        node.build, node.requestOutput = build, request
        return node

    def get(self, timeout: timedelta) -> Any:
        given = self._groups.pop(0)
        if isinstance(given, Exception):
            raise given
        return given


def test_what_the_camera_says_and_gives(monkeypatch):
    both = Group(depth=DEPTH_MM, color=COLOR)
    sdk = Sdk(["color", "mono", "mono"], [both, both, None, RuntimeError("closed")])
    monkeypatch.setitem(sys.modules, "depthai", sdk)
    camera = OakCamera("14442C")
    assert (camera.name, camera.camera.sensor, camera.color) == ("OAK-D-PRO", "stereo", None)
    assert all(getattr(camera.camera, key) == CAMERA[key] for key in CAMERA)
    assert camera.metres_per_unit == 0.001
    assert sdk.asked["StereoDepth"] == (True, {"size": SIZE, "fps": FPS})
    assert sdk.asked["pixels"] == (SIZE, "RGB888i", {"fps": FPS, "enableUndistortion": True})
    frame = camera.read()
    assert frame is not None
    assert frame.timestamp_s == 2.5
    np.testing.assert_array_equal(frame.depth, DEPTH_MM)
    np.testing.assert_array_equal(frame.color, COLOR)
    with pytest.raises(InputError, match="OAK-D-PRO: no frame for 5 s"):
        camera.read()
    camera.close()
    camera.close()
    assert sdk.ended == ["pipeline", "device"]
    assert camera.read() is None


@pytest.mark.parametrize(
    ("sensors", "platform", "links"),
    [
        (
            ["color", "mono", "mono"],
            "RVC2",
            {"Camera.pixels > StereoDepth.inputAlignTo", "StereoDepth.depth > Sync.depth"},
        ),
        (
            ["color", "mono", "mono"],
            "RVC4",
            {
                "Camera.pixels > ImageAlign.inputAlignTo",
                "StereoDepth.depth > ImageAlign.input",
                "ImageAlign.outputAligned > Sync.depth",
            },
        ),
        (
            ["tof", "color"],
            "RVC2",
            {
                "Camera.pixels > ImageAlign.inputAlignTo",
                "ToF.depth > ImageAlign.input",
                "ImageAlign.outputAligned > Sync.depth",
            },
        ),
        (["mono", "mono"], "RVC2", {"StereoDepth.depth > Sync.depth"}),
    ],
)
def test_depth_is_registered_to_the_colour(monkeypatch, sensors, platform, links):
    has_color = "color" in sensors
    images = {"depth": DEPTH_MM} | ({"color": COLOR} if has_color else {})
    sdk = Sdk(sensors, [Group(**images)] * 2, platform)
    monkeypatch.setitem(sys.modules, "depthai", sdk)
    camera = OakCamera()
    assert {*sdk.links} == links | ({"Camera.pixels > Sync.color"} if has_color else set())
    assert camera.camera.sensor == ("tof" if "tof" in sensors else "stereo")
    frame = camera.read()
    assert frame is not None
    assert (frame.color is not None) == has_color


@pytest.mark.parametrize(
    ("serial", "given", "said"),
    [
        ("7", None, "oak:7 names no camera that is there; there are 14442C"),
        ("", RuntimeError("in use"), "OAK-D-PRO: cannot be started: in use"),
        ("", Group(depth=DEPTH_MM[1:], color=COLOR), "the camera must register them"),
    ],
)
def test_what_cannot_be_used_is_told(monkeypatch, serial, given, said):
    sdk = Sdk(["color", "mono", "mono"], [given])
    monkeypatch.setitem(sys.modules, "depthai", sdk)
    with pytest.raises(InputError, match=said):
        OakCamera(serial)
    assert sdk.ended == ([] if serial else ["pipeline", "device"])


def test_without_depthai_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "depthai", None)
    with pytest.raises(InputError, match=r"pip install 'topview\[oak\]'"):
        OakCamera()
