"""Files: every error of one names it, and the one reader of `.npz` archives."""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from topview.records import InputError

MOST_UNPACKED_BYTES: Final = 2**33  # that the arrays of one archive unpack to; ours


@contextmanager
def naming(path: Path, doing: str = "read", right: str = "it must be a file") -> Iterator[None]:
    """Put the path before what goes wrong inside; the system's errors become one line too, which
    says what could not be done, why, and what would be right."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be {doing}: {error.strerror or error}; {right}") from None


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
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError(f"is no regular file; {right}")
        _check_sizes(path)
        with np.load(path, allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}
    except (InputError, OSError):
        raise
    except Exception as error:  # NumPy, zipfile and zlib raise a dozen kinds
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"is truncated or damaged ({reason}); {right}") from None


def _check_sizes(path: Path) -> None:
    """Refuse, before anything is unpacked, what claims more than there is or than is allowed."""
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        total = sum(member.file_size for member in members)
        if total > MOST_UNPACKED_BYTES:
            raise ValueError(f"it unpacks to {total} bytes, more than {MOST_UNPACKED_BYTES}")
        for member in members:
            with archive.open(member) as file:
                version = npy.read_magic(file)
                header = (
                    npy.read_array_header_1_0(file)
                    if version == (1, 0)
                    else npy.read_array_header_2_0(file)
                )
                shape, _, dtype = header
                claimed = int(np.prod(shape, dtype=object)) * dtype.itemsize
                if not dtype.hasobject and file.tell() + claimed != member.file_size:
                    raise ValueError(
                        f"{member.filename} says that it has {claimed} bytes of numbers; "
                        f"it has {member.file_size - file.tell()}"
                    )
