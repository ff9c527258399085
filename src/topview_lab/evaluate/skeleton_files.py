"""Files with skeletons of any system, `.npz` or `.csv`, as one set of arrays.

`docs/bridge.md` describes them. Nothing here knows joint names or checks values.
"""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterator
from io import StringIO
from math import prod
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import MOST_UNPACKED_BYTES, Archive, read_text
from topview.io.writers.npz import BLOCK_FRAMES, OF_FRAMES, OF_JOINT_FRAMES, format_version
from topview.records import InputError
from topview.skeletons import Slots

NEEDED_KEYS: Final = ("joint_names", "joints_camera")
NEEDED_COLUMNS: Final = ("frame_index", "joint", "x_m", "y_m", "z_m")

Arrays = dict[str, NDArray[Any]]
Row = dict[str, str | None]


def read_arrays(path: Path, frames: NDArray[np.int64]) -> Arrays:
    """The arrays of a file, keyed as in `skeletons.npz`; both `NEEDED_KEYS` are among them.

    Of an archive that tells a `frame_index`, only the frames that are asked for are kept, so that
    a file of any length can be read.

    Raises:
        InputError: it is unreadable, lacks something, or a later topview wrote it; one line,
            without the path.
    """
    return _from_csv(path) if path.suffix.lower() == ".csv" else _from_npz(path, frames)


def _from_npz(path: Path, frames: NDArray[np.int64]) -> Arrays:
    right = f"it must be an .npz archive with {' and '.join(NEEDED_KEYS)}"
    try:
        with Archive(path, right) as archive:
            format_version(archive)
            missing = [key for key in NEEDED_KEYS if key not in archive]
            if missing:
                told = ", ".join(archive)
                raise InputError(f"has no {', '.join(missing)} (it has {told}); {right}")
            return _chosen(archive, frames)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error}); {right}") from None


def _chosen(archive: Archive, frames: NDArray[np.int64]) -> Arrays:
    """All arrays; those with a row for each frame, at the given frames alone."""
    index = archive.read("frame_index") if "frame_index" in archive else None
    is_list = index is not None and index.ndim == 1 and index.dtype.kind in "iu"
    if index is None or not is_list or np.isin(index, frames).all():
        archive.check_total()
        return {key: archive.read(key) for key in archive if key not in OF_JOINT_FRAMES}
    check_same_recording(index, frames)
    is_chosen = np.isin(index, frames)
    arrays: Arrays = {}
    for key in archive:
        if key in OF_JOINT_FRAMES:  # joints and parts tell it
            continue
        shape = archive.shape(key)
        if shape[:1] == index.shape and (key in OF_FRAMES or key == "frame_names"):
            blocks = archive.blocks(key, BLOCK_FRAMES)
            starts = range(0, len(index), BLOCK_FRAMES)
            kept = [
                block[is_chosen[start : start + BLOCK_FRAMES]]
                for start, block in zip(starts, blocks, strict=True)
            ]
            arrays[key] = np.concatenate(kept)
        else:
            arrays[key] = archive.read(key)
    return arrays


def check_same_recording(frames: NDArray[Any], expected: NDArray[np.int64]) -> None:
    """Raises InputError if no frame is among the expected ones."""
    if len(frames) and not np.isin(frames, expected).any():
        raise InputError(
            f"has frames {frames.min()} to {frames.max()}, the reference "
            f"{expected.min()} to {expected.max()}; they must be the same recording"
        )


def _from_csv(path: Path) -> Arrays:
    """One line for each frame, person and joint. Person 1 where no `person_id` is told; the state
    is not read, as a joint without coordinates is absent."""
    right = f"it must be a .csv file with the columns {', '.join(NEEDED_COLUMNS)}"
    try:
        reader = csv.DictReader(StringIO(read_text(path, "utf-8-sig", right), newline=""))
        columns = tuple(reader.fieldnames or ())
        rows = [(reader.line_num, row) for row in reader]
    except (OSError, csv.Error) as error:
        raise InputError(f"cannot be read ({' '.join(str(error).split())}); {right}") from None
    missing = [column for column in NEEDED_COLUMNS if column not in columns]
    if missing:
        raise InputError(
            f"has no column {', '.join(missing)} (it has {', '.join(columns)}); {right}"
        )
    if not rows:
        raise InputError(f"has no lines; {right}, and a line for each frame, person and joint")
    return _stacked(rows)


def _stacked(rows: list[tuple[int, Row]]) -> Arrays:
    """The arrays of numbered lines."""
    keys = [
        (
            _whole(row, "frame_index", line),
            _whole(row, "person_id", line) if "person_id" in row else 1,
            str(row["joint"] or "").strip(),
        )
        for line, row in rows
    ]
    joints = {name: j for j, name in enumerate(dict.fromkeys(joint for _, _, joint in keys))}
    people_in: dict[int, set[int]] = defaultdict(set)
    for frame, person_id, _ in keys:
        people_in[frame].add(person_id)
    frames = sorted(people_in)
    slots = Slots()
    place = {
        (frame, person_id): (f, slot)
        for f, frame in enumerate(frames)
        for person_id, slot in _with_slots(slots, sorted(people_in[frame]))
    }
    shape = len(frames), max(map(len, people_in.values())), len(joints), 4
    if 8 * prod(shape) > MOST_UNPACKED_BYTES:
        raise InputError(
            f"has {shape[0]} frames, up to {shape[1]} people in each and {shape[2]} joints; "
            f"their positions must fit into {MOST_UNPACKED_BYTES} bytes"
        )
    values = np.full(shape, np.nan)
    ids = np.zeros(shape[:2], np.int64)
    seen: set[tuple[int, int, str]] = set()
    for (line, row), key in zip(rows, keys, strict=True):
        if key in seen:
            raise InputError(f"line {line}: {key[2]} is told again; it must be once a frame")
        seen.add(key)
        f, s = place[key[:2]]
        ids[f, s] = key[1] + 1  # so that 0 is nobody: others count from 0
        values[f, s, joints[key[2]]] = [
            _number(row, name, line) for name in ("x_m", "y_m", "z_m", "confidence")
        ]
    arrays: Arrays = {
        "frame_index": np.array(frames, np.int64),
        "person_ids": ids,
        "joint_names": np.array(list(joints)),
        "joints_camera": values[..., :3],
    }
    if np.isfinite(values[..., 3]).any():
        arrays["joint_confidence"] = values[..., 3]
    return arrays


def _with_slots(slots: Slots, ids: list[int]) -> Iterator[tuple[int, int]]:
    return zip(ids, slots.of(ids), strict=True)


def _whole(row: Row, column: str, line: int) -> int:
    text = row[column] or ""
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*", text):
        raise InputError(f"line {line}: {column} is {text!r}; it must be a whole number from 0")
    return int(text)


def _number(row: Row, column: str, line: int) -> float:
    """NaN where nothing is told."""
    text = (row.get(column) or "").strip()
    try:
        return float(text) if text else np.nan
    except ValueError:
        raise InputError(f"line {line}: {column} is {text!r}; it must be a number") from None
