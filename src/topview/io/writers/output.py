"""Output files appear whole or not at all."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from os import PathLike
from pathlib import Path
from time import time
from typing import BinaryIO, Final

from topview.files import naming

HAS_ROOM: Final = "it must be a place with room and leave to write"
TEMPORARY: Final = re.compile(r"\.(.+)\.([0-9]{1,9})\.part")  # of which output; whose process
LEFT_OVER_S: Final = 60.0  # ours: who writes a file touches it more often


@contextmanager
def written_atomically(path: Path) -> Iterator[BinaryIO]:
    """A temporary file beside `path` to write to, renamed at the end; no half file is left,
    whatever happens.

    Raises:
        InputError: full disk, no permission, a folder in the file's place; names the path and why.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    with naming(path, "written", HAS_ROOM):
        try:
            with temporary.open("wb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())  # a full disk may show only here
            os.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise


def write_atomically(path: Path, data: bytes) -> None:
    """The same of what is in memory already."""
    with written_atomically(path) as file:
        file.write(data)


def write_made(path: Path, make: Callable[[], bytes]) -> None:
    """The same of what is made first; what cannot be made names the path too."""
    with naming(path, "written", HAS_ROOM):
        data = make()
    write_atomically(path, data)


def prepare_output_folder(path: str | PathLike[str]) -> Path:
    """Make the folder, parents included, prove that a file can be written in it, and remove what
    killed processes have left half written.

    Raises:
        InputError: it cannot be made or written to; names the path and why.
    """
    folder = Path(path)
    with naming(folder, "used for the output", "it must be a folder that can be written to"):
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".topview.{os.getpid()}.part"
        try:
            probe.write_bytes(b"topview")
        finally:
            probe.unlink(missing_ok=True)
    _remove_left_over(folder)
    return folder


def _remove_left_over(folder: Path) -> None:
    """Half outputs whose process is gone, and that nobody on another machine writes to either."""
    for path in folder.glob(".*.part"):
        name = TEMPORARY.fullmatch(path.name)
        with suppress(OSError):
            if name and _is_gone(int(name[2])) and time() - path.stat().st_mtime > LEFT_OVER_S:
                path.unlink()


def _is_gone(process: int) -> bool:
    if os.name != "posix":  # there, asking would end it
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return False
