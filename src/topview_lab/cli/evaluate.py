"""`topview evaluate`: the tracker against reference skeletons."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.cli.progress import warn
from topview.io import write_atomically
from topview.records import InputError
from topview.track.run import track_offline, track_recording
from topview_lab.cli.evaluate_facing import facing
from topview_lab.cli.evaluate_mirror import mirror
from topview_lab.cli.evaluate_people import mounts, people, returns
from topview_lab.cli.simulate import CAMERAS, Size
from topview_lab.cli.tracked import (
    DEFAULT_OPTIONS,
    TRACKED_OPTIONS,
    EvaluateOptions,
    Told,
    TrackedOptions,
    check_output,
    check_tracker,
    measure_all,
    numbers,
    status,
)
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
from topview_lab.evaluate.predictions import Predictions, predicted_jobs
from topview_lab.evaluate.report import print_report, write_json
from topview_lab.evaluate.run import run_evaluation, run_jobs
from topview_lab.evaluate.starts import (
    ALL_STARTS,
    StartJob,
    StartOutcome,
    each_start_table,
    starts_as_json,
    starts_by_pose,
    starts_table,
)
from topview_lab.evaluate.worst import worst_png, worst_recordings

evaluate = App(name="evaluate", help="Measure the tracker against reference skeletons.")
evaluate.command(people)
evaluate.command(mounts)
evaluate.command(returns)
evaluate.command(mirror)
evaluate.command(facing)


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
        seeds: of people, motions and noise, separated by commas, or 1-20.
        people: how many; more than a scene asks for stand in the background.
        frames: of each scene, at 30 a second.
        size: of the images, in pixels; both show the same.
    """
    made = make_simulated(
        scenes, numbers("--seeds", seeds), people, frames, CAMERAS[size], options.sequences
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
        seeds: of bodies, rooms and noise, separated by commas, or 1-20.
        size: of the images, in pixels; both show the same.
    """
    made = make_starts(poses, numbers("--seeds", seeds), CAMERAS[size], options.sequences)
    jobs = [StartJob(start, options.settings) for start in made]
    return measure_all(jobs, options, told_of_starts)


def told_of_starts(outcomes: Sequence[StartOutcome]) -> Told:
    """By pose and direction."""
    rows = starts_by_pose(outcomes)
    measured = rows[ALL_STARTS][ALL_STARTS].count if rows else 0
    return Told(
        measured,
        [starts_table(rows)] if measured else (),
        [each_start_table(outcomes)],
        {"starts": starts_as_json(rows)},
    )


def _pairs(text: str) -> dict[str, str]:
    pairs = [pair.split("=") for pair in text.split(",") if pair]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise InputError(f"--map is {text!r}; it must be theirs=ours, like nose=head,chest=torso")
    return {theirs.strip(): ours.strip() for theirs, ours in pairs}


def _evaluate(
    recordings: Sequence[EvaluatedRecording], title: str, options: EvaluateOptions
) -> int:
    check_output(options)
    if options.worst is not None:
        prepare_output_file("--worst", options.worst, options.force)
    if options.predictions is None:
        check_tracker(options)
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
        if options.worst is not None:
            worst = worst_recordings(run.evaluation, options.offsets)
            write_atomically(options.worst, worst_png(worst, recordings))
    return status(measured, run.planned, run.interrupted)
