"""Orbbec cameras (Femto, Gemini, Astra 2), by the Orbbec SDK 2 (the extra `orbbec`).

Written after the SDK's types and examples, and tested against a stand-in for it: no camera was at
hand.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import transform
from topview.io.readers.registration import ColorCamera
from topview.io.writers.extras import needed
from topview.live.camera import RawFrame
from topview.live.sdk import WAITS_S, gone, known_lens, number_of
from topview.records import Camera, Distortion, InputError, SensorName

METRES_PER_MM: Final = 1e-3  # the SDK tells depth and translations in millimetres
TIME_OF_FLIGHT_NAME: Final = (
    "Femto"  # in the name; the others of the makers see by stereo or patterns
)
# The SDK's names of lenses, and which of its coefficients make ours.
SDK_LENSES: Final = {
    "BROWN_CONRADY": ("brown_conrady", ("k1", "k2", "p1", "p2", "k3")),
    "BROWN_CONRADY_K6": ("rational", ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")),
    "INVERSE_BROWN_CONRADY": ("inverse_brown_conrady", ("k1", "k2", "p1", "p2", "k3")),
}


class OrbbecCamera:
    """As `topview.live.DepthCamera`. Colour is registered by topview.

    Args:
        serial: of the camera; empty for the first there is.

    Raises:
        InputError: the SDK is missing, there is no such camera, or it gives no depth.
    """

    def __init__(self, serial: str = "") -> None:
        self._ob = needed("pyorbbecsdk", "orbbec:", "orbbec")
        ob = self._ob
        ob.Context.set_logger_to_file(ob.OBLogLevel.NONE, "")  # or it makes a folder `Log` here
        device = self._found(serial)
        self.name = str(device.get_device_info().get_name())
        self._pipeline, self._is_open = ob.Pipeline(device), True
        depth = self._profile(ob.OBSensorType.DEPTH_SENSOR, ("Y16", "Z16"))
        if depth is None:
            raise InputError(f"{self.name}: has no depth of 16 bits; it must be a depth camera")
        color = self._profile(ob.OBSensorType.COLOR_SENSOR, ("RGB", "MJPG"))
        self.fps = float(depth.get_fps())
        self.camera = _camera(depth, "tof" if TIME_OF_FLIGHT_NAME in self.name else "stereo")
        self.color = None if color is None else ColorCamera(_camera(color), _T(depth, color))
        self._start([profile for profile in (depth, color) if profile is not None])
        first = self._frames()  # only a frame tells the unit
        if first is None:
            raise InputError(f"{self.name}: gives no depth; another program may use it")
        self.metres_per_unit = METRES_PER_MM * float(first.get_depth_frame().get_depth_scale())

    def read(self) -> RawFrame | None:
        """As of `topview.live.DepthCamera`."""
        frames = self._frames()
        if frames is None:
            return None
        depth, color = frames.get_depth_frame(), frames.get_color_frame()
        values = np.frombuffer(depth.get_data(), np.uint16)
        return RawFrame(
            depth.get_timestamp_us() * 1e-6,
            values.reshape(depth.get_height(), depth.get_width()).copy(),
            None if color is None else self._pixels(color),
        )

    def close(self) -> None:
        """As of `topview.live.DepthCamera`."""
        if self._is_open:
            self._is_open = False
            self._pipeline.stop()

    def _frames(self) -> Any:
        """The next set with depth; None once the camera is closed."""
        while self._is_open:
            frames = self._pipeline.wait_for_frames(round(1e3 * WAITS_S))
            if frames is None:
                if not self._is_open:
                    return None
                raise gone(self.name)
            if frames.get_depth_frame() is not None:
                return frames
        return None

    def _pixels(self, color: Any) -> NDArray[np.uint8]:
        data = np.frombuffer(color.get_data(), np.uint8)
        if color.get_format() == self._ob.OBFormat.RGB:
            return data.reshape(color.get_height(), color.get_width(), 3).copy()
        image = cv2.imdecode(data, cv2.IMREAD_COLOR_RGB)
        if image is None:
            raise InputError(f"{self.name}: gave a colour image that is no JPEG")
        return np.asarray(image, np.uint8)

    def _found(self, serial: str) -> Any:
        devices = self._ob.Context().query_devices()
        serials = [
            str(devices.get_device_serial_number_by_index(n)) for n in range(devices.get_count())
        ]
        return devices.get_device_by_index(number_of("orbbec", serial, serials))

    def _profile(self, sensor: Any, formats: tuple[str, ...]) -> Any:
        """A stream of the first of the formats that the sensor has; None without any."""
        with suppress(self._ob.OBError):
            profiles = self._pipeline.get_stream_profile_list(sensor)
            default = profiles.get_default_video_stream_profile()
            if default.get_format().name in formats:
                return default
            for name in formats:
                with suppress(self._ob.OBError):
                    own = getattr(self._ob.OBFormat, name)
                    return profiles.get_video_stream_profile(0, 0, own, 0)
        return None

    def _start(self, profiles: list[Any]) -> None:
        config = self._ob.Config()
        for profile in profiles:
            config.enable_stream(profile)
        config.set_frame_aggregate_output_mode(
            self._ob.OBFrameAggregateOutputMode.FULL_FRAME_REQUIRE
        )
        try:
            self._pipeline.enable_frame_sync()
            self._pipeline.start(config)
        except self._ob.OBError as error:
            self._is_open = False
            raise InputError(f"{self.name}: cannot be started: {error}") from None


def _camera(profile: Any, sensor: SensorName = "kinect1") -> Camera:
    """Raises InputError for a lens that is not known."""
    told, bends = profile.get_intrinsic(), profile.get_distortion()
    lens = None
    if any(getattr(bends, f"k{n}") for n in range(1, 7)) or bends.p1 or bends.p2:
        model, names = known_lens(bends.model.name, SDK_LENSES)
        lens = Distortion(model, tuple(float(getattr(bends, name)) for name in names))
    return Camera(
        told.fx, told.fy, told.cx, told.cy, told.width, told.height,
        distortion=lens, sensor=sensor,
    )  # fmt: skip


def _T(profile: Any, other: Any) -> NDArray[np.float64]:
    """[4, 4] from the one stream's camera to the other's, metres."""
    told = profile.get_extrinsic_to(other)
    shift_mm = np.asarray(told.transform, np.float64).reshape(3)
    return transform(np.asarray(told.rot, np.float64).reshape(3, 3), METRES_PER_MM * shift_mm)
