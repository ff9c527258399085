"""`groundtruth.npz`, in the two layouts that exist.

Rendered recordings: `names` [K], `joints` [F, R, K, 3], `present` [F, R], and where known
`joint_occ_person` [F, R, K], `ids` [R], `stature` [R].

Composites of real recordings: `joint_names` [K], `joints` [R, F, K, 3], and where known
`joint_not_behind_other` [R, F, K], which says True where no other layer hides the joint.

Both in metres, camera frame x right, y down, z forward.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.evaluate.joints import select_joints
from topview.evaluate.metrics import ReferenceSequence
from topview.records import InputError

Arrays = Mapping[str, NDArray[Any]]


def read_groundtruth(path: Path) -> ReferenceSequence:
    """Either layout, recognised by its keys; the frames are numbered from 0.

    Raises:
        InputError: the file is missing or damaged, keys are missing, shapes do not fit, or a
            joint of a present person is not finite.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = dict(archive)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} cannot be read as an .npz archive: {error}") from error
    if "names" in arrays:
        return _rendered(arrays, path)
    if "joint_names" in arrays:
        return _composite(arrays, path)
    raise InputError(
        f"{path} has the keys {', '.join(sorted(arrays)) or 'none'}; it must have names, joints "
        "and present, or joint_names and joints"
    )


def _rendered(arrays: Arrays, path: Path) -> ReferenceSequence:
    _require(arrays, ("names", "joints", "present"), path)
    joints_camera = arrays["joints"]
    F, R, K = _joint_axes(joints_camera, len(arrays["names"]), path)
    _check_shape(arrays, "present", (F, R), path)
    for name, shape in {"joint_occ_person": (F, R, K), "ids": (R,), "stature": (R,)}.items():
        if name in arrays:
            _check_shape(arrays, name, shape, path)
    return _reference(
        path,
        names=arrays["names"],
        joints_camera=joints_camera,
        present=arrays["present"].astype(bool),
        occluded=arrays.get("joint_occ_person"),
        person_ids=arrays.get("ids"),
        statures_m=arrays.get("stature"),
    )


def _composite(arrays: Arrays, path: Path) -> ReferenceSequence:
    _require(arrays, ("joint_names", "joints"), path)
    R, F, K = _joint_axes(arrays["joints"], len(arrays["joint_names"]), path)
    occluded = None
    # With one person, what hides a joint is an object.
    if R > 1 and "joint_not_behind_other" in arrays:
        _check_shape(arrays, "joint_not_behind_other", (R, F, K), path)
        occluded = np.swapaxes(~arrays["joint_not_behind_other"].astype(bool), 0, 1)
    return _reference(
        path,
        names=arrays["joint_names"],
        joints_camera=np.swapaxes(arrays["joints"], 0, 1),
        present=np.ones((F, R), bool),
        occluded=occluded,
    )


def _reference(
    path: Path,
    names: NDArray[np.str_],
    joints_camera: NDArray[np.floating],
    present: NDArray[np.bool_],
    occluded: NDArray[Any] | None,
    person_ids: NDArray[Any] | None = None,
    statures_m: NDArray[Any] | None = None,
) -> ReferenceSequence:
    """Our joints of [F, R, K, 3]."""
    joint_names, columns = select_joints([str(name) for name in names], str(path))
    unknown = ~np.isfinite(joints_camera).all(-1) & present[..., None]
    if unknown.any():
        f, r, k = np.argwhere(unknown)[0]
        raise InputError(
            f"{path}: joint {names[k]} of person {r + 1} in frame {f} is {joints_camera[f, r, k]}; "
            "it must be finite metres wherever the person is present"
        )
    F, R = present.shape
    return ReferenceSequence(
        frame_index=np.arange(F),
        person_ids=np.arange(1, R + 1) if person_ids is None else person_ids.astype(np.int64),
        joint_names=joint_names,
        joints_camera=joints_camera[..., columns, :].astype(np.float64),
        present=present,
        occluded_by_person=None if occluded is None else occluded[..., columns].astype(np.float64),
        statures_m=None if statures_m is None else statures_m.astype(np.float64),
    )


def _require(arrays: Arrays, keys: tuple[str, ...], path: Path) -> None:
    missing = [key for key in keys if key not in arrays]
    if missing:
        raise InputError(
            f"{path} lacks {', '.join(missing)}; it has {', '.join(sorted(arrays))} and must have "
            f"{', '.join(keys)}"
        )


def _joint_axes(joints: NDArray[Any], joint_count: int, path: Path) -> tuple[int, int, int]:
    """The first three axes of `joints`, once they are known to fit the names."""
    if joints.ndim != 4 or joints.shape[2:] != (joint_count, 3) or joints.dtype.kind not in "fiu":
        raise InputError(
            f"{path}: joints is {joints.dtype} {joints.shape}; it must be numbers with four axes, "
            f"the last two {joint_count} (the names) and 3"
        )
    return joints.shape[0], joints.shape[1], joints.shape[2]


def _check_shape(arrays: Arrays, key: str, shape: tuple[int, ...], path: Path) -> None:
    if arrays[key].shape != shape:
        raise InputError(
            f"{path}: {key} has shape {arrays[key].shape}; it must be {shape}, as joints has"
        )
