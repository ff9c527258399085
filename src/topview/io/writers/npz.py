"""`skeletons.npz`: everything that is known about the tracked people."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_archive
from topview.io.camera_values import camera_from, camera_values
from topview.io.writers.output import write_atomically
from topview.records import JOINT_STATE_NAMES, InputError, SkeletonSequence

# Of the layout that is written. Files without one are version 1; every version is read.
FORMAT_VERSION: Final = 2

# Key to stored type; shapes and units are those of `SkeletonSequence`.
NUMBERS: Final[dict[str, type[np.number[Any]]]] = {
    "frame_index": np.int64,
    "timestamps_s": np.float64,
    "person_ids": np.int64,
    "joints_camera": np.float64,
    "joint_state": np.uint8,
    "joint_confidence": np.float32,
    "Ts_camera_part": np.float64,
    "heights_m": np.float64,
}
KEYS: Final = (*NUMBERS, "joint_names", "part_names", "joint_state_names", "settings")
NUMBERS_SINCE_2: Final[dict[str, type[np.number[Any]]]] = {
    "floor_camera": np.float64,
    "gravity_camera": np.float64,
}
KEYS_SINCE_2: Final = (*NUMBERS_SINCE_2, "frame_names", "camera", "topview_version")


def write_skeletons_npz(sequence: SkeletonSequence, path: str | PathLike[str]) -> None:
    """Write `format_version` and all keys, byte for byte the same for equal content; no pickles.

    `settings` and `camera` are JSON text with sorted keys; a camera is told as in `camera.json`,
    and `null` if it is not known. NumPy dates every member 1980-01-01, so that the time of writing
    leaves no trace.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    arrays: dict[str, Any] = {
        key: getattr(sequence, key).astype(dtype)
        for key, dtype in (NUMBERS | NUMBERS_SINCE_2).items()
    }
    camera = None if sequence.camera is None else camera_values(sequence.camera)
    arrays["format_version"] = np.array(FORMAT_VERSION, np.int64)
    arrays["camera"] = np.array(json.dumps(camera, sort_keys=True))
    arrays["frame_names"] = np.array(sequence.frame_names, dtype=np.str_)
    arrays["topview_version"] = np.array(sequence.topview_version)
    arrays["joint_names"] = np.array(sequence.joint_names, dtype=np.str_)
    arrays["part_names"] = np.array(sequence.part_names, dtype=np.str_)
    arrays["joint_state_names"] = np.array(JOINT_STATE_NAMES)
    arrays["settings"] = np.array(json.dumps(sequence.settings, sort_keys=True))
    data = BytesIO()
    np.savez_compressed(data, allow_pickle=False, **arrays)
    write_atomically(Path(path), data.getvalue())


def read_skeletons_npz(path: str | PathLike[str]) -> SkeletonSequence:
    """Read what `write_skeletons_npz` wrote, by this version of topview or an earlier one.

    Raises:
        InputError: missing, truncated, not a file of skeletons, or of a later version.
    """
    path = Path(path)
    with naming(path):
        arrays = read_archive(path, "it must be a skeletons.npz")
        since_2 = format_version(arrays) >= 2
        keys = KEYS + KEYS_SINCE_2 if since_2 else KEYS
        missing = [key for key in keys if key not in arrays]
        if missing:
            raise InputError(f"has no {', '.join(missing)}; it must be a skeletons.npz")
        state_names = tuple(map(str, arrays["joint_state_names"].tolist()))
        if state_names != JOINT_STATE_NAMES:
            raise InputError(
                f"joint_state_names are {', '.join(state_names)}; "
                f"they must be {', '.join(JOINT_STATE_NAMES)}"
            )
        try:
            numbers: dict[str, Any] = {
                key: arrays[key].astype(dtype)
                for key, dtype in (NUMBERS | NUMBERS_SINCE_2 if since_2 else NUMBERS).items()
            }
            settings = json.loads(str(arrays["settings"]))
            about = _about(arrays) if since_2 else {}
        except (ValueError, TypeError) as error:
            raise InputError(f"has a damaged value ({error}); it must be a skeletons.npz") from None
        return SkeletonSequence(
            **numbers,
            joint_names=tuple(arrays["joint_names"].tolist()),
            part_names=tuple(arrays["part_names"].tolist()),
            settings=settings,
            **about,
        )


def format_version(arrays: Mapping[str, NDArray[Any]]) -> int:
    """Of the layout of an archive's arrays.

    Raises:
        InputError: it is later than what this version of topview knows, or no version.
    """
    version = np.asarray(arrays.get("format_version", 1))
    if version.shape != () or version.dtype.kind not in "iu" or version < 1:
        raise InputError(f"format_version is {version}; it must be 1 to {FORMAT_VERSION}")
    if version > FORMAT_VERSION:
        raise InputError(
            f"format_version is {version}, which a later topview wrote; "
            f"this one reads 1 to {FORMAT_VERSION}"
        )
    return int(version)


def _about(arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """What is neither numbers nor settings, of version 2."""
    camera = json.loads(str(arrays["camera"]))
    return {
        "frame_names": tuple(map(str, arrays["frame_names"].tolist())),
        "camera": None if camera is None else camera_from(camera),
        "topview_version": str(arrays["topview_version"]),
    }
