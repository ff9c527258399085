"""stdout and stderr on which printing never fails, and what is printed as one line.

A closed pipe, a full disk, a terminal without the letters of a name: nothing of that may end a run
whose results are still to be written. What stdout could not take is told at the end.
"""

from __future__ import annotations

import io
import os
import sys
from typing import Any, Self, TextIO


class _LastingFile(io.FileIO):
    """Discards everything after the first error.

    Attributes:
        error: that one.
    """

    error: OSError | None = None

    def write(self, data: Any, /) -> int | None:
        if self.error is None:
            try:
                return super().write(data)
            except OSError as error:
                self.error = error
        return len(data)


class LastingStreams:
    """While it is entered, sys.stdout and sys.stderr take everything: characters that their
    encoding lacks are escaped, and what cannot be written is dropped. Streams that were exchanged
    before, as tests do, are left alone."""

    def __init__(self) -> None:
        self._before: dict[str, TextIO | None] = {}
        self._stdout: _LastingFile | None = None

    def __enter__(self) -> Self:
        for name, number in (("stdout", 1), ("stderr", 2)):
            stream: TextIO | None = getattr(sys, name)
            if stream is getattr(sys, f"__{name}__"):
                self._before[name] = stream
                file = _LastingFile(_descriptor(stream, number), "w", closefd=False)
                setattr(sys, name, _lasting(stream, file))
                if name == "stdout":
                    self._stdout = file
        return self

    def __exit__(self, *_: object) -> None:
        for name, stream in self._before.items():
            getattr(sys, name).flush()
            setattr(sys, name, stream)

    def lost(self) -> OSError | None:
        """Why stdout did not take everything; None if it did."""
        if self._stdout is None:
            return None
        sys.stdout.flush()
        return self._stdout.error


def _descriptor(stream: TextIO | None, number: int) -> int:
    if stream is not None:
        stream.flush()
        return stream.fileno()
    # It was closed. Held by what cannot be written to, or the next file to be opened would get its
    # number, and with it whatever a library prints.
    nothing = os.open(os.devnull, os.O_RDONLY)
    if nothing != number:
        os.dup2(nothing, number)
        os.close(nothing)
    return number


def _lasting(stream: TextIO | None, file: _LastingFile) -> io.TextIOWrapper:
    return io.TextIOWrapper(
        io.BufferedWriter(file),
        encoding=stream.encoding if stream is not None else "utf-8",
        errors="backslashreplace",
        line_buffering=getattr(stream, "line_buffering", False),
        write_through=getattr(stream, "write_through", False),
    )
