"""`skeletons.npz`: everything that is known about the tracked people."""

from __future__ import annotations

import json
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.io.naming import naming
from topview.io.writers.output import write_atomically
from topview.records import JOINT_STATE_NAMES, InputError, SkeletonSequence

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


def write_skeletons_npz(sequence: SkeletonSequence, path: str | PathLike[str]) -> None:
    """Write `KEYS`, byte for byte the same for equal content; no pickles.

    `settings` is JSON text with sorted keys. NumPy dates every member 1980-01-01, so that the
    time of writing leaves no trace.

    Raises:
        InputError: it cannot be written; the old file, if any, is then unharmed.
    """
    arrays: dict[str, Any] = {
        key: getattr(sequence, key).astype(dtype) for key, dtype in NUMBERS.items()
    }
    arrays["joint_names"] = np.array(sequence.joint_names, dtype=np.str_)
    arrays["part_names"] = np.array(sequence.part_names, dtype=np.str_)
    arrays["joint_state_names"] = np.array(JOINT_STATE_NAMES)
    arrays["settings"] = np.array(json.dumps(sequence.settings, sort_keys=True))
    data = BytesIO()
    np.savez_compressed(data, allow_pickle=False, **arrays)
    write_atomically(Path(path), data.getvalue())


def read_skeletons_npz(path: str | PathLike[str]) -> SkeletonSequence:
    """Read what `write_skeletons_npz` wrote.

    Raises:
        InputError: missing, truncated, or not a file of skeletons.
    """
    path = Path(path)
    with naming(path):
        arrays = _read_arrays(path.read_bytes())
        missing = [key for key in KEYS if key not in arrays]
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
                key: arrays[key].astype(dtype) for key, dtype in NUMBERS.items()
            }
            settings = json.loads(str(arrays["settings"]))
        except (ValueError, TypeError) as error:
            raise InputError(f"has a damaged value ({error}); it must be a skeletons.npz") from None
        return SkeletonSequence(
            **numbers,
            joint_names=tuple(arrays["joint_names"].tolist()),
            part_names=tuple(arrays["part_names"].tolist()),
            settings=settings,
        )


def _read_arrays(data: bytes) -> dict[str, NDArray[Any]]:
    try:
        with np.load(BytesIO(data), allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}
    # Damaged archives raise BadZipFile, zlib.error, ValueError, EOFError, AttributeError, ...
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"is truncated or damaged ({reason}); it must be a skeletons.npz"
        ) from None
