"""`topview train-poses`: the poses that whole bodies are looked up in, from captured motion."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from topview.cli.outputs import prepare_output_file
from topview.cli.printing import plain_console
from topview.io import write_atomically
from topview_lab.training.poses import PosesRecipe, make_table, read_captures


def train_poses(
    captures: Path,
    /,
    *,
    out: Path,
    leave_out: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    force: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Make the table of poses that whole bodies are looked up in.

    The same captures give the same table.

    Args:
        captures: .npz of captured motion as rotations of bones.
        out: the .npz to write; it takes effect as
            src/topview/track/methods/topview/data/poses.npz.
        leave_out: names of captures that are not taken.
        force: replace the file that is there.
    """
    prepare_output_file("--out", out, force)
    recipe = PosesRecipe()
    captured = read_captures(captures, leave_out or ())
    table = make_table(captured, recipe)
    buffer = BytesIO()
    np.savez_compressed(buffer, **table)  # pyright: ignore[reportArgumentType]
    write_atomically(out, buffer.getvalue())
    poses, directions = table["yaws"].shape
    plain_console().print(
        f"{out} written: {poses} poses of {len(captured)} captured, in {directions} directions each"
    )
