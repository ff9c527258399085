"""Matroska of an Azure Kinect or an Orbbec Femto, as `k4arecorder` writes it, by the library PyAV.

https://learn.microsoft.com/azure/kinect-dk/record-file-format: a track DEPTH of raw 16-bit images,
most significant byte first, in millimetres; a track COLOR as MJPEG, NV12 or YUY2; an attached
`calibration.json`. Only the container is left to PyAV: images are taken as they are stored.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.files import check_regular, naming
from topview.io.readers.azure_calibration import AzureCalibration
from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.gravity import BEGINNING_S, MOST_SAMPLES, levelled_by
from topview.io.readers.images import decode_color
from topview.io.readers.pairing import StoredImage
from topview.io.readers.rig import Rig
from topview.io.readers.stream_recording import StreamRecording
from topview.records import InputError

MATROSKA_SIGNATURE: Final = b"\x1aE\xdf\xa3"
MOST_UNTOLD_S: Final = 0.5  # ours; of a recording's length, after its last image
CALIBRATION_NAME: Final = "calibration.json"
# Of raw colour: what OpenCV calls the way to RGB, rows of bytes a row of pixels, bytes a column.
RAW_COLORS: Final[dict[str, tuple[int, float, int]]] = {
    "nv12": (cv2.COLOR_YUV2RGB_NV12, 1.5, 1),
    "yuyv422": (cv2.COLOR_YUV2RGB_YUY2, 1.0, 2),
    "bgra": (cv2.COLOR_BGRA2RGB, 1.0, 4),
}
# Of the track IMU; little-endian, m/s^2 and rad/s.
IMU_SAMPLE: Final = np.dtype(
    [("time", "<u8"), ("acceleration", "<f4", 3), ("turn_time", "<u8"), ("turn", "<f4", 3)]
)
_RIGHT: Final = "it must be a whole Matroska file of an Azure Kinect"


def recognises(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(MATROSKA_SIGNATURE)) == MATROSKA_SIGNATURE


class AzureRecording(StreamRecording):
    """The frames of one file; colour is registered to the depth.

    Attributes:
        length_s: seconds, as the file says; None if it does not.

    Raises:
        InputError: no Matroska, without depth or calibration; or PyAV is not installed.
    """

    def __init__(self, path: Path) -> None:
        problems: list[str] = []
        with naming(path), _opened(path) as container:
            tracks = _tracks(container)
            if "DEPTH" not in tracks:
                held = ", ".join(
                    f"{s.type} {s.codec_context.name}" for s in container.streams.video
                )
                raise InputError(f"has no track of depth; it holds {held or 'no images'}; {_RIGHT}")
            calibration = _calibration(container)
            depth, color = tracks["DEPTH"].codec_context, tracks.get("COLOR")
            with naming(Path(CALIBRATION_NAME)):
                camera = calibration.depth_camera(depth.width, depth.height)
                R = calibration.R_depth_accelerometer()
                size = (
                    () if color is None else (color.codec_context.width, color.codec_context.height)
                )
                color_camera = calibration.color_camera(*size) if size else None
                if R is not None:
                    told = _accelerations(container, tracks["DEPTH"])
                    camera = levelled_by(camera, told, R, problems)
                rig = Rig(camera, color_camera, CALIBRATION_NAME)
            if color_camera is None:
                problems.append("has no colour images, or no calibration of theirs")
            else:
                self._color_size = color_camera.camera.width, color_camera.camera.height
                self._color_codec = color.codec_context.name if color else ""
                self._color_format = color.codec_context.pix_fmt if color else ""
            self._has_color = color_camera is not None
            self.length_s = None if container.duration is None else container.duration / 1e6
        super().__init__(path, rig, None)
        self.problems += problems

    def images(self) -> Iterator[StoredImage]:
        with _opened(self.path) as container:
            tracks = _tracks(container)
            wanted = [tracks["DEPTH"], *([tracks["COLOR"]] if self._has_color else [])]
            time_s = 0.0
            for packet in container.demux(wanted):
                if packet.size and packet.pts is not None:
                    is_color = packet.stream.index != tracks["DEPTH"].index
                    time_s = float(packet.pts * packet.time_base)
                    yield StoredImage(time_s, is_color, bytes(packet))
        if self.length_s is not None and self.length_s - time_s > MOST_UNTOLD_S:
            raise InputError(
                f"ends after {time_s:.1f} s of the {self.length_s:.1f} s that it says; {_RIGHT}"
            )

    def depth_m(self, data: bytes) -> NDArray[np.float32]:
        shape = (self.camera.height, self.camera.width)
        if len(data) != 2 * shape[0] * shape[1]:
            raise InputError(
                f"depth has {len(data)} bytes; it must have {2 * shape[0] * shape[1]}, two a pixel"
            )
        return depth_image(np.frombuffer(data, ">u2").reshape(shape), METRES_PER_MILLIMETRE)

    def color(self, data: bytes) -> NDArray[np.uint8]:
        if self._color_codec == "mjpeg":
            return decode_color(data)
        if self._color_format not in RAW_COLORS:
            raise InputError(
                f"is {self._color_codec} {self._color_format}; it must be MJPEG, NV12, YUY2 or BGRA"
            )
        conversion, rows, channels = RAW_COLORS[self._color_format]
        width, height = self._color_size
        shape = (round(height * rows), width, channels)
        if len(data) != int(np.prod(shape)):
            raise InputError(f"has {len(data)} bytes; it must have {int(np.prod(shape))}")
        return np.asarray(
            cv2.cvtColor(np.frombuffer(data, np.uint8).reshape(shape), conversion), np.uint8
        )


def _tracks(container: Any) -> dict[str, Any]:
    """By their titles; infrared is like depth but for that."""
    return {video.metadata.get("title", ""): video for video in container.streams.video}


def _accelerations(container: Any, depth: Any) -> list[NDArray[np.float64]]:
    """[3] each, m/s^2 in the sensor's frame, of the recording's beginning; none where it is
    damaged."""
    from av.error import FFmpegError

    tracks = [s for s in container.streams if s.metadata.get("title") == "IMU"]
    samples: list[NDArray[np.float64]] = []
    try:
        for packet in container.demux([*tracks, depth]) if tracks else ():
            if packet.stream.index != depth.index:
                data = bytes(packet)
                whole = len(data) // IMU_SAMPLE.itemsize * IMU_SAMPLE.itemsize
                samples += list(np.frombuffer(data[:whole], IMU_SAMPLE)["acceleration"])
            is_past = packet.pts is not None and packet.pts * packet.time_base > BEGINNING_S
            if is_past or len(samples) > MOST_SAMPLES:
                break
    except FFmpegError:  # whoever reads the frames is told
        return samples
    return samples


def _calibration(container: Any) -> AzureCalibration:
    for stream in container.streams:
        if stream.type == "attachment" and stream.name == CALIBRATION_NAME:
            with naming(Path(CALIBRATION_NAME)):
                return AzureCalibration(bytes(stream.data))
    raise InputError(f"has no {CALIBRATION_NAME} attached; {_RIGHT}")


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A container; errors do not name the file."""
    check_regular(path)
    try:
        import av
        from av.error import FFmpegError
    except ImportError:
        raise InputError(
            "Azure Kinect recordings need PyAV; install it with: pip install 'topview[mkv]'"
        ) from None
    try:
        with av.open(str(path), format="matroska") as container:
            yield container
    except (FFmpegError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(getattr(error, "strerror", None) or error).split())
        raise InputError(f"is truncated or damaged ({reason}); {_RIGHT}") from None
