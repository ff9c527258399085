"""`camera.json`: the intrinsics of a folder recording, its depth unit and its frame rate."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from topview.io.naming import naming
from topview.records import Camera, InputError

DEFAULT_FPS = 30.0  # of the Kinect and its successors
MAX_FPS = 1000.0  # ours
METRES_PER_UNIT_RANGE = (1e-5, 1e-2)  # ours; below, 16 bits do not reach 1 m; above, steps of cm
REQUIRED_KEYS = ("fx", "fy", "cx", "cy", "width", "height", "depth_scale")


@dataclass(frozen=True, slots=True)
class CameraFile:
    """What `camera.json` holds: the camera, metres per stored depth unit, frames per second."""

    camera: Camera
    metres_per_unit: float
    fps: float


def read_camera_json(path: Path) -> CameraFile:
    """Read {fx, fy, cx, cy, width, height, depth_scale, fps (optional)}; other keys are ignored.

    Raises:
        InputError: missing, not JSON, or a value that no camera has; names file, key and value.
    """
    with naming(path, right=f"it must be a file with {', '.join(REQUIRED_KEYS)}"):
        values = _json_object(path.read_bytes())
        missing = [key for key in REQUIRED_KEYS if key not in values]
        if missing:
            raise InputError(
                f"has no {', '.join(missing)}; it must have {', '.join(REQUIRED_KEYS)}"
            )
        camera = Camera(
            fx=_number(values, "fx"),
            fy=_number(values, "fy"),
            cx=_number(values, "cx"),
            cy=_number(values, "cy"),
            width=_whole_number(values, "width"),
            height=_whole_number(values, "height"),
        )
        fps = _number(values, "fps") if "fps" in values else DEFAULT_FPS
        if not 0.0 < fps <= MAX_FPS:
            raise InputError(f"fps is {fps:g}; it must be above 0, up to {MAX_FPS:g} per second")
        return CameraFile(camera, metres_per_unit(_number(values, "depth_scale")), fps)


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
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e308:
        raise InputError(f"{key} is {json.dumps(value)}; it must be a number")
    return float(value)


def _whole_number(values: dict[str, Any], key: str) -> int:
    number = _number(values, key)
    if not number.is_integer():
        raise InputError(f"{key} is {number:g}; it must be a whole number of pixels")
    return int(number)
