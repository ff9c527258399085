"""`camera.json`: the cameras of a folder recording, its depth unit and its frame rate."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_bytes
from topview.io.camera_values import (
    INTRINSICS_KEYS,
    camera_from,
    number,
    require,
    shown_json,
    transform,
)
from topview.io.readers.registration import ColorCamera
from topview.records import Camera, InputError

DEFAULT_FPS = 30.0  # of the Kinect and its successors
MIN_FPS, MAX_FPS = 0.1, 1000.0  # ours
METRES_PER_UNIT_RANGE = (1e-5, 1e-2)  # ours; below, 16 bits do not reach 1 m; above, steps of cm
REQUIRED_KEYS = (*INTRINSICS_KEYS, "depth_scale")
MOST_JSON_BYTES = 2**20  # ours; all there is to tell takes a thousandth of it
COLOR_KEYS = (*INTRINSICS_KEYS, "T_color_depth")
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


def read_camera_json(path: Path, is_float: bool = False) -> CameraFile:
    """Read {fx, fy, cx, cy, width, height, depth_scale} and, where given, distortion, sensor,
    T_world_camera, fps and color, itself {fx, fy, cx, cy, width, height, T_color_depth} and, where
    given, distortion. Other keys are ignored, unless they seem to tell of a lens.

    Args:
        path: of the file.
        is_float: depth is stored as floating point numbers: metres, if depth_scale is 1 or missing.

    Raises:
        InputError: missing, not JSON, a value that no camera has, or a key that seems to tell of
            a lens and is not known; names file, key and value.
    """
    required = INTRINSICS_KEYS if is_float else REQUIRED_KEYS
    with naming(path, right=f"it must be a file with {', '.join(required)}"):
        values = json_object(read_bytes(path, MOST_JSON_BYTES))
        require(values, required)
        camera = camera_from(values)
        fps = number(values, "fps") if "fps" in values else DEFAULT_FPS
        if not MIN_FPS <= fps <= MAX_FPS:
            raise InputError(f"fps is {fps:g}; it must be {MIN_FPS:g} to {MAX_FPS:g} per second")
        depth_scale = number(values, "depth_scale") if "depth_scale" in values else 1.0
        is_metres = is_float and depth_scale == 1.0
        scale = 1.0 if is_metres else metres_per_unit(depth_scale)
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


def _color_camera(values: Any) -> ColorCamera:
    if not isinstance(values, dict):
        raise InputError(f"is {shown_json(values)}; it must be {{{', '.join(COLOR_KEYS)}}}")
    require(values, COLOR_KEYS)
    return ColorCamera(camera_from(values), _T_color_depth(values))


def _T_color_depth(values: dict[str, Any]) -> NDArray[np.float64]:
    """[4, 4] metres."""
    T = transform(values, "T_color_depth")
    baseline_m = float(np.linalg.norm(T[:3, 3]))
    if not baseline_m <= MAX_BASELINE_M:
        raise InputError(
            f"T_color_depth puts the cameras {baseline_m:g} m apart; its last column must be "
            f"metres, up to {MAX_BASELINE_M:g}"
        )
    return T


def json_object(data: bytes) -> dict[str, Any]:
    """Raises InputError where a text is no JSON object. Errors do not name the file."""
    try:
        values = json.loads(data)
    except RecursionError:
        raise InputError("is nested too deeply; it must be an object {...}") from None
    except ValueError as error:
        raise InputError(f"is not JSON ({error})") from None
    if not isinstance(values, dict):
        raise InputError(f"holds a JSON {type(values).__name__}; it must be an object {{...}}")
    return values
