"""`camera.json`: the cameras of a folder recording, its depth unit and its frame rate."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.io.naming import naming
from topview.io.readers.registration import ColorCamera
from topview.records import Camera, InputError

DEFAULT_FPS = 30.0  # of the Kinect and its successors
MAX_FPS = 1000.0  # ours
METRES_PER_UNIT_RANGE = (1e-5, 1e-2)  # ours; below, 16 bits do not reach 1 m; above, steps of cm
INTRINSICS_KEYS = ("fx", "fy", "cx", "cy", "width", "height")
REQUIRED_KEYS = (*INTRINSICS_KEYS, "depth_scale")
COLOR_KEYS = (*INTRINSICS_KEYS, "T_color_depth")
ROTATION_TOLERANCE = 0.01  # ours; of R R', for numbers written with three digits
MAX_BASELINE_M = 5.0  # ours; beyond, the numbers are millimetres


@dataclass(frozen=True, slots=True)
class CameraFile:
    """What `camera.json` holds.

    Attributes:
        camera: of the depth images.
        metres_per_unit: of the stored depth.
        fps: frames per second.
        color: what the colour images come from; None where they are registered to the depth.
    """

    camera: Camera
    metres_per_unit: float
    fps: float
    color: ColorCamera | None = None


def read_camera_json(path: Path) -> CameraFile:
    """Read {fx, fy, cx, cy, width, height, depth_scale} and, where given, fps and color, itself
    {fx, fy, cx, cy, width, height, T_color_depth}; other keys are ignored.

    Raises:
        InputError: missing, not JSON, or a value that no camera has; names file, key and value.
    """
    with naming(path, right=f"it must be a file with {', '.join(REQUIRED_KEYS)}"):
        values = _json_object(path.read_bytes())
        _require(values, REQUIRED_KEYS)
        camera = _camera(values)
        fps = _number(values, "fps") if "fps" in values else DEFAULT_FPS
        if not 0.0 < fps <= MAX_FPS:
            raise InputError(f"fps is {fps:g}; it must be above 0, up to {MAX_FPS:g} per second")
        scale = metres_per_unit(_number(values, "depth_scale"))
    with naming(Path(f"{path}: color")):
        color = _color_camera(values["color"]) if "color" in values else None
    return CameraFile(camera, scale, fps, color)


def metres_per_unit(depth_scale: float) -> float:
    """Metres per stored depth unit, from either convention in use.

    Below 1 the scale is metres per unit (0.001, as RealSense says it), above 1 it is units per
    metre (1000, as TUM RGB-D says it). 1 itself reads the same both ways, depth in whole metres,
    which no camera records: it is refused, as a file whose author left the scale out.

    Raises:
        InputError: a scale that gives no usable depth from 16-bit values.
    """
    low, high = METRES_PER_UNIT_RANGE
    if isfinite(depth_scale) and depth_scale > 0.0:
        metres = depth_scale if depth_scale < 1.0 else 1.0 / depth_scale
        if low <= metres <= high:
            return metres
    raise InputError(
        f"depth_scale is {depth_scale:g}; it must be metres per unit ({low:g} to {high:g}) "
        f"or units per metre ({1 / high:g} to {1 / low:g}): 0.001 or 1000 for millimetres"
    )


def _require(values: dict[str, Any], keys: tuple[str, ...]) -> None:
    missing = [key for key in keys if key not in values]
    if missing:
        raise InputError(f"has no {', '.join(missing)}; it must have {', '.join(keys)}")


def _camera(values: dict[str, Any]) -> Camera:
    return Camera(
        fx=_number(values, "fx"),
        fy=_number(values, "fy"),
        cx=_number(values, "cx"),
        cy=_number(values, "cy"),
        width=_whole_number(values, "width"),
        height=_whole_number(values, "height"),
    )


def _color_camera(values: Any) -> ColorCamera:
    if not isinstance(values, dict):
        raise InputError(f"is {json.dumps(values)}; it must be {{{', '.join(COLOR_KEYS)}}}")
    _require(values, COLOR_KEYS)
    return ColorCamera(_camera(values), _rigid_transform(values["T_color_depth"]))


def _rigid_transform(rows: Any) -> NDArray[np.float64]:
    """[4, 4] metres, from four rows of four numbers."""
    is_matrix = isinstance(rows, list) and [_length(row) for row in rows] == [4] * 4
    if not is_matrix or not all(_is_number(value) for row in rows for value in row):
        raise InputError("T_color_depth must be 4 x 4 numbers: a list of four rows of four")
    T = np.array(rows, np.float64)
    R = T[:3, :3]
    with np.errstate(over="ignore"):
        off = np.abs(R @ R.T - np.eye(3)).max()
    if not off < ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise InputError(
            "the upper left 3 x 3 of T_color_depth is no rotation; its rows must be at right "
            "angles, one long and right-handed"
        )
    if T[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise InputError(f"the last row of T_color_depth is {T[3].tolist()}; it must be 0, 0, 0, 1")
    baseline_m = float(np.linalg.norm(T[:3, 3]))
    if not baseline_m <= MAX_BASELINE_M:
        raise InputError(
            f"T_color_depth puts the cameras {baseline_m:g} m apart; its last column must be "
            f"metres, up to {MAX_BASELINE_M:g}"
        )
    return T


def _length(row: Any) -> int:
    return len(row) if isinstance(row, list) else 0


def _json_object(data: bytes) -> dict[str, Any]:
    try:
        values = json.loads(data)
    except ValueError as error:
        raise InputError(f"is not JSON ({error})") from None
    if not isinstance(values, dict):
        raise InputError(f"holds a JSON {type(values).__name__}; it must be an object {{...}}")
    return values


def _number(values: dict[str, Any], key: str) -> float:
    value = values[key]
    if not _is_number(value):
        raise InputError(f"{key} is {json.dumps(value)}; it must be a number")
    return float(value)


def _is_number(value: Any) -> bool:
    """True for what JSON calls a number, infinity left out."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and not abs(value) > 1e308


def _whole_number(values: dict[str, Any], key: str) -> int:
    number = _number(values, key)
    if not number.is_integer():
        raise InputError(f"{key} is {number:g}; it must be a whole number of pixels")
    return int(number)
