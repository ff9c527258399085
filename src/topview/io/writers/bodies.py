"""The file of known bodies, which `topview.body.known_body` reads."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from topview.body.known_body import KnownBody, bodies_as_bytes
from topview.io.writers.output import write_atomically
from topview.records import InputError


def write_bodies(bodies: Sequence[KnownBody], path: str | PathLike[str]) -> None:
    """Write bodies, one or more, as JSON; `topview.TrackerSettings(body=path)` takes them.

    Raises:
        InputError: there is none, or the file cannot be written.
    """
    if not bodies:
        raise InputError(f"{path}: no body to write; there must be one or more")
    write_atomically(Path(path), bodies_as_bytes(bodies))
