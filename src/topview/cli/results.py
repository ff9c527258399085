"""What an output folder holds: a result, or the frames that one is still to be made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

from rich.table import Table

from topview.cli.printing import plain_console
from topview.cli.progress import warn
from topview.io import StoredFrames, write_atomically, write_skeletons_csv, write_skeletons_npz
from topview.records import InputError
from topview.skeletons import Skeletons, Totals
from topview.view import Sheet

RESULT: Final = "skeletons.npz"
TABLE: Final = "skeletons.csv"
FRAMES_NAME: Final = "skeletons.frames"


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


def write_result(stored: StoredFrames, sheets: Mapping[str, Sheet], out: Path) -> list[str]:
    """Write the skeletons and the sheets, then remove the file of frames, or set it aside if some
    of it is damaged; what could not be written, a line each. The file of frames stays if the
    skeletons are among it."""
    where = (
        f"the {stored.frame_count} frames lie in {stored.path}; "
        f"`topview recover {out}` makes the result of them"
    )
    try:
        failures = _failures_of(_skeleton_writers(stored, out))
    except BaseException:  # an insistent signal, or a bug
        warn(where)
        raise
    if failures:
        failures.append(where)
    elif stored.lost_bytes:
        set_aside(stored.path)
    else:
        stored.path.unlink()
    return _failures_of(_sheet_writers(sheets, out)) + failures


def set_aside(path: Path) -> Path:
    """Where a file of frames now is, of which something could not be read."""
    return path.replace(path.with_name(f"{path.name}.damaged"))


def write_results(skeletons: Skeletons, sheets: Mapping[str, Sheet], out: Path) -> None:
    """Write `skeletons.npz`, `skeletons.csv` and the sheets that were shown frames, by name.

    Raises:
        InputError: some could not be written; all others are.
    """
    failures = _failures_of([*_skeleton_writers(skeletons, out), *_sheet_writers(sheets, out)])
    if failures:
        raise InputError("; ".join(failures))


def _skeleton_writers(skeletons: Skeletons, out: Path) -> list[Callable[[], None]]:
    return [
        lambda: write_skeletons_npz(skeletons, out / RESULT),
        lambda: write_skeletons_csv(skeletons, out / TABLE),
    ]


def _sheet_writers(sheets: Mapping[str, Sheet], out: Path) -> list[Callable[[], None]]:
    return [
        lambda name=name, sheet=sheet: write_atomically(out / name, sheet.png())
        for name, sheet in sheets.items()
        if not sheet.is_blank
    ]


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
