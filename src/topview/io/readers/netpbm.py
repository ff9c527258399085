"""Raw PGM and PPM images (Netpbm, formats P5 and P6), checked before they are decoded.

https://netpbm.sourceforge.net/doc/pgm.html. Errors do not name the file: the caller does.
"""

from __future__ import annotations

import re
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.records import InputError

_SPACE: Final = rb"(?:\s|#[^\n]*\n)+"
_HEADER: Final = re.compile(
    rb"P([56])" + _SPACE + rb"(\d{1,5})" + _SPACE + rb"(\d{1,5})" + _SPACE + rb"(\d{1,5})\s"
)


def decode_netpbm(data: bytes) -> NDArray[Any]:
    """[H, W] of a PGM or [H, W, 3] RGB of a PPM file: uint8, or uint16 where values go beyond 255.

    Raises:
        InputError: not a whole raw PGM or PPM image.
    """
    header = _HEADER.match(data)
    if header is None:
        raise InputError(f"starts with {data[:8]!r}; it must be a raw PGM (P5) or PPM (P6) image")
    channels = 3 if header[1] == b"6" else 1
    width, height, greatest = (int(header[i]) for i in (2, 3, 4))
    # Two bytes have the most significant one first.
    dtype = np.dtype(">u2" if greatest > 255 else "u1")
    wanted = width * height * channels * dtype.itemsize
    if greatest > 65535 or not wanted:
        raise InputError(
            f"is {width} x {height} with values up to {greatest}; "
            "it must have pixels, with values up to 255 or 65535"
        )
    if len(data) - header.end() < wanted:
        raise InputError(
            f"is truncated: {len(data) - header.end()} bytes of pixels; "
            f"{width} x {height} must have {wanted}"
        )
    values = np.frombuffer(data, dtype, width * height * channels, header.end())
    image = values.astype(dtype.newbyteorder("="))
    return image.reshape((height, width, 3) if channels == 3 else (height, width))
