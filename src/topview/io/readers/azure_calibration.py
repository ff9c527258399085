"""The cameras of an Azure Kinect, by the `calibration.json` that its recorder attaches.

As Microsoft's SDK takes it (`transformation/mode_specific_calibration.c`): parameters are cx cy fx
fy k1 ... k6 codx cody p2 p1, the first four as shares of a whole sensor image that is scaled to the
mode and cropped; its pixels' corners, not centres, lie at integers.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.io.readers.camera_json import MOST_JSON_BYTES, json_object
from topview.io.readers.registration import ColorCamera
from topview.records import Camera, Distortion, InputError, SensorName, rigid_transform


@dataclass(frozen=True, slots=True)
class Mode:
    """The whole image that parameters are shares of, and what the mode crops at left and top."""

    whole: tuple[int, int]
    crop: tuple[int, int] = (0, 0)


# Width and height of an image: its mode.
DEPTH_MODES: Final = {
    (320, 288): Mode((512, 512), (96, 90)),
    (640, 576): Mode((1024, 1024), (192, 180)),
    (512, 512): Mode((512, 512)),
    (1024, 1024): Mode((1024, 1024)),
}
COLOR_MODES: Final = {
    (1280, 720): Mode((1280, 960), (0, 120)),
    (1920, 1080): Mode((1920, 1440), (0, 180)),
    (2560, 1440): Mode((2560, 1920), (0, 240)),
    (2048, 1536): Mode((2048, 1536)),
    (3840, 2160): Mode((3840, 2880), (0, 360)),
    (4096, 3072): Mode((4096, 3072)),
}
AZURE_MODEL: Final = "CALIBRATION_LensDistortionModelBrownConrady"
PARAMETERS: Final = 14
ACCELEROMETER: Final = "CALIBRATION_InertialSensorType_Accelerometer"
_LEGACY_SHAPE: Final = 16 / 9  # of a sensor whose shares are of 4096 x 2304
_RIGHT: Final = "it must be the calibration that k4arecorder attaches"


class AzureCalibration:
    """Both cameras of a device. Errors do not name the file.

    Raises:
        InputError: no such calibration.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) > MOST_JSON_BYTES:
            raise InputError(f"has {len(data)} bytes; {_RIGHT}")
        values = json_object(data.rstrip(b"\0"))
        try:
            information = values["CalibrationInformation"]
            cameras = information["Cameras"]
            self._depth = next(c for c in cameras if c["Location"].endswith("LocationD0"))
            self._color = next((c for c in cameras if c["Location"].endswith("LocationPV0")), None)
        except (KeyError, TypeError, AttributeError, StopIteration):
            raise InputError(f"has no depth camera (CameraLocationD0); {_RIGHT}") from None
        self._accelerometer = _accelerometer(information.get("InertialSensors"))

    def depth_camera(self, width: int, height: int) -> Camera:
        """Of depth images of a mode, told by their size."""
        return _camera(self._depth, (width, height), DEPTH_MODES, "tof")

    def R_depth_accelerometer(self) -> NDArray[np.float64] | None:
        """[3, 3]; None if the device has none."""
        if self._accelerometer is None:
            return None
        T_depth, T_sensor = (_T_camera_device(v) for v in (self._depth, self._accelerometer))
        return T_depth[:3, :3] @ T_sensor[:3, :3].T

    def color_camera(self, width: int, height: int) -> ColorCamera | None:
        """Of colour images of a mode; None if the device has none."""
        if self._color is None:
            return None
        camera = _camera(self._color, (width, height), COLOR_MODES, "kinect1")
        T_depth, T_color = (_T_camera_device(values) for values in (self._depth, self._color))
        return ColorCamera(camera, rigid_transform(T_color @ np.linalg.inv(T_depth), "Rt"))


def _accelerometer(sensors: Any) -> dict[str, Any] | None:
    found = [s for s in sensors if isinstance(s, dict)] if isinstance(sensors, list) else []
    return next((s for s in found if s.get("SensorType") == ACCELEROMETER), None)


def _camera(
    values: dict[str, Any],
    size: tuple[int, int],
    modes: dict[tuple[int, int], Mode],
    sensor: SensorName,
) -> Camera:
    if size not in modes:
        right = ", ".join(f"{width} x {height}" for width, height in modes)
        raise InputError(f"images are {size[0]} x {size[1]} pixels; they must be one of {right}")
    mode = modes[size]
    try:
        intrinsics = values["Intrinsics"]
        model = intrinsics["ModelType"]
        given = [float(p) for p in intrinsics["ModelParameters"][:PARAMETERS]]
        is_legacy = values["SensorWidth"] / values["SensorHeight"] == _LEGACY_SHAPE
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        raise InputError(f"has no ModelType and ModelParameters; {_RIGHT}") from None
    if len(given) != PARAMETERS or model != AZURE_MODEL:
        raise InputError(
            f"is {json.dumps(model)} of {len(given)} parameters; it must be {AZURE_MODEL} of "
            f"{PARAMETERS}"
        )
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = given
    if is_legacy:  # of 16:9, in the middle of the whole 4:3
        fy, cy = fy * 0.75, (cy * 2304.0 + 384.0) / 3072.0
    return Camera(
        fx * mode.whole[0],
        fy * mode.whole[1],
        cx * mode.whole[0] - mode.crop[0] - 0.5,
        cy * mode.whole[1] - mode.crop[1] - 0.5,
        *size,
        Distortion("rational", (k1, k2, p1, p2, k3, k4, k5, k6)),
        sensor,
    )


def _T_camera_device(values: dict[str, Any]) -> NDArray[np.float64]:
    """[4, 4] metres."""
    T = np.eye(4)
    try:
        T[:3, :3] = np.array(values["Rt"]["Rotation"], np.float64).reshape(3, 3)
        T[:3, 3] = np.array(values["Rt"]["Translation"], np.float64)
    except (KeyError, TypeError, ValueError):
        raise InputError(f"has no Rt of a Rotation and a Translation; {_RIGHT}") from None
    return rigid_transform(T, "Rt")
