"""`topview train-confidence`: how far joints are off, learnt from recordings with truth."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Final

import msgspec
from cyclopts import Parameter
from rich.table import Table

from topview.cli.printing import plain_console
from topview.cli.progress import warn
from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.detect.joints.proposers import NETWORK
from topview.io import write_atomically
from topview.records import InputError
from topview.track import TrackerSettings
from topview.track.joint_errors import JointErrors, shipped_joint_errors
from topview_lab.cli.training_runs import recordings_to_learn_from
from topview_lab.evaluate.run import run_all
from topview_lab.evaluate.tables import empty_table
from topview_lab.training.joint_errors import (
    KINDS,
    ErrorRows,
    ErrorsJob,
    TermErrors,
    fit_joint_errors,
    with_counts,
)
from topview_lab.training.people_fit import described

WITH_AND_WITHOUT: Final = (
    TrackerSettings(threads=1, proposals=NETWORK),
    TrackerSettings(threads=1, proposals="none"),
)
"""How each recording is tracked: the two kinds of joints have weights of their own."""
COUNTS: Final = "; counts: "  # in `JointErrors.source`, before what these were counted on


def train_confidence(
    *folders: Path,
    out: Path,
    counts: Annotated[bool, Parameter(negative="")] = False,
    workers: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Learn how far joints are off.

    Tracks the recordings twice, with proposed joints and without, and fits what their covariances
    and confidences follow from. The same recordings give the same numbers with any number of
    workers. `topview evaluate folder OTHERS --detail` tells how often what is stated then holds.

    Args:
        folders: recordings with groundtruth.npz, or folders of such.
        out: the .json to write; it takes effect as src/topview/track/joint_errors.json.
        counts: keep the weights that ship, and count anew how large errors are beside them.
        workers: processes, 0 for one per core.
        force: replace the file that is there.
    """
    recordings = recordings_to_learn_from("train-confidence", folders, out, force)
    jobs = [ErrorsJob(own, settings) for settings in WITH_AND_WITHOUT for own in recordings]
    done = run_all(jobs, workers)
    if done.interrupted:
        return INTERRUPTED
    warn(*(own for own in done.results if isinstance(own, str)), *done.problems)
    count = len(recordings)
    usable = [
        [own for own in done.results[first : first + count] if isinstance(own, TermErrors)]
        for first in range(0, len(jobs), count)
    ]
    if not all(usable):
        raise InputError(f"none of the {count} recordings could be used")
    rows = ErrorRows.joined([ErrorRows.of(own) for own in usable])
    words = ["topview", "train-confidence", *(path.resolve().name for path in folders)]
    words += ["--counts"] * counts
    source = f"{described(own.of_behind.name for own in usable[0])}; {shlex.join(words)}"
    errors = _as_shipped(rows, source) if counts else fit_joint_errors(rows, source)
    write_atomically(out, msgspec.json.format(msgspec.json.encode(errors), indent=2))
    plain_console().print(_table(errors, len(rows.kinds)))
    print(f"{out} written: {source}")
    return 0 if sum(map(len, usable)) == len(jobs) else UNUSABLE_INPUT


def _as_shipped(rows: ErrorRows, source: str) -> JointErrors:
    """The weights that ship, with errors that were counted anew."""
    shipped = shipped_joint_errors()
    laws, _, _ = shipped.source.partition(COUNTS)
    shipped = msgspec.structs.replace(shipped, source=f"{laws}{COUNTS}{source}")
    return with_counts(shipped, rows)


def _table(errors: JointErrors, count: int) -> Table:
    table = empty_table(f"how far {count} joints are off", "term")
    table.add_column("weight", justify="right")
    numbers = {term: own for term, own in msgspec.structs.asdict(errors).items() if term != "laws"}
    for what, law in zip(KINDS, errors.laws, strict=True):
        numbers |= {f"{what}: tails": law.tails, f"{what}: ellipsoid": law.ellipsoid}
    for name, value in numbers.items():
        if name != "source":
            table.add_row(name, f"{value:g}")
    return table
