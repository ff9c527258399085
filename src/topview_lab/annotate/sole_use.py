"""One process at a time on one project."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from topview.files import naming
from topview.records import InputError

try:
    import fcntl
except ImportError:  # Windows: without
    fcntl = None

LOCK_FILE: Final = "annotation.lock"


class SoleUse:
    """Holds a project's folder until it is closed. The kernel frees it when the process ends, in
    whatever way; the file stays and means nothing by itself.

    Raises:
        InputError: another process holds it, or the file cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        path = folder / LOCK_FILE
        with naming(path, "written", "it must be a file that can be written to"):
            self._file = path.open("a+")
        if fcntl is None:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._file.seek(0)
            holder = self._file.read(20).strip()
            self.close()
            raise InputError(
                f"{path}: is held by another `topview annotate`"
                f"{f', process {holder}' if holder.isdigit() else ''}; end it, "
                "or give --out another folder"
            ) from None
        except OSError:  # a file system that has no locks
            return
        self._file.truncate(0)
        self._file.write(f"{os.getpid()}\n")
        self._file.flush()

    def close(self) -> None:
        self._file.close()
