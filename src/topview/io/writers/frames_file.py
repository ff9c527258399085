"""`skeletons.frames`: frames on disk as they are tracked, until the result is made of them.

Frames are appended, each whole or not at all, so that a killed process loses none and a power
failure costs at most a second. After a line that tells the format comes a record of what belongs to
no frame, then one for each frame: its length, its CRC-32 and MessagePack.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from struct import Struct
from time import perf_counter
from types import TracebackType
from typing import Any, BinaryIO, Final

import msgspec
import numpy as np

from topview.files import check_regular, naming
from topview.io.camera_values import camera_from, camera_values
from topview.io.writers.earlier import with_ends
from topview.io.writers.output import HAS_ROOM
from topview.records import InputError
from topview.skeletons import (
    About,
    SkeletonSequence,
    Slots,
    Totals,
    TrackedFrame,
    stacked,
)

try:
    import fcntl
except ImportError:  # no POSIX system: two runs in one folder are told apart by the file alone
    fcntl = None

FIRST_LINE: Final = b"topview frames 2\n"
SYNC_S: Final = 0.5  # ours: what a power failure may cost, and as much again while it is written
BLOCK_FRAMES: Final = 1000  # ours
_LENGTH_AND_CRC: Final = Struct("<II")
RIGHT: Final = "it must be what `topview track` was writing"


class _AboutRecord(msgspec.Struct):
    joint_names: tuple[str, ...]
    part_names: tuple[str, ...]
    settings: str  # JSON: a recording's name may be no text, which it escapes
    camera: dict[str, Any] | None
    topview_version: str


class _FrameRecord(msgspec.Struct, array_like=True):
    index: int
    timestamp_s: float
    name: bytes
    people: bytes
    floor_camera: tuple[float, float, float, float] | None


class NothingStoredError(InputError):
    """A process was killed before its first frame was written."""


class FramesFile:
    """Appends frames; the file is made with the first one, and is never removed here once it holds
    one.

    Args:
        path: of the file, which must not be there.
        about: what belongs to no frame.
    """

    def __init__(self, path: Path, about: About) -> None:
        self.path = path
        self._about = about
        self._file: BinaryIO | None = None
        self._end = 0
        self._synced_s = 0.0

    def __enter__(self) -> FramesFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.close()
            if not self._end:
                self.path.unlink()

    def append(self, frame: TrackedFrame) -> None:
        """Add the next frame.

        Raises:
            InputError: full disk, or the file is there already; all frames before are kept.
        """
        camera = frame.floor_camera
        record = _FrameRecord(
            frame.index,
            frame.timestamp_s,
            frame.name.encode("utf-8", "surrogatepass"),  # a file's name may be no text
            frame.people.tobytes(),
            None if camera is None else (camera[0], camera[1], camera[2], camera[3]),
        )
        with naming(self.path, "written", HAS_ROOM):
            data = _framed(msgspec.msgpack.encode(record))
            if self._file is None:
                self._file = self._made()
                data = self._beginning() + data
            self._write(self._file, data)
            if perf_counter() - self._synced_s > SYNC_S:
                os.fsync(self._file.fileno())
                self._synced_s = perf_counter()

    def _made(self) -> BinaryIO:
        try:
            file = self.path.open("xb", buffering=0)
        except FileExistsError:
            raise InputError("is there already; another run writes it, or was killed") from None
        if fcntl is not None:
            with suppress(OSError):  # some network folders know no locks
                fcntl.flock(file, fcntl.LOCK_EX)
        return file

    def _beginning(self) -> bytes:
        about = self._about
        camera = None if about.camera is None else camera_values(about.camera)
        record = _AboutRecord(
            about.joint_names,
            about.part_names,
            json.dumps(about.settings),
            camera,
            about.topview_version,
        )
        return FIRST_LINE + _framed(msgspec.msgpack.encode(record))

    def _write(self, file: BinaryIO, data: bytes) -> None:
        """All of it, or nothing: a full disk takes a part, which is taken back."""
        try:
            written = 0
            while written < len(data):
                written += file.write(data[written:])
        except BaseException:
            file.truncate(self._end)
            file.seek(self._end)
            raise
        self._end += len(data)


class StoredFrames:
    """The frames of such a file, as `Skeletons`.

    Attributes:
        path: of the file.
        about: what belongs to no frame.
        totals: what all frames together tell.
        lost_bytes: that are no whole frame: the last one, where a process was killed in the middle
            of it, and those that were damaged since.

    Raises:
        NothingStoredError: no frame in it is whole.
        InputError: it cannot be read, is something else, or is still written by a run.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with naming(path, right=RIGHT):
            check_regular(path, RIGHT)
            with path.open("rb") as file:
                _check_nobody_writes(file)
                self.about = _about(file)
                self._person_type = self.about.person_type
                self._start = file.tell()
            self._whole_bytes = 0
            self.totals = Totals.of(self._frames())
            self.lost_bytes = path.stat().st_size - self._start - self._whole_bytes
            if not self.frame_count:
                raise NothingStoredError("holds no frame")

    @property
    def frame_count(self) -> int:
        return self.totals.frames

    def frames(self) -> Iterator[TrackedFrame]:
        """All frames, one by one. Raises InputError where they cannot be read."""
        with naming(self.path, right=RIGHT):
            yield from self._frames()

    def blocks(self) -> Iterator[SkeletonSequence]:
        """As `Skeletons.blocks`."""
        slots = Slots()
        block: list[TrackedFrame] = []
        with naming(self.path, right=RIGHT):
            for frame in self._frames():
                block.append(frame)
                if len(block) == BLOCK_FRAMES:
                    yield with_ends(stacked(block, self.about, self.totals, slots))
                    block = []
            if block:
                yield with_ends(stacked(block, self.about, self.totals, slots))

    def _frames(self) -> Iterator[TrackedFrame]:
        """All whole frames; `_whole_bytes` is how much they take."""
        self._whole_bytes = 0
        with self.path.open("rb") as file:
            file.seek(self._start)
            for record in _records(file):
                self._whole_bytes += _LENGTH_AND_CRC.size + len(record)
                yield self._frame(record)

    def _frame(self, record: bytes) -> TrackedFrame:
        try:
            frame = _FRAME_DECODER.decode(record)
            people = np.frombuffer(frame.people, self._person_type)
            name = frame.name.decode("utf-8", "surrogatepass")
        except ValueError as error:  # of msgspec and NumPy
            raise InputError(f"has a record that is no frame ({error}); {RIGHT}") from None
        return TrackedFrame(frame.index, frame.timestamp_s, name, people, frame.floor_camera)


_FRAME_DECODER: Final = msgspec.msgpack.Decoder(_FrameRecord)


def _check_nobody_writes(file: BinaryIO) -> None:
    if fcntl is None:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError("a run still writes it; wait for its end") from None
    except OSError:  # a network folder that knows no locks
        return


def _about(file: BinaryIO) -> About:
    """Of a file at its beginning."""
    line = file.read(len(FIRST_LINE))
    if not FIRST_LINE.startswith(line):
        raise InputError(f"is no file of frames that this version of topview knows; {RIGHT}")
    record = next(_records(file), None)
    if record is None:
        raise NothingStoredError("holds no frame")
    try:
        about = msgspec.msgpack.decode(record, type=_AboutRecord)
        settings = json.loads(about.settings)
    except ValueError as error:  # of msgspec and json
        raise InputError(f"does not tell what it is about ({error}); {RIGHT}") from None
    return About(
        about.joint_names,
        about.part_names,
        settings,
        None if about.camera is None else camera_from(about.camera),
        about.topview_version,
    )


def _records(file: BinaryIO) -> Iterator[bytes]:
    """All whole records from here on. Damaged ones are left out, and what follows one of which the
    length is damaged."""
    size = os.fstat(file.fileno()).st_size
    while len(head := file.read(_LENGTH_AND_CRC.size)) == _LENGTH_AND_CRC.size:
        length, crc = _LENGTH_AND_CRC.unpack(head)
        if length > size - file.tell():
            return
        record = file.read(length)
        if len(record) == length and zlib.crc32(record) == crc:
            yield record


def _framed(record: bytes) -> bytes:
    return _LENGTH_AND_CRC.pack(len(record), zlib.crc32(record)) + record
