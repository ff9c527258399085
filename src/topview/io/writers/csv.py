"""`skeletons.csv`: the joints in long form, for spreadsheets and data frames."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np

from topview.io.writers.output import write_atomically
from topview.records import JOINT_STATE_NAMES, SkeletonSequence

COLUMNS: Final = (
    "frame_index",
    "timestamp_s",
    "person_id",
    "joint",
    "x_m",
    "y_m",
    "z_m",
    "state",
    "confidence",
)


def write_skeletons_csv(sequence: SkeletonSequence, path: str | PathLike[str]) -> None:
    """One line per frame, person and joint, in that order; absent joints have no coordinates.

    Positions are in the camera frame, to 0.01 mm.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_rows(sequence))
    write_atomically(Path(path), text.getvalue().encode())


def _rows(sequence: SkeletonSequence) -> Iterator[tuple[str | int, ...]]:
    shape = sequence.joint_state.shape
    for f, p, j in np.ndindex(*shape):
        yield (
            int(sequence.frame_index[f]),
            f"{sequence.timestamps_s[f]:.6f}",
            int(sequence.person_ids[p]),
            sequence.joint_names[j],
            *(_metres(x) for x in sequence.joints_camera[f, p, j]),
            JOINT_STATE_NAMES[sequence.joint_state[f, p, j]],
            f"{sequence.joint_confidence[f, p, j]:.4f}",
        )


def _metres(value: float) -> str:
    return f"{value:.5f}" if np.isfinite(value) else ""
