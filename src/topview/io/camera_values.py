"""A camera in words and numbers: how `camera.json` gives it and `skeletons.npz` keeps it."""

from __future__ import annotations

import json
import re
from collections.abc import Collection
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.records import (
    DISTORTION_MODELS,
    MOST_SHOWN,
    Camera,
    Distortion,
    InputError,
    rigid_transform,
)

INTRINSICS_KEYS: Final = ("fx", "fy", "cx", "cy", "width", "height")
MOST_SHOWN_JSON: Final = 160  # characters
DISTORTION_KEYS: Final = ("model", "coefficients")
# What calibrations call a lens: OpenCV's distCoeffs and k1, ROS's D, RealSense's coeffs, the Azure
# Kinect's codx, Bouguet's kc. Compared without case and signs.
LIKE_DISTORTION: Final = re.compile(
    r".*(distor|distcoef|coeff|radial|tangential|lens|rational|conrady|fisheye|kannala|thinprism)"
    r".*|[kps][1-6]|d|dist|kc|cod[xy]|metricradius"
)


def camera_from(values: dict[str, Any]) -> Camera:
    """The camera of an object with `INTRINSICS_KEYS`, maybe distortion {model, coefficients},
    sensor, T_world_camera and gravity_camera; other keys are left alone.

    Raises:
        InputError: something is missing, or no camera has it.
    """
    require(values, INTRINSICS_KEYS)
    refuse_unknown_distortion(values, known=("distortion",))
    return Camera(
        fx=number(values, "fx"),
        fy=number(values, "fy"),
        cx=number(values, "cx"),
        cy=number(values, "cy"),
        width=whole_number(values, "width"),
        height=whole_number(values, "height"),
        distortion=_distortion(values["distortion"]) if "distortion" in values else None,
        sensor=values.get("sensor", "kinect1"),
        T_world_camera=transform(values, "T_world_camera") if "T_world_camera" in values else None,
        gravity_camera=values.get("gravity_camera"),
    )


def camera_values(camera: Camera) -> dict[str, Any]:
    """What `camera_from` takes, in plain JSON types."""
    values: dict[str, Any] = {key: float(getattr(camera, key)) for key in INTRINSICS_KEYS[:4]}
    values |= {"width": int(camera.width), "height": int(camera.height), "sensor": camera.sensor}
    if camera.distortion is not None:
        lens = camera.distortion
        values["distortion"] = {"model": lens.model, "coefficients": list(lens.coefficients)}
    if camera.T_world_camera is not None:
        values["T_world_camera"] = camera.T_world_camera.tolist()
    if camera.gravity_camera is not None:
        values["gravity_camera"] = camera.gravity_camera.tolist()
    return values


def refuse_unknown_distortion(values: dict[str, Any], known: Collection[str]) -> None:
    """Raises InputError for a key that seems to tell of a lens, but is not one of the `known`."""
    for key in values:
        words = re.sub(r"[^a-z0-9]", "", key.lower())
        if key not in known and LIKE_DISTORTION.fullmatch(words):
            raise InputError(
                f"{key[:MOST_SHOWN]} seems to tell of the lens, and is not understood; it must be "
                '"distortion": {"model": "brown_conrady", "coefficients": [k1, k2, p1, p2, k3]}, '
                "or left out if the images are undistorted"
            )


def _distortion(values: Any) -> Distortion:
    right = (
        f'it must be {{"model": one of {", ".join(DISTORTION_MODELS)}, "coefficients": '
        "[k1, k2, p1, p2, ...]}"
    )
    if not isinstance(values, dict) or not set(values) <= set(DISTORTION_KEYS):
        raise InputError(f"distortion is {shown_json(values)}; {right}")
    model, coefficients = values.get("model"), values.get("coefficients", [])
    are_numbers = isinstance(coefficients, list) and all(map(is_number, coefficients))
    if not isinstance(model, str) or not are_numbers:
        raise InputError(f"distortion is {shown_json(values)}; {right}")
    return Distortion(model, tuple(coefficients))


def transform(values: dict[str, Any], key: str) -> NDArray[np.float64]:
    """[4, 4] metres, from four rows of four numbers."""
    rows = values[key]
    is_matrix = isinstance(rows, list) and [_length(row) for row in rows] == [4] * 4
    if not is_matrix or not all(is_number(value) for row in rows for value in row):
        raise InputError(f"{key} must be 4 x 4 numbers: a list of four rows of four")
    return rigid_transform(rows, key)


def require(values: dict[str, Any], keys: tuple[str, ...]) -> None:
    """Raises InputError where one is missing."""
    missing = [key for key in keys if key not in values]
    if missing:
        raise InputError(f"has no {', '.join(missing)}; it must have {', '.join(keys)}")


def number(values: dict[str, Any], key: str) -> float:
    """Raises InputError where it is none."""
    value = values[key]
    if not is_number(value):
        raise InputError(f"{key} is {shown_json(value)}; it must be a number")
    return float(value)


def is_number(value: Any) -> bool:
    """True for what JSON calls a number, infinity left out."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and not abs(value) > 1e308


def whole_number(values: dict[str, Any], key: str) -> int:
    """Raises InputError where it is none."""
    value = number(values, key)
    if not value.is_integer():
        raise InputError(f"{key} is {value:g}; it must be a whole number of pixels")
    return int(value)


def _length(row: Any) -> int:
    return len(row) if isinstance(row, list) else 0


def shown_json(values: Any) -> str:
    """A value as an error tells it: in one short line."""
    try:
        text = json.dumps(values)
    except RecursionError:  # what was read may be nested more deeply than can be written
        return f"a {type(values).__name__} nested too deeply"
    return text if len(text) < MOST_SHOWN_JSON else f"{text[:MOST_SHOWN_JSON]} ..."
