"""Luxonis's OAK cameras, by depthai 3 (the extra `oak`).

Written after depthai's types, its examples and its own `RGBD` node, and tested against a stand-in
for it: no camera was at hand. The camera itself registers the depth to the colour image and takes
the lens out of both.
"""

from __future__ import annotations

from datetime import timedelta
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.io.readers.depth import METRES_PER_MILLIMETRE
from topview.io.writers.extras import needed
from topview.live.camera import RawFrame
from topview.live.sdk import WAITS_S, gone, number_of
from topview.records import Camera, InputError

SIZE: Final = (640, 400)  # pixels; ours: what the stereo cameras give whole
FPS: Final = 30.0  # ours
MOST_WAITING_FRAMES: Final = 2  # ours; the oldest is dropped first


class OakCamera:
    """As `topview.live.DepthCamera`.

    Args:
        serial: of the camera, depthai's `deviceId`; empty for the first there is.

    Raises:
        InputError: depthai is missing, there is no such camera, or it gives no depth.
    """

    color = None  # registered by the camera
    metres_per_unit = METRES_PER_MILLIMETRE
    fps = FPS

    def __init__(self, serial: str = "") -> None:
        self._dai = needed("depthai", "oak:", "oak")
        self.name, self._is_open = "OAK", True
        self._device = self._opened(serial)
        self._pipeline = self._dai.Pipeline(self._device)
        try:
            self.name = str(self._device.getDeviceName())
            is_tof = self._build()
            self._pipeline.start()
            self.camera = _camera(self._images() or {}, is_tof)
        except Exception as error:  # RuntimeError of most, and errors of depthai's own
            self.close()
            if isinstance(error, InputError):
                raise
            raise InputError(f"{self.name}: cannot be started: {error}") from None

    def read(self) -> RawFrame | None:
        """As of `topview.live.DepthCamera`."""
        images = self._images()
        if images is None:
            return None
        depth = images["depth"]
        return RawFrame(
            depth.getTimestampDevice().total_seconds(),
            _pixels(depth, np.uint16),
            _pixels(images["color"], np.uint8) if "color" in images else None,
        )

    def close(self) -> None:
        """As of `topview.live.DepthCamera`."""
        if self._is_open:
            self._is_open = False
            self._pipeline.stop()
            self._device.close()

    def _images(self) -> dict[str, Any] | None:
        """Depth, and colour where the camera has it; None once it is closed."""
        try:
            group = self._queue.get(timedelta(seconds=WAITS_S))
        except Exception:  # the queue is closed, by `close` or by the camera's end
            if self._is_open:
                raise
            return None
        if group is None and self._is_open:
            raise gone(self.name)
        return None if group is None else {name: group[name] for name in group.getMessageNames()}

    def _opened(self, serial: str) -> Any:
        there = self._dai.Device.getAllAvailableDevices()
        which = number_of("oak", serial, [str(info.getDeviceId()) for info in there])
        try:
            return self._dai.Device(there[which])
        except RuntimeError as error:
            raise InputError(f"oak:{serial} cannot be opened: {error}") from None

    def _build(self) -> bool:
        """Wire depth and colour to a queue of both; whether depth is by time of flight."""
        kinds = self._dai.CameraSensorType
        sockets = {
            kind: features.socket
            for features in reversed(self._device.getConnectedCameraFeatures())
            for kind in features.supportedTypes
        }
        node, make = self._dai.node, self._pipeline.create
        together = make(node.Sync)
        together.setSyncThreshold(timedelta(seconds=0.5 / FPS))
        is_tof = kinds.TOF in sockets
        together.setRunOnHost(is_tof)  # where its depth is registered
        if is_tof:
            source = make(node.ToF).build(sockets[kinds.TOF], fps=FPS)
        else:
            source = make(node.StereoDepth).build(True, size=SIZE, fps=FPS)
        depth = source.depth
        if kinds.COLOR in sockets:
            color = make(node.Camera).build(sockets[kinds.COLOR])
            pixels = color.requestOutput(
                SIZE, self._dai.ImgFrame.Type.RGB888i, fps=FPS, enableUndistortion=True
            )
            pixels.link(together.inputs["color"])
            depth = self._registered(source, pixels, is_tof)
        depth.link(together.inputs["depth"])
        self._queue = together.out.createOutputQueue(maxSize=MOST_WAITING_FRAMES, blocking=False)
        return is_tof

    def _registered(self, source: Any, pixels: Any, is_tof: bool) -> Any:
        """The output that has depth in the colour image's pixels, as depthai's `RGBD` wires it."""
        if not is_tof and self._device.getPlatform() != self._dai.Platform.RVC4:
            pixels.link(source.inputAlignTo)
            return source.depth
        align = self._pipeline.create(self._dai.node.ImageAlign)
        if is_tof:
            align.setRunOnHost(True)
        source.depth.link(align.input)
        pixels.link(align.inputAlignTo)
        return align.outputAligned


def _camera(images: dict[str, Any], is_tof: bool) -> Camera:
    """Of depth and colour, by what they say themselves.

    Raises:
        InputError: depth is not registered to the colour.
    """
    depth = images["depth"]
    told = images.get("color", depth)
    sizes = [(image.getWidth(), image.getHeight()) for image in (depth, told)]
    if sizes[0] != sizes[1]:
        raise InputError(
            f"depth has {sizes[0][0]} x {sizes[0][1]} pixels and colour {sizes[1][0]} x "
            f"{sizes[1][1]}; the camera must register them"
        )
    K = np.asarray(told.getTransformation().getIntrinsicMatrix(), np.float64)
    sensor = "tof" if is_tof else "stereo"
    fx, fy, cx, cy = (float(K[at]) for at in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return Camera(fx, fy, cx, cy, *sizes[0], sensor=sensor)


def _pixels(image: Any, dtype: type[Any]) -> NDArray[Any]:
    return np.array(image.getFrame(), dtype)
