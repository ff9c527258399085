"""`topview track`: a recording in, skeletons out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.progress import print_summary, track_with_progress, warn
from topview.cli.status import INTERRUPTED
from topview.detect.color_view import Light
from topview.io import (
    MirroredRecording,
    open_recording,
    prepare_output_folder,
    write_atomically,
    write_skeletons_csv,
    write_skeletons_npz,
)
from topview.records import InputError
from topview.track import Tracker, TrackerSettings, TrackingResult
from topview.view import ContactSheet, PeopleSheet, Sheet, Viewers

DEFAULTS = TrackerSettings()


def track(
    source: Path,
    /,
    *,
    out: Path,
    pictures: Annotated[bool, Parameter(negative="")] = False,
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    settings: Annotated[TrackerSettings, Parameter(name="*")] = DEFAULTS,
) -> int:
    """Track everyone in a recording.

    Writes DIR/skeletons.npz and DIR/skeletons.csv. Ctrl-C keeps what was tracked so far.

    Args:
        source: a folder with depth/, camera.json and maybe rgb/; a UTD-MHAD .mat; an organized
            .pcd.
        out: folder for the results, made if it is missing.
        pictures: write DIR/contact_sheet.png, the skeletons, and DIR/people.png, how people were
            found, too.
        mirrored: the images are flipped left-right, as OpenNI and the Kinect SDK give them by
            default; camera.json describes them as they are stored. They are flipped back: left is
            the person's left, and positions are in the frame of the camera as it really stood.
    """
    prepare_output_folder(out)
    recording = open_recording(source)
    if mirrored:
        recording = MirroredRecording(recording)
    tracker = Tracker(settings)
    sheets: dict[str, Sheet] = {}
    if pictures:
        name, count = recording.name, recording.frame_count
        sheets["contact_sheet.png"] = ContactSheet(name, count)
        sheets["people.png"] = PeopleSheet(name, count, lambda: tracker.finder.found)
    result = track_with_progress(recording, tracker, Viewers(sheets.values()))
    warn(*recording.problems, *light_problems(tracker))
    skeletons = result.skeletons
    tracked = len(skeletons.frame_index)
    if not tracked and not result.interrupted:
        raise InputError(f"{source}: none of its {recording.frame_count} frames could be read")

    write_results(result, sheets, out)
    print_summary(recording, result)
    print(f"written to {out}")
    if result.interrupted:
        warn(f"interrupted: the {tracked} frames tracked so far are kept in {out}")
        return INTERRUPTED
    if not len(skeletons.person_ids):
        raise InputError(f"{source}: no person was found in {tracked} frames")
    return 0


def light_problems(tracker: Tracker) -> list[str]:
    """What kept the colours from telling anything, a line for each reason."""
    return [
        f"{light} in {count} of {tracker.lights.total()} frames; its colours are not used there"
        for light, count in tracker.lights.items()
        if light not in (Light.USABLE, Light.ABSENT)
    ]


def write_results(result: TrackingResult, sheets: Mapping[str, Sheet], out: Path) -> None:
    """Write `skeletons.npz`, `skeletons.csv` and the sheets that were shown frames, by name."""
    write_skeletons_npz(result.skeletons, out / "skeletons.npz")
    write_skeletons_csv(result.skeletons, out / "skeletons.csv")
    for name, sheet in sheets.items():
        if not sheet.is_blank:
            write_atomically(out / name, sheet.png())
