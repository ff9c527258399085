"""Images of ROS messages: `sensor_msgs/Image` and `sensor_msgs/CompressedImage`.

Encodings are those of `sensor_msgs/image_encodings.hpp`; depth is millimetres in 16 bits or metres
in 32-bit floating point (REP 118). `compressedDepth` is a header of 12 bytes, then a PNG; of floats
it holds quantised inverse depth (`compressed_depth_image_transport`).
"""

from __future__ import annotations

import struct
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.images import check_pixels, check_png, decode_color, decoded
from topview.records import InputError

DEPTH_ENCODINGS: Final = {"16UC1": np.uint16, "mono16": np.uint16, "32FC1": np.float32}
"""`mono16` is RealSense's, and openni's, too."""
# Channels, and what OpenCV calls the way to RGB; None is no change.
COLOR_ENCODINGS: Final[dict[str, tuple[int, int | None]]] = {
    "rgb8": (3, None),
    "8UC3": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
    "8UC1": (1, cv2.COLOR_GRAY2RGB),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2RGB_YUY2),
    "yuv422": (2, cv2.COLOR_YUV2RGB_UYVY),
}
COMPRESSED_DEPTH_HEADER: Final = struct.Struct("<iff")  # format, and the two of the quantisation


def is_depth(message: Any) -> bool:
    """Whether an image message is depth, by its encoding."""
    if hasattr(message, "encoding"):
        return message.encoding in DEPTH_ENCODINGS
    return "compressedDepth" in message.format


def is_float(message: Any) -> bool:
    """Whether depth is in metres, in 32-bit floating point."""
    return "32FC1" in getattr(message, "encoding", getattr(message, "format", ""))


def is_color(message: Any) -> bool:
    """Whether an image message is colour, or shades of grey."""
    if hasattr(message, "encoding"):
        return message.encoding in COLOR_ENCODINGS
    return not is_depth(message)


def image_depth_m(
    message: Any, metres_per_unit: float = METRES_PER_MILLIMETRE
) -> NDArray[np.float32]:
    """[H, W] metres of an Image or CompressedImage message.

    Args:
        message: as rosbags gives it.
        metres_per_unit: of 16-bit depth.

    Raises:
        InputError: another encoding, or not whole.
    """
    if not hasattr(message, "encoding"):
        return _compressed_depth_m(message, metres_per_unit)
    dtype = DEPTH_ENCODINGS.get(message.encoding)
    if dtype is None:
        right = ", ".join(DEPTH_ENCODINGS)
        raise InputError(f"encoding is {message.encoding!r}; depth must be one of {right}")
    stored = _rows(message, np.dtype(dtype), 1)[..., 0]
    return depth_image(stored, 1.0 if stored.dtype == np.float32 else metres_per_unit)


def image_color(message: Any) -> NDArray[np.uint8]:
    """[H, W, 3] RGB of an Image or CompressedImage message.

    Raises:
        InputError: another encoding, or not whole.
    """
    if not hasattr(message, "encoding"):
        return decode_color(bytes(message.data))
    if message.encoding not in COLOR_ENCODINGS:
        right = ", ".join(COLOR_ENCODINGS)
        raise InputError(f"encoding is {message.encoding!r}; colour must be one of {right}")
    channels, conversion = COLOR_ENCODINGS[message.encoding]
    stored = np.ascontiguousarray(_rows(message, np.dtype(np.uint8), channels))
    if conversion is None:
        return stored
    return np.asarray(cv2.cvtColor(stored, conversion), np.uint8)


def _rows(message: Any, dtype: np.dtype[Any], channels: int) -> NDArray[Any]:
    """[H, W, channels] of the bytes of an image, whatever its rows are padded with."""
    height, width, step = int(message.height), int(message.width), int(message.step)
    check_pixels(width, height)
    row = width * channels * dtype.itemsize
    data = np.asarray(message.data, np.uint8)
    if not (row > 0 and step >= row and data.size >= step * (height - 1) + row and height > 0):
        raise InputError(
            f"is {width} x {height} pixels of {message.encoding} with {data.size} bytes, {step} a "
            f"row; it must have at least {row} a row"
        )
    stored = dtype.newbyteorder(">" if message.is_bigendian else "<")
    image = np.ndarray(
        (height, width, channels), stored, data, strides=(step, row // width, dtype.itemsize)
    )
    return image.astype(dtype)


def _compressed_depth_m(message: Any, metres_per_unit: float) -> NDArray[np.float32]:
    data = bytes(message.data)
    png = data[COMPRESSED_DEPTH_HEADER.size :]
    if "rvl" in message.format:
        raise InputError(f"format is {message.format!r}; depth must be compressed as PNG, not RVL")
    header = check_png(png)
    check_pixels(header.width, header.height)
    image, said = decoded(png, cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 2 or image.dtype != np.uint16:
        raise InputError(f"cannot be decoded{said}; it must be a PNG image of 16 bits")
    if not is_float(message):
        return depth_image(image, metres_per_unit)
    _, scale, offset = COMPRESSED_DEPTH_HEADER.unpack_from(data)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        depth_m = scale / (image.astype(np.float32) - offset)
    return depth_image(np.where(image > 0, depth_m, 0.0), 1.0)
