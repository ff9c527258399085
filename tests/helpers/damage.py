"""Files cut short, and with single bits flipped, always in the same places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np


def cut(data: bytes, count: int = 20) -> Iterator[bytes]:
    """The first part of a file, of so many random lengths."""
    for length in np.random.default_rng(0).integers(0, len(data), count).tolist():
        yield data[:length]


def flipped(data: bytes, count: int = 20) -> Iterator[bytes]:
    """A file with one random bit flipped, so many times."""
    rng = np.random.default_rng(1)
    for at, bit in zip(rng.integers(0, len(data), count), rng.integers(0, 8, count), strict=True):
        spoiled = bytearray(data)
        spoiled[at] ^= 1 << int(bit)
        yield bytes(spoiled)
