"""Depth and colour image files, checked before they are decoded.

OpenCV answers a broken file with None or with part of the picture, so the files' own structure is
checked first. Errors do not name the file: the caller does.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.io.readers.decoders_lines import decoders_lines
from topview.records import MAX_IMAGE_PIXELS, InputError

# PNG specification (W3C, third edition), 5.2 and 11.2.1.
PNG_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
PNG_COLOR_TYPES: Final = {0: "grey", 2: "RGB", 3: "palette", 4: "grey with alpha", 6: "RGBA"}
PNG_GREY: Final = 0
# ITU-T T.81, Table B.1. Inside the entropy-coded data 0xFF never comes before 0xD9 or 0xDA.
JPEG_SIGNATURE: Final = b"\xff\xd8"
JPEG_START_OF_SCAN: Final = b"\xff\xda"
JPEG_END_OF_IMAGE: Final = b"\xff\xd9"
JPEG_MARKER: Final = 0xFF
JPEG_FRAMES: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
JPEG_ALONE: Final = frozenset({0x01, *range(0xD0, 0xD8)})
# What libjpeg says where part of the picture is made up.
JPEG_DAMAGE: Final = ("premature end", "bad Huffman code", "Premature end")


@dataclass(frozen=True, slots=True)
class PngHeader:
    """Size in pixels, bits per channel and colour type of a PNG image."""

    width: int
    height: int
    bits: int
    color_type: int


def check_png(data: bytes) -> PngHeader:
    """The header of a whole and undamaged PNG file.

    Raises:
        InputError: empty, not PNG, truncated, or a chunk's checksum is wrong.
    """
    if not data:
        raise InputError("is empty (0 bytes); it must be a PNG image")
    if not data.startswith(PNG_SIGNATURE):
        raise InputError(f"starts with {data[:8]!r}; it must be a PNG image")
    view = memoryview(data)
    header: PngHeader | None = None
    start, kind = len(PNG_SIGNATURE), b""
    while kind != b"IEND":
        if start + 12 > len(data):
            raise InputError(f"is truncated after {len(data)} bytes; it must be a whole PNG image")
        length, kind = struct.unpack_from(">I4s", data, start)
        end = start + 12 + length
        if end > len(data):
            raise InputError(f"is truncated after {len(data)} bytes; it must be a whole PNG image")
        (checksum,) = struct.unpack_from(">I", data, end - 4)
        if zlib.crc32(view[start + 4 : end - 4]) != checksum:
            raise InputError(
                f"is damaged between bytes {start} and {end} (wrong checksum); "
                "it must be a whole PNG image"
            )
        if header is None:
            if kind != b"IHDR" or length != 13:
                raise InputError(f"begins with chunk {kind!r}; a PNG image begins with IHDR")
            header = PngHeader(*struct.unpack_from(">IIBB", data, start + 8))
        start = end
    if header is None:
        raise InputError("has no IHDR; it must be a whole PNG image")
    return header


def decode_depth_png(data: bytes, width: int, height: int) -> NDArray[np.uint16]:
    """[H, W] uint16 stored units.

    Raises:
        InputError: not a whole PNG image with one 16-bit channel and of the camera's size.
    """
    header = check_png(data)
    if header.bits != 16 or header.color_type != PNG_GREY:
        color = PNG_COLOR_TYPES.get(header.color_type, f"colour type {header.color_type}")
        raise InputError(
            f"is {header.bits}-bit {color}; a depth image must be 16-bit grey (one channel)"
        )
    if (header.width, header.height) != (width, height):
        raise InputError(
            f"is {header.width} x {header.height} pixels; "
            f"it must be {width} x {height}, as camera.json says"
        )
    image, said = decoded(data, cv2.IMREAD_UNCHANGED)
    if image is None or image.shape != (height, width) or image.dtype != np.uint16:
        raise InputError(f"cannot be decoded{said}; it must be a 16-bit PNG image")
    return image.astype(np.uint16, copy=False)


def decode_color(data: bytes) -> NDArray[np.uint8]:
    """[H, W, 3] uint8 RGB of a PNG or JPEG file, stored orientation kept.

    Raises:
        InputError: not a whole PNG or JPEG image.
    """
    if data.startswith(JPEG_SIGNATURE):
        if data.rfind(JPEG_END_OF_IMAGE) < data.rfind(JPEG_START_OF_SCAN):
            raise InputError(f"is truncated after {len(data)} bytes; it must be a whole JPEG image")
        check_pixels(*jpeg_size(data))
    else:
        header = check_png(data)
        check_pixels(header.width, header.height)
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    image, said = decoded(data, flags)
    if image is None or any(sign in said for sign in JPEG_DAMAGE):
        raise InputError(f"cannot be decoded{said}; it must be a whole PNG or JPEG image")
    return np.ascontiguousarray(image[..., ::-1], np.uint8)


def jpeg_size(data: bytes) -> tuple[int, int]:
    """Width and height of a JPEG file, by the first header of a frame; 0, 0 if it has none."""
    start = len(JPEG_SIGNATURE)
    while start + 9 <= len(data) and data[start] == JPEG_MARKER:
        kind = data[start + 1]
        if kind in JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", data, start + 5)
            return width, height
        if kind == JPEG_MARKER:  # fills
            start += 1
        elif kind in JPEG_ALONE:
            start += 2
        else:
            start += 2 + int.from_bytes(data[start + 2 : start + 4])
    return 0, 0


def check_pixels(width: int, height: int) -> None:
    """Before they are decoded: a small file may claim, and take, gigabytes."""
    if width * height > MAX_IMAGE_PIXELS:
        raise InputError(f"is {width} x {height} pixels; it must have at most {MAX_IMAGE_PIXELS}")


def decoded(data: bytes, flags: int) -> tuple[cv2.typing.MatLike | None, str]:
    """What OpenCV makes of a file, None where that is nothing, as of too many pixels; and what its
    libraries say of it, in brackets."""
    with decoders_lines() as said:
        try:
            image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
        except cv2.error:
            image = None
    return image, f" ({'; '.join(said)})" if said else ""
