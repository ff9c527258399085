"""Files with skeletons of any system, `.npz` or `.csv`, as one set of arrays.

`docs/bridge.md` describes them. Nothing here knows joint names or checks values.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import read_archive
from topview.io.writers.npz import format_version
from topview.records import InputError

NEEDED_KEYS: Final = ("joint_names", "joints_camera")
NEEDED_COLUMNS: Final = ("frame_index", "joint", "x_m", "y_m", "z_m")

Arrays = dict[str, NDArray[Any]]
Row = dict[str, str | None]


def read_arrays(path: Path) -> Arrays:
    """The arrays of a file, keyed as in `skeletons.npz`; both `NEEDED_KEYS` are among them.

    Raises:
        InputError: it is unreadable, lacks something, or a later topview wrote it; one line,
            without the path.
    """
    return _from_csv(path) if path.suffix.lower() == ".csv" else _from_npz(path)


def _from_npz(path: Path) -> Arrays:
    right = f"it must be an .npz archive with {' and '.join(NEEDED_KEYS)}"
    try:
        arrays = read_archive(path, right)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error}); {right}") from None
    format_version(arrays)
    missing = [key for key in NEEDED_KEYS if key not in arrays]
    if missing:
        raise InputError(f"has no {', '.join(missing)} (it has {', '.join(arrays)}); {right}")
    return arrays


def _from_csv(path: Path) -> Arrays:
    """One line for each frame, person and joint. Person 1 where no `person_id` is told; the state
    is not read, as a joint without coordinates is absent."""
    right = f"it must be a .csv file with the columns {', '.join(NEEDED_COLUMNS)}"
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            columns = tuple(reader.fieldnames or ())
            rows = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
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
    frames, people, joints = (
        {key: place for place, key in enumerate(dict.fromkeys(column))}
        for column in zip(*keys, strict=True)
    )
    values = np.full((len(frames), len(people), len(joints), 4), np.nan)
    seen: set[tuple[int, int, str]] = set()
    for (line, row), key in zip(rows, keys, strict=True):
        if key in seen:
            raise InputError(f"line {line}: {key[2]} is told again; it must be once a frame")
        seen.add(key)
        place = frames[key[0]], people[key[1]], joints[key[2]]
        values[place] = [_number(row, name, line) for name in ("x_m", "y_m", "z_m", "confidence")]
    arrays: Arrays = {
        "frame_index": np.array(list(frames), np.int64),
        "person_ids": np.array(list(people), np.int64),
        "joint_names": np.array(list(joints)),
        "joints_camera": values[..., :3],
    }
    if np.isfinite(values[..., 3]).any():
        arrays["joint_confidence"] = values[..., 3]
    return arrays


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
