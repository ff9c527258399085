"""`topview track`: a recording in, skeletons out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.progress import print_summary, track_with_progress, warn
from topview.cli.status import INTERRUPTED
from topview.io import (
    open_recording,
    prepare_output_folder,
    write_atomically,
    write_skeletons_csv,
    write_skeletons_npz,
)
from topview.records import InputError
from topview.track import TrackerSettings, TrackingResult
from topview.view import ContactSheet, NullViewer

DEFAULTS = TrackerSettings()


def track(
    source: Path,
    /,
    *,
    out: Path,
    pictures: Annotated[bool, Parameter(negative="")] = False,
    settings: Annotated[TrackerSettings, Parameter(name="*")] = DEFAULTS,
) -> int:
    """Track everyone in a recording.

    Writes DIR/skeletons.npz and DIR/skeletons.csv. Ctrl-C keeps what was tracked so far.

    Args:
        source: a folder with depth/, camera.json and maybe rgb/; a UTD-MHAD .mat; an organized
            .pcd.
        out: folder for the results, made if it is missing.
        pictures: write DIR/contact_sheet.png too.
    """
    prepare_output_folder(out)
    recording = open_recording(source)
    sheet = ContactSheet(recording.name, len(recording)) if pictures else None
    result = track_with_progress(recording, settings, sheet or NullViewer())
    warn(*recording.problems)
    skeletons = result.skeletons
    tracked = len(skeletons.frame_index)
    if not tracked and not result.interrupted:
        raise InputError(f"{source}: none of its {len(recording)} frames could be read")

    write_results(result, sheet, out)
    print_summary(recording, result)
    print(f"written to {out}")
    if result.interrupted:
        warn(f"interrupted: the {tracked} frames tracked so far are kept in {out}")
        return INTERRUPTED
    if not len(skeletons.person_ids):
        raise InputError(f"{source}: no person was found in {tracked} frames")
    return 0


def write_results(result: TrackingResult, sheet: ContactSheet | None, out: Path) -> None:
    """Write `skeletons.npz`, `skeletons.csv` and, of a sheet that was shown frames,
    `contact_sheet.png`."""
    write_skeletons_npz(result.skeletons, out / "skeletons.npz")
    write_skeletons_csv(result.skeletons, out / "skeletons.csv")
    if sheet is not None and sheet.moments:
        write_atomically(out / "contact_sheet.png", sheet.png())
