"""What an output folder holds: a result, or the frames that one is still to be made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

from rich.table import Table

from topview.cli.printing import plain_console
from topview.cli.progress import warn
from topview.files import naming
from topview.io import (
    FramesFile,
    SkeletonFile,
    StoredFrames,
    write_skeletons_csv,
    write_skeletons_npz,
)
from topview.io.writers.output import written_atomically
from topview.io.writers.registry import FORMATS, SkeletonFormat, write_format
from topview.records import InputError, Recording
from topview.skeletons import Skeletons, Totals, TrackedFrame
from topview.track.offline import looked_at_both_ways
from topview.track.run import read_again
from topview.view import Sheet, Viewer

RESULT: Final = "skeletons.npz"
TABLE: Final = "skeletons.csv"
STEM: Final = "skeletons"  # of a result in any format
CONTACT_SHEET: Final = "contact_sheet.png"
PEOPLE_SHEET: Final = "people.png"
OVERLAY: Final = "overlay.mp4"
PART_MAPS: Final = "part_maps.zip"
FRAMES_NAME: Final = "skeletons.frames"
SMOOTHED_NAME: Final = "skeletons.offline.frames"  # while they are being smoothed


def check_free(out: Path, *, force: bool) -> None:
    """Refuse to write where frames wait to be recovered, and without `force` where a result is.

    Raises:
        InputError: there is one of them.
    """
    if (out / FRAMES_NAME).exists():
        raise InputError(
            f"{out / FRAMES_NAME}: another run writes it, or was killed; in that case "
            f"`topview recover {out}` makes the result of it"
        )
    check_no_result(out, force=force)


def check_no_result(out: Path, *, force: bool) -> None:
    """Raises InputError where a result is, without `force`."""
    if (out / RESULT).exists() and not force:
        raise InputError(f"{out / RESULT}: is there already; --force replaces it")


def look_both_ways(stored: StoredFrames, backward: Iterable[TrackedFrame] = ()) -> StoredFrames:
    """The frames with their people smoothed both ways in time, in the same file; `backward` as they
    were tracked backwards. Until that is whole, the frames as they were tracked stay in it.

    Raises:
        InputError: they cannot be written.
    """
    path = stored.path.with_name(SMOOTHED_NAME)
    with naming(path, "removed", "it is of a run that was killed"):
        path.unlink(missing_ok=True)
    try:
        with FramesFile(path, stored.about) as file:
            for frame in looked_at_both_ways(stored.frames(), stored.about.settings, backward):
                file.append(frame)
        with naming(stored.path, "replaced", "it must be a place with leave to write"):
            path.replace(stored.path)
    finally:
        path.unlink(missing_ok=True)
    return StoredFrames(stored.path)


def show_again(recording: Recording, stored: StoredFrames, viewer: Viewer) -> None:
    """Show the stored people with the frames of a recording, which is read once more."""
    rows = (
        (time_s, block, row)
        for block in stored.blocks()
        for row, time_s in enumerate(block.timestamps_s.tolist())
    )
    own = next(rows, None)
    for frame in read_again(recording):
        while own is not None and own[0] < frame.timestamp_s:
            own = next(rows, None)
        if own is None:
            break
        time_s, block, row = own
        if time_s == frame.timestamp_s:
            viewer.show(frame, block.people_in(row))


def write_result(
    stored: StoredFrames,
    sheets: Mapping[str, Sheet],
    out: Path,
    formats: Sequence[SkeletonFormat] = (),
) -> list[str]:
    """Write the skeletons, in more formats if asked, and the sheets; then remove what an older
    result has left, and the file of frames, or set that aside if some of it is damaged. What could
    not be written, a line each. The file of frames and what is older stay if the skeletons are
    among it."""
    where = (
        f"the {stored.frame_count} frames lie in {stored.path}; "
        f"`topview recover {out}` makes the result of them"
    )
    older = older_files(out)
    try:
        failures = _failures_of(_skeleton_writers(stored, out))
    except BaseException:  # an insistent signal, or a bug
        warn(where)
        raise
    if failures:
        failures.append(where)
        return _failures_of(_sheet_writers(sheets, out)) + failures
    if stored.lost_bytes:
        set_aside(stored.path)
    else:
        stored.path.unlink()
    more = [lambda made=made: _write_more(made, out) for made in formats]
    return _failures_of([lambda: _remove(older), *more, *_sheet_writers(sheets, out)])


def _write_more(made: SkeletonFormat, out: Path) -> None:
    write_format(made, SkeletonFile(out / RESULT), out / f"{STEM}.{made.name}")


def older_files(out: Path) -> list[Path]:
    """What belongs to the result that a folder holds, if it holds one, besides the two files that
    are always written: pictures, part maps, and skeletons in other formats."""
    if not (out / RESULT).exists():
        return []
    files = [out / name for name in (CONTACT_SHEET, PEOPLE_SHEET, OVERLAY, PART_MAPS)]
    for made in FORMATS.values():
        files += [out / f"{STEM}.{made.name}", *out.glob(f"{STEM}_person*.{made.name}")]
    return [file for file in files if file.name not in (RESULT, TABLE) and file.exists()]


def _remove(files: Sequence[Path]) -> None:
    for file in files:
        with naming(file, "removed", "it belongs to the older result"):
            file.unlink(missing_ok=True)


def set_aside(path: Path) -> Path:
    """Where a file of frames now is, of which something could not be read."""
    return path.replace(path.with_name(f"{path.name}.damaged"))


def write_results(skeletons: Skeletons, sheets: Mapping[str, Sheet], out: Path) -> None:
    """Write `skeletons.npz`, `skeletons.csv` and the sheets that were shown frames, by name.

    Raises:
        InputError: some could not be written; all others are.
    """
    older = older_files(out)
    failures = _failures_of(_skeleton_writers(skeletons, out))
    if not failures:
        failures = _failures_of([lambda: _remove(older)])
    failures += _failures_of(_sheet_writers(sheets, out))
    if failures:
        raise InputError("; ".join(failures))


def _skeleton_writers(skeletons: Skeletons, out: Path) -> list[Callable[[], None]]:
    return [
        lambda: write_skeletons_npz(skeletons, out / RESULT),
        lambda: write_skeletons_csv(skeletons, out / TABLE),
    ]


def _sheet_writers(sheets: Mapping[str, Sheet], out: Path) -> list[Callable[[], None]]:
    return [
        lambda name=name, sheet=sheet: _write_sheet(sheet, out / name)
        for name, sheet in sheets.items()
        if not sheet.is_blank
    ]


def _write_sheet(sheet: Sheet, path: Path) -> None:
    with written_atomically(path) as file:
        sheet.write(file)


def _failures_of(writers: Sequence[Callable[[], None]]) -> list[str]:
    """Call all; what those say that fail."""
    failures: list[str] = []
    for write in writers:
        try:
            write()
        except InputError as error:
            failures.append(str(error))
    return failures


def print_people(title: str, totals: Totals) -> None:
    """Who was found, on stdout."""
    table = Table("person", title=title, title_justify="left")
    for column in ("frames seen", "height, m", "mean confidence"):
        table.add_column(column, justify="right")
    for person_id, person in sorted(totals.people.items()):
        confidence = person.confidence / person.frames
        table.add_row(
            str(person_id), str(person.frames), f"{person.height_m:.2f}", f"{confidence:.2f}"
        )
    if table.rows:
        plain_console().print(table)
