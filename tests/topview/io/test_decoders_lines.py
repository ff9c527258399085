"""What libpng, libjpeg and OpenCV print of a damaged image is a part of our line, not beside it."""

from __future__ import annotations

import os
import struct
import threading
import zlib
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from topview.io.readers.decoders_lines import decoders_lines
from topview.io.readers.images import decode_color, decode_depth_png
from topview.records import InputError

W, H = 64, 48
ROWS = b"".join(bytes(1 + 2 * W) for _ in range(H))
GOOD = zlib.compress(ROWS)


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(*chunks: bytes, bits: int = 16, color_type: int = 0, width: int = W) -> bytes:
    """With right checksums, whatever it holds."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, H, bits, color_type, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + b"".join(chunks) + chunk(b"IEND", b"")


BROKEN = {
    "no data": png(),
    "too few rows": png(chunk(b"IDAT", zlib.compress(ROWS[:100]))),
    "garbage": png(chunk(b"IDAT", b"garbage" * 10)),
    "cut": png(chunk(b"IDAT", GOOD[:-10])),
    "filter": png(chunk(b"IDAT", zlib.compress(b"\x09" * len(ROWS)))),
    "check": png(chunk(b"IDAT", GOOD[:-4] + b"abcd")),
    "critical": png(chunk(b"ABCD", b""), chunk(b"IDAT", GOOD)),
}


def depth(data: bytes) -> object:
    return decode_depth_png(data, W, H)


@pytest.mark.parametrize("decode", [depth, decode_color])
@pytest.mark.parametrize("name", BROKEN)
def test_a_damaged_png_is_one_line(
    name: str, decode: Callable[[bytes], object], capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match="cannot be decoded") as raised:
        decode(BROKEN[name])
    assert "\n" not in str(raised.value)
    assert capfd.readouterr() == ("", "")


def test_why_is_told() -> None:
    with pytest.raises(InputError, match="libpng error: Not enough image data"):
        depth(BROKEN["cut"])


@pytest.mark.parametrize(("bits", "color_type"), [(3, 0), (8, 3), (8, 2)])
def test_odd_colour_images(bits: int, color_type: int, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match="cannot be decoded"):
        decode_color(png(chunk(b"IDAT", GOOD), bits=bits, color_type=color_type))
    assert capfd.readouterr() == ("", "")


def test_a_colour_image_that_claims_too_much_is_refused_before_it_is_unpacked() -> None:
    with pytest.raises(InputError, match="is 100000000 x 48 pixels; it must have"):
        decode_color(png(chunk(b"IDAT", GOOD), bits=8, color_type=2, width=10**8))


def jpeg() -> bytes:
    noise = np.random.default_rng(0).integers(0, 255, (H, W, 3)).astype(np.uint8)
    return cv2.imencode(".jpg", noise)[1].tobytes()


def test_half_a_jpeg_is_no_image(capfd: pytest.CaptureFixture[str]) -> None:
    whole = jpeg()
    decode_color(whole)
    with pytest.raises(InputError, match="premature end of data segment"):
        decode_color(whole[: len(whole) // 2] + b"\xff\xd9")
    assert capfd.readouterr() == ("", "")


def test_what_a_warning_is_about_does_no_harm(capfd: pytest.CaptureFixture[str]) -> None:
    more = zlib.compress(ROWS + bytes(1000))
    assert np.array_equal(
        decode_depth_png(png(chunk(b"IDAT", more)), W, H), np.zeros((H, W), np.uint16)
    )
    assert capfd.readouterr() == ("", "")


def test_lines_of_others_come_through(capfd: pytest.CaptureFixture[str]) -> None:
    with decoders_lines() as said:
        os.write(2, b"libpng error: ours\nsomebody else's\n")
    assert said == ["libpng error: ours"]
    assert capfd.readouterr().err == "somebody else's\n"
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "after\n"


def test_half_a_line_waits_for_its_end(capfd: pytest.CaptureFixture[str]) -> None:
    """A kernel may show the first half of another thread's write before the second."""
    with decoders_lines() as said:
        os.write(2, b"libpng error: ours\nsomebody ")
    assert said == ["libpng error: ours"]
    assert capfd.readouterr().err == ""
    with decoders_lines() as said:
        os.write(2, b"else's\n")
    assert said == []
    assert capfd.readouterr().err == "somebody else's\n"


def decode_in_threads(others_lines: int) -> list[str]:
    """What four threads say of 200 cut images, while this one writes to stderr."""
    good, failures = png(chunk(b"IDAT", GOOD)), []

    def decode() -> None:
        for _ in range(50):
            depth(good)
            try:
                depth(BROKEN["cut"])
            except InputError as error:
                failures.append(str(error))

    threads = [threading.Thread(target=decode) for _ in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(others_lines):
        os.write(2, b"another thread's\n")
    for thread in threads:
        thread.join()
    return failures


def test_many_threads_decode(capfd: pytest.CaptureFixture[str]) -> None:
    failures = decode_in_threads(0)
    assert len(failures) == 200
    assert len(set(failures)) == 1
    assert capfd.readouterr() == ("", "")


def test_nothing_that_other_threads_write_is_lost(capfd: pytest.CaptureFixture[str]) -> None:
    """It may come in the middle of a decoder's line, which is written in two pieces."""
    failures = decode_in_threads(1000)
    assert len(failures) == 200
    depth(png(chunk(b"IDAT", GOOD)))  # what was written too late comes with the next image
    written = capfd.readouterr().err + "".join(failures)
    assert written.count("another thread's") == 1000


def test_without_stderr_images_are_decoded() -> None:
    kept = os.dup(2)
    os.close(2)
    try:
        depth(png(chunk(b"IDAT", GOOD)))
        with pytest.raises(InputError, match="cannot be decoded"):
            depth(BROKEN["cut"])
    finally:
        os.dup2(kept, 2)
        os.close(kept)
