"""`topview recover`: the result of a run that was killed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.progress import warn
from topview.cli.results import (
    FRAMES_NAME,
    RESULT,
    check_no_result,
    print_people,
    set_aside,
    write_result,
)
from topview.io import NothingStoredError, StoredFrames
from topview.records import InputError


def recover(
    folder: Path,
    /,
    *,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Make the result of a run that was killed, or whose disk was full.

    Writes DIR/skeletons.npz and DIR/skeletons.csv of the frames in DIR/skeletons.frames, as
    `topview track` would have done, and then removes that file; if some of it is damaged, it is
    kept as DIR/skeletons.frames.damaged.

    Args:
        folder: the output folder of the run.
        force: replace the result that the folder holds.
    """
    path = folder / FRAMES_NAME
    if not path.exists():
        raise InputError(f"{path}: no such file; {folder} holds nothing to recover")
    try:
        stored = StoredFrames(path)
    except NothingStoredError:
        print(f"{path} holds no whole frame; it is now {set_aside(path)}")
        return 0
    check_no_result(folder, force=force)
    unwritten = write_result(stored, {}, folder)
    if unwritten:
        raise InputError("; ".join(unwritten))
    if stored.lost_bytes:
        warn(
            f"{path}: {stored.lost_bytes} bytes are no whole frame and are left out; "
            f"the file is kept as {path.name}.damaged"
        )
    print_people(str(stored.about.settings.get("recording", folder)), stored.totals)
    print(f"{stored.frame_count} frames, written to {folder / RESULT}")
    return 0
