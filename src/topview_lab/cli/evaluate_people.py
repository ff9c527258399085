"""`topview evaluate people`, `mounts` and `returns`: who is found, and under which id."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.records import InputError
from topview.track.run import track_offline, track_recording
from topview_lab.cli.simulate import CAMERAS, Size
from topview_lab.cli.tracked import TRACKED_OPTIONS, Told, TrackedOptions, measure_all, numbers
from topview_lab.datasets import find_folder_recordings
from topview_lab.datasets.hiding import make_hidings
from topview_lab.datasets.mounts import make_mounted
from topview_lab.evaluate.people import (
    ALL_KINDS,
    PeopleJob,
    PeopleOutcome,
    count_by_kind,
    count_each,
    found_people_table,
)
from topview_lab.evaluate.returns import (
    ReturnJob,
    ReturnOutcome,
    each_return_table,
    returns_by_cover,
    returns_table,
)
from topview_lab.evaluate.tables import rows_as_json
from topview_lab.metrics.splits import ALL
from topview_lab.sim.scenes.hiding import HIDERS


def people(
    *paths: Path,
    offline: Annotated[bool, Parameter(negative="")] = False,
    options: TrackedOptions = TRACKED_OPTIONS,
) -> int:
    """Count who was found, false people and exchanged identities, by the heads.

    Args:
        paths: recordings in the folder layout, or folders of them, whose groundtruth.npz tells how
            much of each person is hidden (person_occ_inter) and outside (person_outside).
        offline: look both ways in time, as `topview track --offline` does.
    """
    if not paths:
        raise InputError("evaluate people: no folder given; give at least one recording")
    recordings = find_folder_recordings(paths, options.sequences)
    track = track_offline if offline else track_recording
    jobs = [PeopleJob(recording, options.settings, track) for recording in recordings]
    return measure_all(jobs, options, partial(told_of_people, offline=offline))


def mounts(
    *scenes: str,
    seeds: str = "1-10",
    frames: int | None = None,
    size: Size = "320x240",
    options: TrackedOptions = TRACKED_OPTIONS,
) -> int:
    """Count who was found where the camera hangs otherwise, in scenes of the simulator.

    Without a floor in view; 45 degrees down, from 2.6 m; and at 2.6 m, 25 degrees down. Counted is
    what `topview evaluate people` counts.

    Args:
        scenes: of the simulator; two who walk to and fro, one behind the other, if none is named.
        seeds: of people, rooms, motions and noise, separated by commas, or 1-10.
        frames: of each scene, at 30 a second.
        size: of the images, in pixels; both show the same.
    """
    made = make_mounted(scenes, numbers("--seeds", seeds), frames, CAMERAS[size], options.sequences)
    jobs = [PeopleJob(mounted, options.settings) for mounted in made]
    return measure_all(jobs, options, told_of_people)


def returns(
    *,
    behind: str = ",".join(HIDERS),
    seconds: str = "2,5,10",
    seeds: str = "1",
    size: Size = "320x240",
    options: TrackedOptions = TRACKED_OPTIONS,
) -> int:
    """Count who has the same identity after having been hidden entirely.

    Simulated, rendered while it is tracked: two to four people, one of whom walks behind a board or
    behind somebody else, waits there, and comes out on the same side or on the other. The identity
    is the same if in every later frame in which the person is found it is that of before.

    Args:
        behind: what hides, separated by commas: furniture, person.
        seconds: for how long, separated by commas.
        seeds: of people, rooms and noise, separated by commas, or 1-20.
        size: of the images, in pixels; both show the same.
    """
    made = make_hidings(
        behind.split(","),
        numbers("--seconds", seconds),
        numbers("--seeds", seeds),
        CAMERAS[size],
        options.sequences,
    )
    jobs = [ReturnJob(hiding, options.settings) for hiding in made]
    return measure_all(jobs, options, told_of_returns)


def told_of_returns(outcomes: Sequence[ReturnOutcome]) -> Told:
    """By what hides and for how long."""
    rows = returns_by_cover(outcomes)
    return Told(
        rows[ALL].count if rows else 0,
        [returns_table(rows)],
        [each_return_table(outcomes)],
        {"returns": rows_as_json(rows)},
    )


def told_of_people(outcomes: Sequence[PeopleOutcome], *, offline: bool = False) -> Told:
    """By what stands before the first underscore of the recordings' names."""
    counts = count_by_kind(outcomes)
    return Told(
        counts[ALL_KINDS].recordings,
        [found_people_table("people found", counts)],
        [found_people_table("per sequence, worst first", count_each(outcomes))],
        {"offline": offline, "counts": rows_as_json(counts)},
    )
