"""One recording of a batch: tracked under a temporary name, renamed when it is whole."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import time
from traceback import format_exc
from typing import Any, Final

from topview.batch.record import RECORD, Outcome, checksums, read_record, write_record
from topview.files import naming
from topview.io.writers.output import HAS_ROOM, LEFT_OVER_S
from topview.records import InputError
from topview.version import installed_version

UNFINISHED: Final = ".unfinished"
LOG: Final = "log.txt"
_ALONE: Final = Lock()  # what is printed is the process's, and so are the cores


@dataclass(frozen=True)
class Job:
    """A recording to be tracked; it can be sent to another process.

    Attributes:
        name: of its folder in the output.
        source: the recording.
        out: the folder of the batch.
        options: what the result depends on, in JSON types.
        run: which call of `topview batch` this is.
        replaces: a result of another run is made again.
        track: track `source` into a folder, which is made for it; counts of frames and people.
            What it prints goes to the log beside the result.
    """

    name: str
    source: Path
    out: Path
    options: dict[str, Any]
    run: str
    replaces: bool
    track: Callable[[Path, Path], tuple[int, int]]

    @property
    def folder(self) -> Path:
        """Where the result is, once it is whole."""
        return self.out / self.name

    def outcome(self, **told: Any) -> Outcome:
        """What became of it."""
        return Outcome(self.name, str(self.source.resolve()), options=self.options, **told)

    def finished(self) -> Outcome | None:
        """What was made of it before; None if it is still to be done."""
        if not self.folder.exists() or (outcome := read_record(self.folder)) is None:
            return None
        is_of_this = self._is_of_this(outcome) and (not self.replaces or outcome.run == self.run)
        return outcome if is_of_this else None

    def check_free(self) -> None:
        """Refuse to replace a result of something else.

        Raises:
            InputError: the folder holds one that is whole, or what no batch has written.
        """
        if self.replaces or not self.folder.exists():
            return
        outcome = read_record(self.folder)
        if outcome is None and not (self.folder / RECORD).exists():
            raise InputError(f"{self.folder}: was not written by a batch; --force replaces it")
        if outcome is not None and not self._is_of_this(outcome):
            what = "with other options"
            if outcome.source != str(self.source.resolve()):
                what = f"of another recording, {outcome.source}"
            raise InputError(f"{self.folder}: is a result {what}; --force replaces it")

    def _is_of_this(self, outcome: Outcome) -> bool:
        return (outcome.source, outcome.options) == (str(self.source.resolve()), self.options)


def unfinished_folder(job: Job, process: int) -> Path:
    """Where a process of this machine tracks it."""
    return job.out / f".{job.name}.{socket.gethostname()}.{process}{UNFINISHED}"


def do(job: Job) -> Outcome:
    """Do it; an error is an outcome too. One at a time in each process."""
    with _ALONE:
        if (done := job.finished()) is not None:  # told by a process that was killed just then
            return done
        unfinished = unfinished_folder(job, os.getpid())
        try:
            return _tracked(job, unfinished)
        except InputError as error:
            return job.outcome(state="failed", error=str(error))
        except Exception as error:  # a bug: it is told, and the other recordings go on
            told = f"a bug of topview ({type(error).__name__}: {error})"
            return job.outcome(state="failed", error=told, traceback=format_exc())
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


def _tracked(job: Job, unfinished: Path) -> Outcome:
    with naming(unfinished, "written", HAS_ROOM):
        unfinished.mkdir()
    with (
        (unfinished / LOG).open("w", encoding="utf-8", errors="replace") as log,
        redirect_stdout(log),
        redirect_stderr(log),
    ):
        frames, people = job.track(job.source, unfinished)
    outcome = job.outcome(
        state="done",
        error="" if people else "nobody was found",
        frames=frames,
        people=people,
        files=checksums(unfinished),
        topview_version=installed_version(),
        run=job.run,
    )
    write_record(unfinished, outcome)
    return _put_in_place(job, unfinished, outcome)


def _put_in_place(job: Job, unfinished: Path, outcome: Outcome) -> Outcome:
    """Rename it; where somebody else was sooner, theirs stays."""
    if (theirs := job.finished()) is not None:
        return theirs
    older = unfinished.with_name(f".older{unfinished.name}")
    with naming(job.folder, "written", HAS_ROOM):
        with suppress(FileNotFoundError):
            job.folder.rename(older)
        unfinished.rename(job.folder)
    shutil.rmtree(older, ignore_errors=True)
    return outcome


def remove_unfinished(out: Path) -> None:
    """Remove what killed processes have left, where nobody has written for a while."""
    for folder in out.glob(f".*{UNFINISHED}"):
        with suppress(OSError):
            if time() - max(p.stat().st_mtime for p in (folder, *folder.iterdir())) > LEFT_OVER_S:
                shutil.rmtree(folder)
