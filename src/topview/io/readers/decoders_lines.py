"""Catch what libpng, libjpeg and OpenCV print while they decode an image.

They write to the process's stderr, past Python, and cannot be told not to. To unpack every image
before, only to see whether they would, costs half as long as decoding it. So the file behind stderr
is exchanged while one is decoded, for about ten microseconds more. Other threads may write in that
time: what is no decoder's line is written on afterwards, and nothing is lost, though what comes in
the middle of a decoder's line stays part of it. One image is decoded at a time.
"""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
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
_one_at_a_time = threading.Lock()


@contextmanager
def decoders_lines() -> Iterator[list[str]]:
    """The decoders' lines, once it is left; they do not reach stderr."""
    said: list[str] = []
    with _one_at_a_time, ExitStack() as closing:
        try:
            stderr = os.dup(STDERR)
        except OSError:  # closed: they reach nobody
            yield said
            return
        closing.callback(os.close, stderr)
        caught = closing.enter_context(_memory_file())
        _append_always(caught.fileno())
        os.dup2(caught.fileno(), STDERR)
        try:
            yield said
        finally:
            os.dup2(stderr, STDERR)
        if os.fstat(caught.fileno()).st_size:
            caught.seek(0)
            is_theirs = False
            for line in caught.readlines():
                if line.startswith(STARTS):
                    said.append(line.decode(errors="replace").strip())
                    is_theirs = True
                elif not (is_theirs and (line.startswith(b">") or not line.strip())):
                    is_theirs = False
                    with suppress(OSError):  # a full disk
                        os.write(stderr, line)


def _append_always(fd: int) -> None:
    """Threads that write at once must not write over each other."""
    if fcntl is not None:
        fcntl.fcntl(fd, fcntl.F_SETFL, fcntl.fcntl(fd, fcntl.F_GETFL) | os.O_APPEND)


def _memory_file() -> BinaryIO:
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create("topview"), "w+b")
    return tempfile.TemporaryFile()  # pyright: ignore[reportReturnType]
