"""What tells that a recording of a batch is done: a file beside its result, with checksums."""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Literal

import msgspec

from topview.files import naming, read_bytes
from topview.io import write_atomically
from topview.records import InputError
from topview.version import installed_version

RECORD: Final = "done.json"
State = Literal["done", "failed", "waiting"]


class Outcome(msgspec.Struct, frozen=True, omit_defaults=True):
    """What became of one recording.

    Attributes:
        name: of its folder.
        source: absolute path of the recording.
        state: done, failed, or waiting for its turn.
        options: all that the result depends on, in JSON types.
        error: why it failed, a line; or that nobody was found.
        traceback: of an error that is a bug; empty otherwise.
        frames: how many were tracked.
        people: how many were found.
        files: SHA-256 of each file of the result, in hexadecimal digits.
        topview_version: what tracked it.
        run: which call of `topview batch` did.
    """

    name: str
    source: str
    state: State = "waiting"
    options: dict[str, Any] = {}
    error: str = ""
    traceback: str = ""
    frames: int = 0
    people: int = 0
    files: dict[str, str] = {}
    topview_version: str = ""
    run: str = ""


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in a folder, but for the record itself."""
    sums = {}
    for path in sorted(folder.iterdir()):
        if path.name != RECORD and path.is_file():
            with naming(path), path.open("rb") as file:
                sums[path.name] = hashlib.file_digest(file, "sha256").hexdigest()
    return sums


def write_record(folder: Path, outcome: Outcome) -> None:
    """Write it into a folder that is finished."""
    write_atomically(folder / RECORD, _as_json(msgspec.to_builtins(outcome)))


def read_record(folder: Path) -> Outcome | None:
    """What a folder holds; None unless it is finished and every file is as it was written."""
    with suppress(InputError, OSError, msgspec.MsgspecError):
        outcome = msgspec.json.decode(read_bytes(folder / RECORD), type=Outcome)
        sums = checksums(folder)
        if all(sums.get(name) == digest for name, digest in outcome.files.items()):
            return outcome
    return None


def write_manifest(path: Path, outcomes: list[Outcome]) -> None:
    """Write what became of all recordings of a batch so far."""
    told = {
        "topview_version": installed_version(),
        "recordings": [msgspec.to_builtins(outcome) for outcome in outcomes],
    }
    write_atomically(path, _as_json(told))


def _as_json(values: Any) -> bytes:
    return json.dumps(values, indent=1).encode() + b"\n"
