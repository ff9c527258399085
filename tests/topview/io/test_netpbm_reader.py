"""Raw PGM and PPM images."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from topview.io.readers.netpbm import decode_netpbm
from topview.records import InputError


@given(arrays(np.uint16, st.tuples(st.integers(1, 5), st.integers(1, 5))))
def test_depth_comes_back(image: np.ndarray) -> None:
    H, W = image.shape
    data = f"P5\n# a comment\n{W} {H}\n65535\n".encode() + image.astype(">u2").tobytes()
    np.testing.assert_array_equal(decode_netpbm(data), image)


@given(arrays(np.uint8, st.tuples(st.integers(1, 5), st.integers(1, 5), st.just(3))))
def test_colour_comes_back(image: np.ndarray) -> None:
    H, W = image.shape[:2]
    decoded = decode_netpbm(f"P6 {W} {H} 255 ".encode() + image.tobytes())
    np.testing.assert_array_equal(decoded, image)
    assert decoded.dtype == np.uint8


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "starts with b''"),
        (b"P2 1 1 255 7", "must be a raw PGM"),
        (b"P5 2 2 255 abc", "is truncated: 3 bytes of pixels; 2 x 2 must have 4"),
        (b"P5 0 2 255 ", "is 0 x 2"),
        (b"P5 2 2 70000 abcdefgh", "values up to 70000"),
    ],
)
def test_what_is_broken_is_named(data: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        decode_netpbm(data)
