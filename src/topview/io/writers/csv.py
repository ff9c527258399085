"""`skeletons.csv`: the joints in long form, for spreadsheets and data frames."""

from __future__ import annotations

import codecs
import csv
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Final

import numpy as np

from topview.io.writers.output import written_atomically
from topview.records import JOINT_STATE_NAMES
from topview.skeletons import Skeletons, SkeletonSequence

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


def write_skeletons_csv(skeletons: Skeletons, path: str | PathLike[str]) -> None:
    """One line for each frame, person who is there, and joint, in that order; people as their slots
    come. Absent joints have no coordinates.

    Positions are in the camera frame, to 0.01 mm.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    with written_atomically(Path(path)) as file:
        writer = csv.writer(codecs.getwriter("utf-8")(file), lineterminator="\n")
        writer.writerow(COLUMNS)
        for block in skeletons.blocks():
            writer.writerows(_rows(block))


def _rows(block: SkeletonSequence) -> Iterator[tuple[str | int, ...]]:
    for f, s in np.argwhere(block.present):
        frame = int(block.frame_index[f]), f"{block.timestamps_s[f]:.6f}"
        person_id = int(block.person_ids[f, s])
        joints = block.joints_camera[f, s].tolist()
        states = block.joint_state[f, s].tolist()
        confidences = block.joint_confidence[f, s].tolist()
        for name, joint, state, confidence in zip(
            block.joint_names, joints, states, confidences, strict=True
        ):
            position = map(_metres, joint)
            yield *frame, person_id, name, *position, JOINT_STATE_NAMES[state], f"{confidence:.4f}"


def _metres(value: float) -> str:
    return f"{value:.5f}" if abs(value) < np.inf else ""
