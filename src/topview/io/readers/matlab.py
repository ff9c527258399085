"""Variables of MATLAB's `.mat` files, unpacked within bounds.

"MATLAB MAT-File Format" (MathWorks): a version 5 file is a header of 128 bytes, then elements, each
after its type and size of 4 bytes each; an element of type 15 is another one, deflated. SciPy
inflates without a bound, so that is done here; what it then reads is not packed.
"""

from __future__ import annotations

import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat, whosmat

from topview.files import MOST_BYTES, naming, read_bytes
from topview.records import InputError

_HEADER_BYTES: Final = 128
_VERSION_5: Final = {b"\x00\x01IM": "<", b"\x01\x00MI": ">"}  # how numbers are stored
_COMPRESSED: Final = 15
_NUMBERS: Final = (
    "double", "single", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64",
)  # fmt: skip


def read_variable(
    path: Path, name: str, shape: tuple[int | None, ...], expected: str
) -> NDArray[Any]:
    """A real numeric array of a `.mat` file.

    Args:
        path: of the file.
        name: of the variable.
        shape: that it must have; None for any length above 0.
        expected: what the file should be, for errors.

    Raises:
        InputError: the file is missing, damaged, too large when it is unpacked or of version 7.3,
            or has no such variable.
    """
    with naming(path):
        data = read_bytes(path, right=f"it must be {expected}")
        try:
            data = _inflated(data)
            variables = {about[0]: about[1:] for about in whosmat(BytesIO(data))}
            _check(variables, name, shape, expected)
            array = np.asarray(loadmat(BytesIO(data), variable_names=[name])[name])
        except NotImplementedError:
            raise InputError(f"is a MATLAB 7.3 file; it must be {expected}") from None
        except InputError:
            raise
        # A broken file makes scipy raise nearly anything: OSError, IndexError, zlib.error,
        # MatReadError, TypeError, ValueError, MemoryError.
        except Exception as error:
            raise InputError(
                f"is truncated or damaged ({_one_line(error)}); it must be {expected}"
            ) from None
        if array.dtype.kind not in "uif" or not _fits(array.shape, shape):
            raise _wrong(name, str(array.dtype), array.shape, shape)
        return array


def _inflated(data: bytes) -> bytes:
    """The same file with no element packed."""
    order = _VERSION_5.get(data[_HEADER_BYTES - 4 : _HEADER_BYTES])
    if order is None:  # another version, of which none packs its elements in this way
        return data
    parts = [data[:_HEADER_BYTES]]
    start, left = _HEADER_BYTES, MOST_BYTES
    while start < len(data):
        kind, size = struct.unpack_from(order + "II", data, start)
        end = start + 8 + size
        if end > len(data):
            raise ValueError(f"it ends after {len(data)} bytes, in the middle of an element")
        element = data[start:end]
        if kind == _COMPRESSED:
            element = _inflated_element(data[start + 8 : end], order, left)
        parts.append(element)
        left -= len(element)
        start = end
    return b"".join(parts)


def _inflated_element(packed: bytes, order: str, at_most: int) -> bytes:
    """One element, whose own size is read before the rest is inflated."""
    inflating = zlib.decompressobj()
    tag = inflating.decompress(packed, 8)
    _, size = struct.unpack(order + "II", tag)
    if 8 + size > at_most:
        raise InputError(f"unpacks to more than {MOST_BYTES} bytes; it must be at most so many")
    content = inflating.decompress(inflating.unconsumed_tail, size + 1)
    if len(content) != size or not inflating.eof:
        raise ValueError(f"a packed element has another size than the {size} bytes that it says")
    return tag + content


def _check(
    variables: dict[str, Any], name: str, shape: tuple[int | None, ...], expected: str
) -> None:
    """Refuse another variable before it is read."""
    if name not in variables:
        names = ", ".join(variables) or "none"
        raise InputError(f"has no variable {name} (it has {names}); it must be {expected}")
    have, kind = variables[name]
    if kind not in _NUMBERS or not _fits(have, shape):
        raise _wrong(name, kind, have, shape)


def _fits(have: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(have) == len(wanted) and all(
        side == want if want else side > 0 for side, want in zip(have, wanted, strict=True)
    )


def _wrong(
    name: str, kind: str, have: tuple[int, ...], wanted: tuple[int | None, ...]
) -> InputError:
    size = " x ".join(str(side or "frames") for side in wanted)
    return InputError(f"{name} is {kind} {have}; it must be numbers, {size}")


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
