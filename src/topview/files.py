"""Files: every error of one names it, nothing is waited for or read without a bound, and the one
reader of `.npz` archives."""

from __future__ import annotations

import os
import stat
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from topview.records import InputError

MOST_UNPACKED_BYTES: Final = 2**33  # that the arrays of one archive unpack to; ours
# Ours: of a file that is read whole, and of what it unpacks to; the longest of the data sets that
# are read whole, 125 frames of UTD-MHAD, has a twenty-fifth.
MOST_BYTES: Final = 2**29
MOST_TEXT_BYTES: Final = 2**27  # ours; of a text that is read whole and taken apart
DIGEST_LETTERS: Final = 16  # ours; of the SHA-256 that tells two files apart


@contextmanager
def naming(path: Path, doing: str = "read", right: str = "it must be a file") -> Iterator[None]:
    """Put the path before what goes wrong inside; the system's errors become one line too, which
    says what could not be done, why, and what would be right."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be {doing}: {error.strerror or error}; {right}") from None


@contextmanager
def unharmed(right: str, *but: type[Exception]) -> Iterator[None]:
    """Libraries raise dozens of kinds of errors for what is damaged: each becomes one line, which
    does not name the file; those that are named go on as they are."""
    try:
        yield
    except (InputError, *but):
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"is truncated or damaged ({reason}); {right}") from None


def check_regular(path: Path, right: str = "it must be one") -> None:
    """Refuse what would be waited for, or never ends: pipes, sockets, devices; folders, too. Errors
    do not name the file.

    Raises:
        InputError: no regular file.
        OSError: missing, or the system cannot tell.
    """
    if not stat.S_ISREG(path.stat().st_mode):
        raise InputError(f"is no regular file; {right}")


def read_bytes(path: Path, at_most: int = MOST_BYTES, right: str = "it must be one") -> bytes:
    """A whole file. Errors do not name it: `naming` does.

    Args:
        path: of a regular file.
        at_most: bytes that it may have.
        right: what the file should be, for the error.

    Raises:
        InputError: no regular file, or a larger one.
        OSError: missing, or the system cannot read it.
    """
    check_regular(path, right)
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > at_most:
            raise InputError(f"has {size} bytes; it must have at most {at_most}")
        return file.read(size)  # not to its end: it may grow meanwhile


def file_as_json(path: Path, data: bytes) -> dict[str, str]:
    """Which file this is, in JSON types: its name and the start of its data's SHA-256."""
    return {"name": path.name, "sha256": sha256(data).hexdigest()[:DIGEST_LETTERS]}


def read_text(path: Path, encoding: str = "latin-1", right: str = "it must be text") -> str:
    """A whole text, whatever ends its lines; as `read_bytes`."""
    data = read_bytes(path, MOST_TEXT_BYTES, right)
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        raise InputError(f"is not text; {right}") from None


def read_archive(path: Path, right: str = "it must be an .npz archive") -> dict[str, NDArray[Any]]:
    """All arrays of an archive by name; nothing is ever unpickled. Its errors do not name the file:
    `naming` does.

    Args:
        path: of the archive, a regular file.
        right: what the file should be, for the error.

    Raises:
        InputError: no regular file, no archive, encrypted, truncated, damaged, or its arrays are
            larger than they say or than `MOST_UNPACKED_BYTES`.
        OSError: missing, or the system cannot read it.
    """
    with Archive(path, right) as archive:
        archive.check_total()
        return {key: archive.read(key) for key in archive}


class Archive:
    """An `.npz`, of which arrays are read as a whole or in blocks of rows; it is a context manager.

    Arguments and errors are those of `read_archive`; all methods raise them.
    """

    def __init__(self, path: Path, right: str = "it must be an .npz archive") -> None:
        self._right = right
        check_regular(path, right)
        with unharmed(self._right, OSError):
            self._zip = zipfile.ZipFile(path)
        self._members = {info.filename.removesuffix(".npy"): info for info in self._zip.filelist}

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __contains__(self, key: object) -> bool:
        return key in self._members

    def check_total(self) -> None:
        """Refuse, before anything is unpacked, what claims more than there is or is allowed."""
        with unharmed(self._right, OSError):
            _check_size(sum(info.file_size for info in self._members.values()))
            for info in self._members.values():
                with self._zip.open(info) as member:
                    _read_header(member, info)

    def shape(self, key: str) -> tuple[int, ...]:
        """Of an array."""
        with unharmed(self._right, OSError), self._zip.open(self._members[key]) as member:
            return _read_header(member, self._members[key])[0]

    def read(self, key: str) -> NDArray[Any]:
        """A whole array."""
        info = self._members[key]
        with unharmed(self._right, OSError):
            _check_size(info.file_size)
            with self._zip.open(info) as member:
                _read_header(member, info)
            with self._zip.open(info) as member:
                return npy.read_array(member, allow_pickle=False)

    def blocks(self, key: str, rows: int | None) -> Iterator[NDArray[Any]]:
        """An array, so many rows at a time, or all; at least one block."""
        info = self._members[key]
        with unharmed(self._right, OSError), self._zip.open(info) as member:
            shape, is_fortran, dtype = _read_header(member, info)
            if is_fortran or dtype.hasobject or not shape:
                raise ValueError(f"{info.filename} cannot be read row by row")
            row_bytes = dtype.itemsize * int(np.prod(shape[1:], dtype=object))
            _check_size(row_bytes * min(rows or shape[0], shape[0]))
            for start in range(0, max(shape[0], 1), rows or max(shape[0], 1)):
                count = min(rows or shape[0], shape[0] - start)
                data = member.read(count * row_bytes)
                yield np.frombuffer(data, dtype).reshape(count, *shape[1:])


def _check_size(total: int) -> None:
    if total > MOST_UNPACKED_BYTES:
        raise ValueError(f"it unpacks to {total} bytes, more than {MOST_UNPACKED_BYTES}")


def _read_header(
    member: IO[bytes], info: zipfile.ZipInfo
) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether in Fortran's order, and type; they must fit the member's size."""
    version = npy.read_magic(member)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, is_fortran, dtype = read(member)
    claimed = int(np.prod(shape, dtype=object)) * dtype.itemsize
    if not dtype.hasobject and member.tell() + claimed != info.file_size:
        raise ValueError(
            f"{info.filename} says that it has {claimed} bytes of numbers; "
            f"it has {info.file_size - member.tell()}"
        )
    return shape, is_fortran, dtype
