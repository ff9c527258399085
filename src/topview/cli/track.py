"""`topview track`: a recording in, skeletons out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.progress import follow_with_progress, print_summary, warn
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
from topview.track import Tracker, TrackerSettings, TrackingResult, TrackingRun
from topview.view import ContactSheet, PeopleSheet, Sheet, Viewers

DEFAULTS = TrackerSettings()
RESULT = "skeletons.npz"


def track(
    source: Path,
    /,
    *,
    out: Path,
    pictures: Annotated[bool, Parameter(negative="")] = False,
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    force: Annotated[bool, Parameter(negative="")] = False,
    settings: Annotated[TrackerSettings, Parameter(name="*")] = DEFAULTS,
) -> int:
    """Track everyone in a recording.

    Writes DIR/skeletons.npz and DIR/skeletons.csv. Whatever ends it early, Ctrl-C, a signal or an
    error, what was tracked so far is written.

    Args:
        source: a folder with depth/, camera.json and maybe rgb/; a UTD-MHAD .mat; an organized
            .pcd.
        out: folder for the results, made if it is missing.
        pictures: write DIR/contact_sheet.png, the skeletons, and DIR/people.png, how people were
            found, too.
        mirrored: the images are flipped left-right, as OpenNI and the Kinect SDK give them by
            default; camera.json describes them as they are stored. They are flipped back: left is
            the person's left, and positions are in the frame of the camera as it really stood.
        force: replace the result that DIR holds.
    """
    prepare_output_folder(out)
    if (out / RESULT).exists() and not force:
        raise InputError(f"{out / RESULT}: is there already; --force replaces it")
    recording = open_recording(source)
    if mirrored:
        recording = MirroredRecording(recording)
    tracker = Tracker(settings)
    sheets: dict[str, Sheet] = {}
    if pictures:
        name, count = recording.name, recording.frame_count
        sheets["contact_sheet.png"] = ContactSheet(name, count)
        sheets["people.png"] = PeopleSheet(name, count, lambda: tracker.finder.found)
    run = TrackingRun(recording, tracker)
    failure: Exception | None = None
    try:
        follow_with_progress(run, recording, Viewers(sheets.values()))
    except Exception as error:  # whatever it is, what was tracked is written before it is told
        failure = error
    result = run.result()
    warn(*recording.problems, *light_problems(tracker))
    if run.frame_count:
        write_results(result, sheets, out)
        print_summary(recording, result, ended_early=failure is not None)
        print(f"written to {out}")
    kept = f"the {run.frame_count} frames tracked so far are kept in {out}"
    if failure is not None:
        if run.frame_count:
            warn(f"ended by an error: {kept}")
        raise failure
    if result.interrupted:
        warn(f"interrupted: {kept if run.frame_count else 'nothing was tracked, nothing written'}")
        return INTERRUPTED
    if not run.frame_count:
        raise InputError(f"{source}: none of its {recording.frame_count} frames could be read")
    if not len(result.skeletons.person_ids):
        raise InputError(f"{source}: no person was found in {run.frame_count} frames")
    return 0


def light_problems(tracker: Tracker) -> list[str]:
    """What kept the colours from telling anything, a line for each reason."""
    return [
        f"{light} in {count} of {tracker.lights.total()} frames; its colours are not used there"
        for light, count in tracker.lights.items()
        if light not in (Light.USABLE, Light.ABSENT)
    ]


def write_results(result: TrackingResult, sheets: Mapping[str, Sheet], out: Path) -> None:
    """Write `skeletons.npz`, `skeletons.csv` and the sheets that were shown frames, by name.

    Raises:
        InputError: some could not be written; all others are.
    """
    writers: list[Callable[[], None]] = [
        lambda: write_skeletons_npz(result.skeletons, out / RESULT),
        lambda: write_skeletons_csv(result.skeletons, out / "skeletons.csv"),
    ]
    for name, sheet in sheets.items():
        if not sheet.is_blank:
            writers.append(lambda name=name, sheet=sheet: write_atomically(out / name, sheet.png()))
    failures: list[InputError] = []
    for write in writers:
        try:
            write()
        except InputError as error:
            failures.append(error)
    if failures:
        raise InputError("; ".join(map(str, failures)))
