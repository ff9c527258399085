"""Intel RealSense cameras, by librealsense (the extra `realsense`)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import transform
from topview.io.readers.pairing import StoredImage
from topview.io.readers.registration import ColorCamera
from topview.io.writers.extras import needed
from topview.live.camera import RawFrame
from topview.live.sdk import WAITS_S, gone, known_lens, next_pair, number_of
from topview.records import Camera, Distortion, InputError, SensorName

SIZE_AND_RATE: Final = (640, 480, 30)  # ours; of several streams the one most like it is taken
MOST_WAITING_FRAMES: Final = 2  # ours; of each stream, the oldest is dropped first
LENSES: Final = {
    "brown_conrady": "brown_conrady",
    "inverse_brown_conrady": "inverse_brown_conrady",
}
TIME_OF_FLIGHT: Final = ("L515",)  # the others of the family see by stereo


class RealSenseCamera:
    """As `topview.live.DepthCamera`. Colour is registered by topview, so that a recording keeps
    what the camera gave.

    Args:
        serial: of the camera; empty for the first there is.
        device: one of librealsense's own, in place of that.

    Raises:
        InputError: pyrealsense2 is missing, there is no such camera, or it has no depth.
    """

    def __init__(self, serial: str = "", device: Any = None) -> None:
        self._rs = needed("pyrealsense2", "realsense:", "realsense")
        device = device or self._found(serial)
        self.name = self._told(device, "name") or "RealSense"
        self.metres_per_unit, self.color = 0.0, None
        self._open: list[Any] = []
        rs = self._rs
        streams: dict[str, tuple[Any, Any]] = {}
        for sensor in device.query_sensors():
            for kind, pixels in (("depth", rs.format.z16), ("color", rs.format.rgb8)):
                if kind not in streams and (best := _most_like(sensor, pixels)) is not None:
                    streams[kind] = sensor, best
        if "depth" not in streams:
            raise InputError(f"{self.name}: has no depth stream; it must be a depth camera")
        sensor, profile = streams["depth"]
        self.metres_per_unit = float(sensor.get_option(rs.option.depth_units))
        self.fps = float(profile.fps())
        is_tof = any(model in self.name for model in TIME_OF_FLIGHT)
        self.camera = _camera(profile, "tof" if is_tof else "stereo")
        if "color" in streams:
            self.color = ColorCamera(_camera(streams["color"][1]), _T(profile, streams["color"][1]))
        self._queues = {kind: rs.frame_queue(MOST_WAITING_FRAMES) for kind in streams}
        self._start(streams)

    def read(self) -> RawFrame | None:
        """As of `topview.live.DepthCamera`: depth, and the colour taken within half a frame of it.
        librealsense's own `syncer` is not used; it gives depth and colour apart at times."""
        pair = next_pair(self._next, "color" in self._queues, self.fps)
        if pair is None:
            return None
        depth, color = pair
        pixels = None if color is None else _copied(color.data)
        return RawFrame(depth.time_s, _copied(depth.data), pixels)

    def _next(self, is_color: bool) -> StoredImage | None:
        """The next image of a stream; None once the camera is closed.

        Raises:
            InputError: the camera gives none.
        """
        kind = "color" if is_color else "depth"
        came, frame = self._queues[kind].try_wait_for_frame(round(1e3 * WAITS_S))
        if came:
            return StoredImage(frame.get_timestamp() / 1e3, is_color, frame)
        if not self._open:
            return None
        raise gone(self.name, f"{kind} image")

    def close(self) -> None:
        """As of `topview.live.DepthCamera`."""
        while self._open:
            sensor = self._open.pop()
            sensor.stop()
            sensor.close()

    def _found(self, serial: str) -> Any:
        devices = list(self._rs.context().query_devices())
        serials = [self._told(device, "serial_number") for device in devices]
        return devices[number_of("realsense", serial, serials)]

    def _told(self, device: Any, what: str) -> str:
        info = getattr(self._rs.camera_info, what)
        return device.get_info(info) if device.supports(info) else ""

    def _start(self, streams: dict[str, tuple[Any, Any]]) -> None:
        """Each stream into its queue; two streams of one sensor are told apart by their format."""
        sensors = {id(sensor): sensor for sensor, _ in streams.values()}
        try:
            for key, sensor in sensors.items():
                own = {kind: p for kind, (s, p) in streams.items() if id(s) == key}
                sensor.open(list(own.values()))
                queues = {own[kind].stream_type(): self._queues[kind] for kind in own}
                sensor.start(lambda frame, queues=queues: _put(frame, queues))
                self._open.append(sensor)
        except RuntimeError as error:  # another program has it
            self.close()
            raise InputError(f"{self.name}: cannot be started: {error}") from None


def _put(frame: Any, queues: dict[Any, Any]) -> None:
    """Called by the library's threads."""
    queue = queues.get(frame.get_profile().stream_type())
    if queue is not None:
        queue.enqueue(frame)


def _most_like(sensor: Any, format: Any) -> Any:
    """The sensor's stream of a format that is most like `SIZE_AND_RATE`; None without any."""
    profiles = [
        profile.as_video_stream_profile()
        for profile in sensor.get_stream_profiles()
        if profile.format() == format
    ]

    def unlike(profile: Any) -> int:
        given = profile.width(), profile.height(), profile.fps()
        return sum(abs(a - b) for a, b in zip(given, SIZE_AND_RATE, strict=True))

    return min(profiles, key=unlike, default=None)


def _camera(profile: Any, sensor: SensorName = "kinect1") -> Camera:
    """Raises InputError for a lens that is not known."""
    told = profile.get_intrinsics()
    coefficients = tuple(map(float, told.coeffs))
    lens = None
    if any(coefficients):
        lens = Distortion(known_lens(told.model.name, LENSES), coefficients)
    return Camera(
        told.fx, told.fy, told.ppx, told.ppy, told.width, told.height,
        distortion=lens, sensor=sensor,
    )  # fmt: skip


def _T(profile: Any, other: Any) -> NDArray[np.float64]:
    """[4, 4] from the one stream's camera to the other's, metres."""
    told = profile.get_extrinsics_to(other)
    rotation = np.array(told.rotation, np.float64).reshape(3, 3).T  # by columns
    return transform(rotation, np.array(told.translation, np.float64))


def _copied(frame: Any) -> NDArray[Any]:
    return np.asanyarray(frame.get_data()).copy()
