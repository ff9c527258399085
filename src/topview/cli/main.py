"""Runs the command line: every end of it is a line and an exit status."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from tempfile import NamedTemporaryFile

from topview.cli.status import BROKEN_PIPE, BUG, INTERRUPTED, UNUSABLE_INPUT
from topview.cli.stopping import OrderlyEnd
from topview.cli.streams import LastingStreams
from topview.lines import as_line


def main(arguments: Sequence[str] | None = None) -> None:
    """Run it and exit: 0 done, 1 a bug of topview, 2 unusable input or output, 128 and the signal's
    number if a signal ended it; one line on stderr for each of the last three."""
    with OrderlyEnd() as end, LastingStreams() as streams:
        try:
            from topview.cli.app import run  # takes a moment, in which Ctrl-C may come

            status = run(arguments)
        except KeyboardInterrupt:
            _say("interrupted")
            status = INTERRUPTED
        except MemoryError as error:
            _say(f"not enough memory: {error}")
            status = UNUSABLE_INPUT
        except Exception as error:
            status = _told(error)
        lost = streams.lost()
        if isinstance(lost, BrokenPipeError):  # `topview ... | head` has seen enough
            status = status or BROKEN_PIPE
        elif lost is not None:
            _say(f"stdout: {lost.strerror or lost}; files that were written are whole")
            status = status or UNUSABLE_INPUT
    sys.exit(end.status if status == INTERRUPTED else status)


def _told(error: Exception) -> int:
    """A line about an error; the exit status."""
    from cyclopts import CycloptsError

    from topview.records import InputError

    if isinstance(error, InputError | CycloptsError):
        _say(str(error))
        return UNUSABLE_INPUT
    if isinstance(error, OSError):  # a full disk, a folder that may not be written to
        where = f"{error.filename}: " if error.filename else ""
        _say(f"{where}{error.strerror or error}")
        return UNUSABLE_INPUT
    _say(
        f"a bug of topview ({type(error).__name__}: {error}); please report it, "
        f"with {_traceback_file(error)}"
    )
    return BUG


def _traceback_file(error: Exception) -> Path | str:
    """Where the traceback lies."""
    try:
        with NamedTemporaryFile(
            "w", prefix="topview-bug-", suffix=".txt", delete=False, encoding="utf-8"
        ) as file:
            traceback.print_exception(error, file=file)
    except OSError:
        return "the command; there was no room for the traceback"
    return Path(file.name)


def _say(message: str) -> None:
    print(f"topview: {as_line(message)}", file=sys.stderr)
