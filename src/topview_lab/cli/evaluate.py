"""`topview evaluate`: the tracker against reference skeletons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
from cyclopts import App, Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import compile_kernels, warn
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.detect.detectors import DetectorName
from topview.detect.joints.proposers import ProposalsName
from topview.io import write_atomically
from topview.records import InputError
from topview.track import Tracker, TrackerSettings
from topview.track.run import track_offline, track_recording
from topview_lab.cli.simulate import CAMERAS, Size
from topview_lab.datasets import (
    EvaluatedRecording,
    find_berkeley_mhad,
    find_folder_recordings,
    find_itop,
    find_msr_action3d,
    find_utd_mhad,
    make_simulated,
    make_starts,
)
from topview_lab.evaluate.people import (
    ALL_KINDS,
    PeopleJob,
    count_by_kind,
    count_each,
    counts_as_json,
    found_people_table,
)
from topview_lab.evaluate.predictions import Predictions, predicted_jobs
from topview_lab.evaluate.report import print_report, write_json
from topview_lab.evaluate.run import run_all, run_evaluation, run_jobs
from topview_lab.evaluate.starts import (
    ALL_STARTS,
    StartJob,
    each_start_table,
    starts_as_json,
    starts_by_pose,
    starts_table,
)
from topview_lab.metrics import Offsets

DEFAULTS = TrackerSettings()

evaluate = App(name="evaluate", help="Measure the tracker against reference skeletons.")


@Parameter(name="*")
@dataclass(frozen=True)
class TrackedOptions:
    """What everything that is tracked to be measured takes.

    Attributes:
        sequences: globs over the names of the sequences, separated by commas.
        method: the tracker's method.
        detector: how people's heads are found.
        seed: of every random number.
        proposals: what proposes joints to methods that ask for it.
        weights: file of the network's weights.
        json: file for all numbers.
        force: replace the file that is there.
        workers: processes, 0 for one per core; the numbers do not depend on it.
        per_sequence: add a table of the sequences, worst first.
    """

    sequences: str = "*"
    method: str = DEFAULTS.method
    detector: DetectorName = DEFAULTS.detector
    seed: int = DEFAULTS.seed
    proposals: ProposalsName = DEFAULTS.proposals
    weights: Path | None = None
    json: Path | None = None
    force: Annotated[bool, Parameter(negative="")] = False
    workers: int = 0
    per_sequence: Annotated[bool, Parameter(negative="")] = False

    @property
    def settings(self) -> TrackerSettings:
        return TrackerSettings(
            self.method, self.detector, self.seed, 1, self.proposals, self.weights
        )


@Parameter(name="*")
@dataclass(frozen=True)
class EvaluateOptions(TrackedOptions):
    """What every data set with skeletons takes.

    Attributes:
        detail: add tables by cause of occlusion, part, action and body, and of the confidences.
        offsets: one constant offset per joint for the whole set, or for each person of each
            recording.
        offline: look both ways in time, as `topview track --offline` does.
        predictions: measure the skeletons of these files instead of the tracker: a folder with
            NAME.npz or NAME/skeletons.npz of each sequence, or one file.
        map: names of their joints in ours, like nose=head,chest=torso, besides the known ones.
    """

    detail: Annotated[bool, Parameter(negative="")] = False
    offsets: Offsets = "set"
    offline: Annotated[bool, Parameter(negative="")] = False
    predictions: Path | None = None
    map: str = ""

    def made_by(self) -> dict[str, Any]:
        """What the measured skeletons come from, for the file of numbers."""
        if self.predictions is None:
            return self.settings.as_json() | ({"offline": True} if self.offline else {})
        return {"predictions": str(self.predictions), "map": self.map}


DEFAULT_OPTIONS = EvaluateOptions()
TRACKED_OPTIONS = TrackedOptions()


@evaluate.command
def simulated(
    *scenes: str,
    seeds: str = "1",
    people: int | None = None,
    frames: int | None = None,
    size: Size = "320x240",
    options: EvaluateOptions = DEFAULT_OPTIONS,
) -> int:
    """Measure on scenes of the simulator, rendered while they are tracked.

    Args:
        scenes: all of them if none is named; sequences are named like pass_by_1.
        seeds: of people, motions and noise, separated by commas.
        people: how many; more than a scene asks for stand in the background.
        frames: of each scene, at 30 a second.
        size: of the images, in pixels; both show the same.
    """
    made = make_simulated(
        scenes, _numbers("--seeds", seeds), people, frames, CAMERAS[size], options.sequences
    )
    return _evaluate(made, "error against the simulator's truth", options)


@evaluate.command(name="mhad")
def mhad(path: Path, /, *, options: EvaluateOptions = DEFAULT_OPTIONS) -> int:
    """Measure on Berkeley MHAD, Kinect 1, against its motion capture.

    Args:
        path: the folder that holds Kinect/, Calibration/ and Mocap/; sequences are named like
            s01_a04_r01.
    """
    return _evaluate(
        find_berkeley_mhad(path, options.sequences),
        "Berkeley MHAD, Kinect 1: error against the motion capture",
        options,
    )


@evaluate.command(name="msr-action3d")
def msr_action3d(path: Path, /, *, options: EvaluateOptions = DEFAULT_OPTIONS) -> int:
    """Measure on MSR Action3D.

    Args:
        path: the folder that holds a01_s01_e01_sdepth.bin and a01_s01_e01_skeleton3D.txt, or
            folders of them; sequences are named like a01_s01_e01.
    """
    return _evaluate(
        find_msr_action3d(path, options.sequences),
        "MSR Action3D: agreement with its skeletons (a reference, not truth)",
        options,
    )


@evaluate.command
def itop(path: Path, /, *, split: str = "test", options: EvaluateOptions = DEFAULT_OPTIONS) -> int:
    """Measure on the side view of ITOP; needs the extra `datasets`.

    Args:
        path: the folder that holds ITOP_side_test_depth_map.h5 and ITOP_side_test_labels.h5; each
            person is a sequence named like test_00.
        split: test or train.
    """
    return _evaluate(
        find_itop(path, split, options.sequences),
        "ITOP, side view: error against its labels",
        options,
    )


@evaluate.command(name="utd-mhad")
def utd_mhad(path: Path, /, *, options: EvaluateOptions = DEFAULT_OPTIONS) -> int:
    """Measure on UTD-MHAD.

    Args:
        path: the folder that holds Depth/ and Skeleton/; sequences are named like a1_s1_t1.
    """
    return _evaluate(
        find_utd_mhad(path, options.sequences),
        "UTD-MHAD: agreement with the Kinect SDK v1 skeleton (a reference, not truth)",
        options,
    )


@evaluate.command
def folder(
    *paths: Path,
    mirrored: Annotated[bool, Parameter(negative="")] = False,
    options: EvaluateOptions = DEFAULT_OPTIONS,
) -> int:
    """Measure on recordings in the folder layout that have a groundtruth.npz.

    Args:
        paths: recordings, or folders of recordings.
        mirrored: the images are flipped left-right, the ground truth is not.
    """
    if not paths:
        raise InputError("evaluate folder: no folder given; give at least one recording")
    return _evaluate(
        find_folder_recordings(paths, options.sequences, mirrored),
        "error against the recordings' own ground truth",
        options,
    )


@evaluate.command
def starts(
    *poses: str,
    seeds: str = "1",
    size: Size = "320x240",
    options: TrackedOptions = TRACKED_OPTIONS,
) -> int:
    """Measure how soon somebody is tracked who is in some pose from the first frame on.

    Over the frames from 0.5 s on: the share of visible joints within 15 cm, and of frames whose
    trunk is turned by less than 45 degrees. A start holds where both are 90 % or more.

    Args:
        poses: all 20 of them if none is named; sequences are named like squatting_left_1.
        seeds: of bodies, rooms and noise, separated by commas.
        size: of the images, in pixels; both show the same.
    """
    made = make_starts(poses, _numbers("--seeds", seeds), CAMERAS[size], options.sequences)
    _check_output(options)
    _check_tracker(options)
    run = run_all([StartJob(start, options.settings) for start in made], options.workers)
    done = [outcome for outcome in run.results if outcome is not None]
    warn(*(problem for outcome in done for problem in outcome.problems), *run.problems)
    rows = starts_by_pose(done)
    measured = rows[ALL_STARTS][ALL_STARTS].count if rows else 0
    if measured:
        console = plain_console()
        console.print(starts_table(rows))
        if options.per_sequence:
            console.print(each_start_table(done))
        if options.json is not None:
            report = {"settings": options.settings.as_json(), "starts": starts_as_json(rows)}
            write_atomically(options.json, msgspec.json.format(msgspec.json.encode(report)))
    return _status(measured, len(made), run.interrupted)


@evaluate.command
def people(*paths: Path, options: TrackedOptions = TRACKED_OPTIONS) -> int:
    """Count who was found, false people and exchanged identities, by the heads.

    Args:
        paths: recordings in the folder layout, or folders of them, whose groundtruth.npz tells how
            much of each person is hidden (person_occ_inter) and outside (person_outside).
    """
    if not paths:
        raise InputError("evaluate people: no folder given; give at least one recording")
    recordings = find_folder_recordings(paths, options.sequences)
    _check_output(options)
    _check_tracker(options)
    jobs = [PeopleJob(recording, options.settings) for recording in recordings]
    run = run_all(jobs, options.workers)
    done = [outcome for outcome in run.results if outcome is not None]
    warn(*(problem for outcome in done for problem in outcome.problems), *run.problems)
    counts = count_by_kind(done)
    measured = counts[ALL_KINDS].recordings
    if measured:
        console = plain_console()
        console.print(found_people_table("people found", counts))
        if options.per_sequence:
            console.print(found_people_table("per sequence, worst first", count_each(done)))
        if options.json is not None:
            made = {"settings": options.settings.as_json(), "counts": counts_as_json(counts)}
            write_atomically(options.json, msgspec.json.format(msgspec.json.encode(made)))
    return _status(measured, len(jobs), run.interrupted)


def _numbers(option: str, text: str) -> tuple[int, ...]:
    if not re.fullmatch("[0-9]{1,9}(,[0-9]{1,9})*", text):
        raise InputError(f"{option} is {text!r}; it must be whole numbers like 1,2,3")
    return tuple(int(number) for number in text.split(","))


def _pairs(text: str) -> dict[str, str]:
    pairs = [pair.split("=") for pair in text.split(",") if pair]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise InputError(f"--map is {text!r}; it must be theirs=ours, like nose=head,chest=torso")
    return {theirs.strip(): ours.strip() for theirs, ours in pairs}


def _check_output(options: TrackedOptions) -> None:
    """Not to find out after the last recording."""
    if options.json is not None:
        prepare_output_file("--json", options.json, options.force)


def _check_tracker(options: TrackedOptions) -> None:
    """What cannot be used is told once, not for each recording."""
    Tracker(options.settings)
    compile_kernels()


def _evaluate(
    recordings: Sequence[EvaluatedRecording], title: str, options: EvaluateOptions
) -> int:
    _check_output(options)
    if options.predictions is None:
        _check_tracker(options)
        track = track_offline if options.offline else track_recording
        run = run_evaluation(recordings, options.settings, options.workers, track=track)
    elif options.offline:
        raise InputError(
            "--predictions are skeletons that are there already, and --offline is how to track; "
            "leave one of them out"
        )
    else:
        predictions = Predictions(options.predictions, _pairs(options.map))
        jobs = predicted_jobs(recordings, predictions)
        run = run_jobs(jobs, workers=1, what="measuring")
        title = f"{title}; skeletons of {options.predictions}"
    warn(*run.problems)
    measured = len(run.evaluation.sequences)
    if measured:
        counted = f"{title}: {measured} of {run.planned} recordings"
        summary = print_report(
            run.evaluation,
            plain_console(),
            counted,
            options.offsets,
            options.per_sequence,
            options.detail,
        )
        if options.json is not None:
            write_json(options.json, summary, title, options.made_by(), run.problems)
    return _status(measured, run.planned, run.interrupted)


def _status(measured: int, planned: int, interrupted: bool) -> int:
    """Exit status after so many of the planned recordings were measured."""
    if interrupted:
        warn(f"interrupted: {measured} of {planned} recordings")
        return INTERRUPTED
    if not measured:
        raise InputError(f"none of the {planned} recordings could be evaluated")
    return 0 if measured == planned else UNUSABLE_INPUT
