"""`topview train-bias`: how far off found poses are, learnt from recordings with truth."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.progress import compile_kernels, warn
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.io import write_atomically
from topview.records import InputError
from topview.track.methods.topview.bias import PoseBias
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings
from topview_lab.evaluate.run import run_all
from topview_lab.training.bias import BiasJob, BiasRows, errors_m, fit_bias
from topview_lab.training.people_fit import described


def train_bias(
    *folders: Path,
    out: Path,
    workers: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Learn how far off poses are, where no joints are proposed.

    Tracks the recordings without proposals, and fits a linear law of what is found to where the
    true joints are; then once more with that law, and writes what is fitted to that. The same
    recordings give the same numbers with any number of workers.

    Args:
        folders: recordings with groundtruth.npz, or folders of such.
        out: the .npz to write; it takes effect as
            src/topview/track/methods/topview/data/bias.npz.
        workers: processes, 0 for one per core.
        force: replace the file that is there.
    """
    if not folders:
        raise InputError("train-bias: no folder given; give at least one recording")
    prepare_output_file("--out", out, force)
    recordings = find_folder_recordings(folders)
    compile_kernels()
    command = shlex.join(["topview", "train-bias", *(path.resolve().name for path in folders)])
    first = _learnt(recordings, None, workers, command)
    learnt = first and _learnt(recordings, first[0], workers, command)
    if learnt is None:
        return INTERRUPTED
    law, count = learnt
    buffer = BytesIO()
    np.savez(buffer, source=law.source, weights=law.weights, lowest=law.lowest, highest=law.highest)
    write_atomically(out, buffer.getvalue())
    print(f"{out} written: {law.source}")
    return 0 if count == len(recordings) else UNUSABLE_INPUT


def _learnt(
    recordings: Sequence[EvaluatedRecording], before: PoseBias | None, workers: int, command: str
) -> tuple[PoseBias, int] | None:
    """The law of poses that are tracked with the one before, and of how many recordings it is; None
    if it is interrupted."""
    jobs = [BiasJob(own, before) for own in recordings]
    done = run_all(jobs, workers)
    if done.interrupted:
        return None
    warn(*(own for own in done.results if isinstance(own, str)), *done.problems)
    usable = {
        job.recording.name: own
        for job, own in zip(jobs, done.results, strict=True)
        if isinstance(own, BiasRows)
    }
    if not usable:
        raise InputError(f"none of the {len(recordings)} recordings could be used")
    rows = BiasRows.joined([*usable.values()])
    law = fit_bias(rows, f"{described(usable)}; {command}")
    before_cm, after_cm = 100.0 * errors_m(rows), 100.0 * errors_m(rows, law)
    print(f"{len(rows.traits)} poses, joints off by {before_cm:.2f} cm, after it {after_cm:.2f} cm")
    return law, len(usable)
