"""Catch what libpng, libjpeg and OpenCV print while they decode an image.

They write to the process's stderr, past Python, and cannot be told not to. To unpack every image
before, only to see whether they would, costs half as long as decoding it. So the file behind stderr
is exchanged while one is decoded, for about ten microseconds more. Other threads may write in that
time: what is no decoder's line is written on afterwards, though what comes in the middle of a
decoder's line stays part of it. A write that had begun may end only after stderr is back, and its
first half may be there before its second; the line is written on, whole, with the next image or at
the end of the program. So nothing is lost. One image is decoded at a time.
"""

from __future__ import annotations

import atexit
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import BinaryIO, Final

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

STDERR: Final = 2
STARTS: Final = (
    b"libpng ",
    b"Corrupt JPEG",
    b"Premature end of JPEG",
    b"Invalid SOS",
    b"Inconsistent progression",
    b"Unsupported marker",
    b"Warning: unknown JFIF",
    b"[ WARN:",
    b"[ERROR:",
)
"""Of libpng's, libjpeg's and OpenCV's lines; OpenCV goes on with lines that begin with >."""
LARGEST_BYTES: Final = 1 << 20
"""Of the file that catches them, before a new one takes its place; ours."""


@contextmanager
def decoders_lines() -> Iterator[list[str]]:
    """The decoders' lines, once it is left; they do not reach stderr."""
    said: list[str] = []
    with _catcher.one_at_a_time:
        try:
            stderr = os.dup(STDERR)
        except OSError:  # closed: they reach nobody
            yield said
            return
        try:
            os.dup2(_catcher.file().fileno(), STDERR)
            try:
                yield said
            finally:
                os.dup2(stderr, STDERR)
            said += _catcher.pass_on(stderr)
        finally:
            os.close(stderr)


class _Catcher:
    """The file behind stderr while an image is decoded, and how much of it was read."""

    def __init__(self) -> None:
        self.one_at_a_time = threading.Lock()
        self._file: BinaryIO | None = None
        self._read_bytes = 0

    def file(self) -> BinaryIO:
        if self._file is None or self._read_bytes > LARGEST_BYTES:
            self._file, self._read_bytes = _memory_file(), 0
            _append_always(self._file.fileno())
        return self._file

    def pass_on(self, stderr: int, *, is_last: bool = False) -> list[str]:
        """The decoders' new lines; what others wrote goes to `stderr`, half a line if `is_last`."""
        said: list[str] = []
        if self._file is None or os.fstat(self._file.fileno()).st_size == self._read_bytes:
            return said
        self._file.seek(self._read_bytes)
        is_theirs = False
        for line in self._file.readlines():
            is_decoders = line.startswith(STARTS)
            if not (line.endswith(b"\n") or is_decoders or is_last):
                break  # the rest is still being written
            self._read_bytes += len(line)
            if is_decoders:
                said.append(line.decode(errors="replace").strip())
                is_theirs = True
            elif not (is_theirs and (line.startswith(b">") or not line.strip())):
                is_theirs = False
                with suppress(OSError):  # a full disk
                    os.write(stderr, line)
        return said


_catcher = _Catcher()
atexit.register(lambda: _catcher.pass_on(STDERR, is_last=True))
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _catcher.__init__())  # not its parent's file


def _append_always(fd: int) -> None:
    """Threads that write at once must not write over each other."""
    if fcntl is not None:
        fcntl.fcntl(fd, fcntl.F_SETFL, fcntl.fcntl(fd, fcntl.F_GETFL) | os.O_APPEND)


def _memory_file() -> BinaryIO:
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create("topview"), "w+b")
    return tempfile.TemporaryFile()  # pyright: ignore[reportReturnType]
