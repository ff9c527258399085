"""What the commands have in common that track recordings with truth to learn from them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from topview.cli.outputs import prepare_output_file
from topview.cli.progress import compile_kernels, warn
from topview.records import InputError
from topview_lab.datasets import EvaluatedRecording, find_folder_recordings
from topview_lab.evaluate.run import run_all
from topview_lab.training.people_fit import described

Rows = TypeVar("Rows", covariant=True)


class TrainingJob(Protocol[Rows]):
    """One recording to be tracked: gives rows to fit to, or why there are none."""

    @property
    def recording(self) -> EvaluatedRecording: ...

    def __call__(self) -> Rows | str: ...


def recordings_to_learn_from(
    command: str, folders: Sequence[Path], out: Path, force: bool
) -> Sequence[EvaluatedRecording]:
    """The recordings of a command, once it is sure that what is learnt can be written.

    Raises:
        InputError: no folder, one that cannot be used, or a file that cannot be written.
    """
    if not folders:
        raise InputError(f"{command}: no folder given; give at least one recording")
    prepare_output_file("--out", out, force)
    recordings = find_folder_recordings(folders)
    compile_kernels()
    return recordings


def rows_by_name(jobs: Sequence[TrainingJob[Rows]], workers: int) -> dict[str, Rows] | None:
    """What the jobs give, by the names of their recordings; None if they are interrupted.

    Raises:
        InputError: no recording could be used.
    """
    done = run_all(jobs, workers)
    if done.interrupted:
        return None
    warn(*(own for own in done.results if isinstance(own, str)), *done.problems)
    usable = {
        job.recording.name: own
        for job, own in zip(jobs, done.results, strict=True)
        if own is not None and not isinstance(own, str)
    }
    if not usable:
        raise InputError(f"none of the {len(jobs)} recordings could be used")
    return usable


def learnt_from(names: Sequence[str], command: str, folders: Sequence[Path]) -> str:
    """What a law is learnt from, and how: recordings' names, and the command."""
    words = ["topview", command, *(path.resolve().name for path in folders)]
    return f"{described(names)}; {shlex.join(words)}"
