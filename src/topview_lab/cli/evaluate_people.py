"""`topview evaluate people`: who is found, and under which id."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from topview.records import InputError
from topview_lab.cli.tracked import TRACKED_OPTIONS, Told, TrackedOptions, measure_all
from topview_lab.datasets import find_folder_recordings
from topview_lab.evaluate.people import (
    ALL_KINDS,
    PeopleJob,
    PeopleOutcome,
    count_by_kind,
    count_each,
    counts_as_json,
    found_people_table,
)


def people(*paths: Path, options: TrackedOptions = TRACKED_OPTIONS) -> int:
    """Count who was found, false people and exchanged identities, by the heads.

    Args:
        paths: recordings in the folder layout, or folders of them, whose groundtruth.npz tells how
            much of each person is hidden (person_occ_inter) and outside (person_outside).
    """
    if not paths:
        raise InputError("evaluate people: no folder given; give at least one recording")
    recordings = find_folder_recordings(paths, options.sequences)
    jobs = [PeopleJob(recording, options.settings) for recording in recordings]
    return measure_all(jobs, options, told_of_people)


def told_of_people(outcomes: Sequence[PeopleOutcome]) -> Told:
    """By what stands before the first underscore of the recordings' names."""
    counts = count_by_kind(outcomes)
    return Told(
        counts[ALL_KINDS].recordings,
        [found_people_table("people found", counts)],
        [found_people_table("per sequence, worst first", count_each(outcomes))],
        {"counts": counts_as_json(counts)},
    )
