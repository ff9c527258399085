"""Where people's heads are in a rendered recording, and how much of them is to be seen."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from topview.files import naming, read_archive
from topview.records import InputError
from topview_lab.metrics.heads import TrueHeads

HEAD_NAME: Final = "head"
_OF_PEOPLE: Final = ("present", "person_occ_inter", "person_outside")
_KEYS: Final = ("names", "joints", *_OF_PEOPLE)


def read_true_heads(path: Path) -> TrueHeads:
    """From a `groundtruth.npz` with `names` [K], `joints` [F, R, K, 3] in metres, `present` [F, R],
    and the shares `person_occ_inter` and `person_outside` [F, R], NaN for whoever is not in the
    room.

    Args:
        path: of the file.

    Raises:
        InputError: the file is missing or damaged, lacks a key or a head, or does not fit.
    """
    with naming(path):
        return true_heads_from(read_archive(path))


def true_heads_from(arrays: Mapping[str, Any]) -> TrueHeads:
    """From what a `groundtruth.npz` holds.

    Raises:
        InputError: it lacks a key or a head, or does not fit.
    """
    if missing := [key for key in _KEYS if key not in arrays]:
        raise InputError(
            f"lacks {', '.join(missing)}; to count people, the truth must tell how much of "
            "each is hidden and outside of the image"
        )
    names = [str(name) for name in arrays["names"]]
    if HEAD_NAME not in names:
        raise InputError(f"names are {', '.join(names)}; {HEAD_NAME} must be among them")
    joints = arrays["joints"]
    if joints.ndim != 4 or joints.shape[2:] != (len(names), 3):
        raise InputError(f"joints is {joints.shape}; it must be frames x people x {len(names)} x 3")
    for key in _OF_PEOPLE:
        if arrays[key].shape != joints.shape[:2]:
            raise InputError(f"{key} is {arrays[key].shape}; it must be {joints.shape[:2]}")
    hidden, outside = arrays["person_occ_inter"], arrays["person_outside"]
    is_in_room = np.isfinite(hidden) & np.isfinite(outside)
    heads_camera = joints[:, :, names.index(HEAD_NAME)].astype(np.float64)
    return TrueHeads(
        np.where(is_in_room[..., None], heads_camera, np.nan),
        np.where(is_in_room, (1.0 - hidden) * (1.0 - outside), 0.0),
        np.where(is_in_room, outside, 1.0),
        arrays["present"].astype(bool),
    )
