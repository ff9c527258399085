"""Depth images of any kind: 16-bit PNG, TIFF of 16 bits or of 32-bit floating point, OpenEXR.

What a TIFF or EXR claims of its size is read before it is decoded ("TIFF Revision 6.0", Adobe 1992,
Sec. 2; "OpenEXR File Layout"). Errors do not name the file: the caller does.
"""

from __future__ import annotations

import struct
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.io.readers.images import PNG_SIGNATURE, check_pixels, decode_depth_png, decoded
from topview.records import InputError

FLOAT_SUFFIXES: Final = (".tif", ".tiff", ".exr")
TIFF_ORDERS: Final = {b"II*\0": "<", b"MM\0*": ">"}
TIFF_WIDTH, TIFF_HEIGHT = 256, 257
TIFF_TYPES: Final = {3: "H", 4: "I"}
EXR_SIGNATURE: Final = b"\x76\x2f\x31\x01"
_EXR_WINDOW: Final = b"dataWindow\0box2i\0\x10\0\0\0"
_RIGHT: Final = "a depth image must be a 16-bit grey PNG, or a TIFF of 16 bits or 32-bit floats"


def decode_depth(data: bytes, width: int, height: int) -> NDArray[np.uint16] | NDArray[np.float32]:
    """[H, W] stored units, by what the file holds.

    Raises:
        InputError: no whole image with one channel of 16 bits or 32-bit floats, of this size.
    """
    if data[:4] in TIFF_ORDERS:
        size, what = _tiff_size(data), "TIFF"
    elif data.startswith(EXR_SIGNATURE):
        size, what = _exr_size(data), "OpenEXR"
    elif data.startswith(PNG_SIGNATURE) or not data:
        return decode_depth_png(data, width, height)
    else:
        raise InputError(f"starts with {data[:8]!r}; it must be a PNG image, or a TIFF one")
    check_pixels(*size)
    if size != (width, height):
        raise InputError(
            f"is {size[0]} x {size[1]} pixels; it must be {width} x {height}, as camera.json says"
        )
    image, said = decoded(data, cv2.IMREAD_UNCHANGED)
    if image is None or (what == "TIFF" and said):
        how = said or (
            "; OpenCV reads OpenEXR where OPENCV_IO_ENABLE_OPENEXR=1 is set"
            if what == "OpenEXR"
            else ""
        )
        raise InputError(f"cannot be decoded{how}; it must be a whole {what} image")
    if image.shape != (height, width) or image.dtype not in (np.uint16, np.float32):
        raise InputError(f"is {what} with {image.dtype} {image.shape}; {_RIGHT}")
    return np.ascontiguousarray(image)  # pyright: ignore[reportReturnType]


def _tiff_size(data: bytes) -> tuple[int, int]:
    """Width and height by the first directory."""
    order = TIFF_ORDERS[data[:4]]
    sides = dict[int, int]()
    try:
        (start,) = struct.unpack_from(order + "I", data, 4)
        (count,) = struct.unpack_from(order + "H", data, start)
        for at in range(start + 2, start + 2 + 12 * count, 12):
            tag, kind = struct.unpack_from(order + "HH", data, at)
            if tag in (TIFF_WIDTH, TIFF_HEIGHT) and kind in TIFF_TYPES:
                (sides[tag],) = struct.unpack_from(order + TIFF_TYPES[kind], data, at + 8)
    except struct.error:
        raise InputError(
            f"is truncated after {len(data)} bytes, or damaged; it must be a whole TIFF image"
        ) from None
    if len(sides) < 2:
        raise InputError("has no width and height; it must be a whole TIFF image")
    return sides[TIFF_WIDTH], sides[TIFF_HEIGHT]


def _exr_size(data: bytes) -> tuple[int, int]:
    at = data.find(_EXR_WINDOW)
    if at < 0 or len(data) < at + len(_EXR_WINDOW) + 16:
        raise InputError("has no data window; it must be a whole OpenEXR image")
    left, top, right, bottom = struct.unpack_from("<4i", data, at + len(_EXR_WINDOW))
    return right - left + 1, bottom - top + 1
