"""`topview train-bias`: how far off found poses are, learnt from recordings with truth."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview.io import write_atomically
from topview.track.methods.topview.bias import PoseBias
from topview_lab.cli.training_runs import (
    learnt_from,
    recordings_to_learn_from,
    rows_by_name,
)
from topview_lab.datasets import EvaluatedRecording
from topview_lab.training.bias import BiasJob, BiasRows, errors_m, fit_bias

BIAS_COMMAND = "train-bias"


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
    recordings = recordings_to_learn_from(BIAS_COMMAND, folders, out, force)
    first = _learnt(recordings, None, workers, folders)
    learnt = first and _learnt(recordings, first[0], workers, folders)
    if learnt is None:
        return INTERRUPTED
    law, count = learnt
    buffer = BytesIO()
    np.savez(buffer, source=law.source, weights=law.weights, lowest=law.lowest, highest=law.highest)
    write_atomically(out, buffer.getvalue())
    print(f"{out} written: {law.source}")
    return 0 if count == len(recordings) else UNUSABLE_INPUT


def _learnt(
    recordings: Sequence[EvaluatedRecording],
    before: PoseBias | None,
    workers: int,
    folders: Sequence[Path],
) -> tuple[PoseBias, int] | None:
    """The law of poses that are tracked with the one before, and of how many recordings it is; None
    if it is interrupted."""
    usable = rows_by_name([BiasJob(own, before) for own in recordings], workers)
    if usable is None:
        return None
    rows = BiasRows.joined([*usable.values()])
    law = fit_bias(rows, learnt_from([*usable], BIAS_COMMAND, folders))
    before_cm, after_cm = 100.0 * errors_m(rows), 100.0 * errors_m(rows, law)
    print(f"{len(rows.traits)} poses, joints off by {before_cm:.2f} cm, after it {after_cm:.2f} cm")
    return law, len(usable)
