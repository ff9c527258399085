"""Output files appear whole or not at all."""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path

from topview.files import naming


def write_atomically(path: Path, data: bytes) -> None:
    """Write a temporary file beside `path`, then rename it; no half file is left, whatever happens.

    Raises:
        InputError: full disk, no permission, a folder in the file's place; names the path and why.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    with naming(path, "written", "it must be a place with room and leave to write"):
        try:
            with temporary.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())  # a full disk may show only here
            os.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise


def prepare_output_folder(path: str | PathLike[str]) -> Path:
    """Make the folder, parents included, and prove that a file can be written in it.

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
    return folder
