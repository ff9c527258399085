"""Every error of a file names the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from topview.records import InputError


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
