"""`topview train-unseen-limbs`: where limbs that are out of sight are, from captured motion."""

from __future__ import annotations

import shlex
from io import BytesIO
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from topview.cli.outputs import prepare_output_file
from topview.io import write_atomically
from topview_lab.training.poses import read_captures
from topview_lab.training.unseen_limbs import fit_unseen_limbs

LIMBS_COMMAND = "train-unseen-limbs"


def train_unseen_limbs(
    captures: Path,
    /,
    *,
    out: Path,
    leave_out: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Learn where limbs are that are out of sight, where no joints are proposed.

    Takes the mean and the covariance of what captured people look like. The same captures give the
    same numbers.

    Args:
        captures: .npz of captured motion as rotations of bones.
        out: the .npz to write; it takes effect as
            src/topview/track/methods/topview/data/unseen_limbs.npz.
        leave_out: names of captures that are not taken.
        force: replace the file that is there.
    """
    prepare_output_file("--out", out, force)
    captured = read_captures(captures, leave_out or ())
    words = ["topview", LIMBS_COMMAND, captures.name]
    if leave_out:
        words += ["--leave-out", *leave_out]
    limbs = fit_unseen_limbs(captured, f"{len(captured)} captured poses; {shlex.join(words)}")
    buffer = BytesIO()
    np.savez(buffer, source=limbs.source, mean=limbs.mean, covariance=limbs.covariance)
    write_atomically(out, buffer.getvalue())
    print(f"{out} written: {limbs.source}")
