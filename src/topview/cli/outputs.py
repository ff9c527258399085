"""What a command does where its output is already: refuses, before any work, unless `--force`."""

from __future__ import annotations

from pathlib import Path

from topview.io import prepare_output_folder
from topview.records import InputError


def prepare_output_file(option: str, path: Path, force: bool) -> None:
    """Prove that a file can be written, so that nobody finds out after an hour of work.

    Args:
        option: that named it, for the error.
        path: of the file; its folder is made if it is missing.
        force: replace the file that is there.

    Raises:
        InputError: it is there and not to be replaced, is no regular file, or cannot be written.
    """
    if path.is_dir():
        raise InputError(f"{option} {path} is a folder; it must be a file")
    if path.exists() and not path.is_file():
        raise InputError(f"{option} {path} is no regular file; it must be one, or a new one")
    if path.exists() and not force:
        raise InputError(f"{option} {path}: is there already; --force replaces it")
    prepare_output_folder(path.parent)
