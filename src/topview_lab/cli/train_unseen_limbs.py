"""`topview train-unseen-limbs`: where limbs that are out of sight are, learnt from recordings with
truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from topview.cli.status import INTERRUPTED, UNUSABLE_INPUT
from topview_lab.cli.training_runs import (
    learnt_from,
    recordings_to_learn_from,
    rows_by_name,
    write_law,
)
from topview_lab.training.unseen_limbs import LimbRows, LimbsJob, chords_of, fit_unseen_limbs

LIMBS_COMMAND = "train-unseen-limbs"


def train_unseen_limbs(
    *folders: Path,
    out: Path,
    workers: int = 0,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Learn where limbs are that are out of sight, where no joints are proposed.

    Tracks the recordings without proposals, and fits a linear law of what is found to where the
    true limbs point. The same recordings give the same numbers with any number of workers.

    Args:
        folders: recordings with groundtruth.npz, or folders of such.
        out: the .npz to write; it takes effect as
            src/topview/track/methods/topview/data/unseen_limbs.npz.
        workers: processes, 0 for one per core.
        force: replace the file that is there.
    """
    recordings = recordings_to_learn_from(LIMBS_COMMAND, folders, out, force)
    usable = rows_by_name([LimbsJob(own) for own in recordings], workers)
    if usable is None:
        return INTERRUPTED
    rows = LimbRows.joined([*usable.values()])
    law = fit_unseen_limbs(rows, learnt_from([*usable], LIMBS_COMMAND, folders))
    print(
        f"{len(rows.traits)} poses, chords of limbs out of sight {chords_of(rows):.3f}, "
        f"after it {chords_of(rows, law):.3f}"
    )
    write_law(out, law)
    return 0 if len(usable) == len(recordings) else UNUSABLE_INPUT
