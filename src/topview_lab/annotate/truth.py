"""Joints as `groundtruth.npz`, which `topview evaluate folder` takes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import read_archive
from topview.io import write_atomically
from topview.records import InputError
from topview_lab.annotate.joints import JointBasis, Joints
from topview_lab.annotate.landmarks import ANGLE_JOINTS, NAMES, relative_angles_deg

TRUTH_FILE: Final = "groundtruth.npz"
SOURCE: Final = "topview annotate"


def truth_arrays(
    joints: Joints,
    statures_m: NDArray[np.float64],
    T_front_rear: NDArray[np.float64],
    offset_s: float,
) -> dict[str, NDArray[Any]]:
    """What the file holds. F frames, P people, J joints, A angles.

    `names` [J], `joints` [F, P, J, 3] metres in the front camera's frame, `present` [F, P] True
    where all of a person's joints are known, `ids` [P], `stature` [P]; `seen` [F, P, J] an index
    into `seen_names`; `relative_angles_deg` [F, P, A] between consecutive bones at the middle one
    of the joints `angle_joints` [A, 3]; `T_front_rear` [4, 4]; `offset_s`, by which the rear
    recording is late; `source`.
    """
    present = np.asarray(np.isfinite(joints.places_front).all((-1, -2)))
    return {
        "names": np.array(NAMES),
        "joints": joints.places_front.astype(np.float32),
        "present": present,
        "ids": np.arange(1, present.shape[1] + 1),
        "stature": statures_m.astype(np.float32),
        "seen": joints.seen,
        "seen_names": np.array([seen.name.lower() for seen in JointBasis]),
        "relative_angles_deg": relative_angles_deg(joints.places_front).astype(np.float32),
        "angle_joints": np.array(ANGLE_JOINTS),
        "T_front_rear": T_front_rear,
        "offset_s": np.array(offset_s),
        "source": np.array(SOURCE),
    }


def check_own(path: Path) -> None:
    """Do not replace somebody else's truth.

    Raises:
        InputError: the file is there, and not one of ours.
    """
    if not path.exists():
        return
    try:
        is_own = str(read_archive(path).get("source")) == SOURCE
    except (InputError, OSError):
        is_own = False
    if not is_own:
        raise InputError(
            f"{path} is there already and was not made by {SOURCE}; give --out another folder"
        )


def write_truth(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write whole or not at all."""
    check_own(path)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # pyright: ignore[reportArgumentType]
    write_atomically(path, buffer.getvalue())
