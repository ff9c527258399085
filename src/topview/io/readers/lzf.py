"""LibLZF decompression (Marc Lehmann, liblzf 3.6, `lzf_d.c`), as `.pcd` files use it."""

from __future__ import annotations

from topview.records import InputError

MAX_LITERALS = 32
LONG_MATCH = 7  # a match this long in the control byte goes on in the next byte


def lzf_decompress(data: bytes, size: int) -> bytes:
    """The `size` bytes that `data` stands for.

    Raises:
        InputError: damaged, or it stands for another number of bytes.
    """
    out = bytearray()
    position = 0
    try:
        while position < len(data) and len(out) <= size:
            control = data[position]
            position += 1
            if control < MAX_LITERALS:
                literals = data[position : position + control + 1]
                out += literals
                position += control + 1
                continue
            length = control >> 5
            if length == LONG_MATCH:
                length += data[position]
                position += 1
            length += 2
            distance = ((control & 31) << 8 | data[position]) + 1
            position += 1
            if distance > len(out):
                raise InputError(f"is damaged: a match reaches {distance} bytes back")
            pattern = out[len(out) - distance :][:length]
            # A match may run into the bytes that it makes: they repeat.
            out += (pattern * (length // len(pattern) + 1))[:length]
    except IndexError:
        raise InputError("is damaged: its compressed points end in the middle") from None
    if len(out) != size:
        raise InputError(f"is damaged: it decompresses to {len(out)} bytes; it must be {size}")
    return bytes(out)
