"""`groundtruth.npz`, in the two layouts that exist.

Rendered recordings: `names` [K], `joints` [F, R, K, 3], `present` [F, R], and where known
`joint_occ_person`, `joint_occ_furniture`, `joint_occ_self`, `joint_outside` [F, R, K] shares,
`person_outside` [F, R], `ids` [R], `stature` [R], `actions` [F, R], `bodies` [R], and `part_names`
[B] with `Ts_camera_part` [F, R, B, 4, 4]. Keys beyond these are ignored.

Composites of real recordings: `joint_names` [K], `joints` [R, F, K, 3], and where known
`joint_not_behind_other` [R, F, K], which says True where no other layer hides the joint.

Both in metres, camera frame x right, y down, z forward. Wherever a person is present, joints are
finite and within `FARTHEST_READING_M` of the camera; ids differ; statures are those of people.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_archive
from topview.records import FARTHEST_READING_M, InputError
from topview_lab.datasets.joints import our_part_name, select_joints
from topview_lab.metrics import ReferenceSequence

Arrays = Mapping[str, NDArray[Any]]


# What `groundtruth.npz` calls the shares of `ReferenceSequence`.
_SHARES: Final = {
    "occluded_by_person": "joint_occ_person",
    "occluded_by_object": "joint_occ_furniture",
    "occluded_by_self": "joint_occ_self",
    "outside": "joint_outside",
}
_ALL_OUTSIDE: Final = "person_outside"  # the same of the whole person


_NUMBERS: Final = "iuf"
_KINDS: Final = {
    "joints": _NUMBERS,
    "present": "biu",
    "ids": "iu",
    "stature": _NUMBERS,
    "Ts_camera_part": _NUMBERS,
    **dict.fromkeys((*_SHARES.values(), _ALL_OUTSIDE), _NUMBERS),
}
"""What NumPy calls the types that a key may have."""
_KIND_NAMES: Final = {
    "U": "texts",
    "S": "texts",
    "c": "complex numbers",
    "b": "yes or no",
    "f": "real numbers",
}
_RIGHT_KINDS: Final = "ids are whole numbers, present is yes or no, all others are real numbers"
SHORTEST_PERSON_M, TALLEST_PERSON_M = 0.4, 2.8
"""Of people: below a newborn's, above the tallest man's, 2.72 m (ours)."""
GREATEST_ID: Final = 2**53
"""That every table and program keeps apart from its neighbours (ours)."""
ROTATION_ROUNDING: Final = 1e-3
"""By how much R R^T may differ from 1: parts are written in single precision (ours)."""


def read_groundtruth(path: Path, action: str | None = None) -> ReferenceSequence:
    """Either layout, recognised by its keys; the frames are numbered from 0.

    Args:
        path: of the file.
        action: of everybody in all frames, for files without actions.

    Raises:
        InputError: the file is missing or damaged, keys are missing, shapes do not fit, or a
            joint of a present person is not finite.
    """
    with naming(path):
        arrays = read_archive(path)
    try:
        return reference_from(arrays, str(path), action)
    except InputError:  # which is a ValueError, too
        raise
    except (ValueError, TypeError, OverflowError) as error:  # numbers that are texts, and the like
        raise InputError(f"{path} has values of a wrong kind ({error})") from None


def reference_from(arrays: Arrays, source: str, action: str | None = None) -> ReferenceSequence:
    """The reference from the arrays of a `groundtruth.npz`.

    Args:
        arrays: by their keys.
        source: where they come from, for errors.
        action: as above.
    """
    if "names" in arrays:
        reference = _rendered(arrays, source)
    elif "joint_names" in arrays:
        reference = _composite(arrays, source)
    else:
        raise InputError(
            f"{source} has the keys {', '.join(sorted(arrays)) or 'none'}; it must have names, "
            "joints and present, or joint_names and joints"
        )
    if action is None or reference.actions is not None:
        return reference
    return replace(reference, actions=np.full(reference.present.shape, action))


def _rendered(arrays: Arrays, source: str) -> ReferenceSequence:
    _require(arrays, ("names", "joints", "present"), source)
    joints_camera = arrays["joints"]
    F, R, K = _joint_axes(joints_camera, len(arrays["names"]), source)
    shapes = {"present": (F, R), "ids": (R,), "stature": (R,), "actions": (F, R), "bodies": (R,)}
    shapes[_ALL_OUTSIDE] = (F, R)
    shapes |= dict.fromkeys(_SHARES.values(), (F, R, K))
    if "Ts_camera_part" in arrays:
        _require(arrays, ("part_names",), source)
        shapes |= {"Ts_camera_part": (F, R, len(arrays["part_names"]), 4, 4)}
    for key in shapes.keys() & arrays.keys():
        _check_shape(arrays, key, shapes[key], source)
    for key in _KINDS.keys() & arrays.keys():
        if (kind := arrays[key].dtype.kind) not in _KINDS[key]:
            seen = f"{_KIND_NAMES.get(kind, kind)}, such as {arrays[key].ravel()[:1]}"
            raise InputError(f"{source}: {key} are {seen}; {_RIGHT_KINDS}")
    _check_people(arrays, source)
    part_names, Rs_camera_part = _orientations(arrays, source)
    return _reference(
        source,
        names=arrays["names"],
        joints_camera=joints_camera,
        present=arrays["present"].astype(bool),
        shares=_shares(arrays),
        person_ids=arrays.get("ids"),
        statures_m=arrays.get("stature"),
        actions=arrays["actions"].astype(str) if "actions" in arrays else None,
        bodies=tuple(map(str, arrays["bodies"])) if "bodies" in arrays else None,
        part_names=part_names,
        Rs_camera_part=Rs_camera_part,
    )


def _check_people(arrays: Arrays, source: str) -> None:
    """Raises InputError for presence, ids or statures that no people have."""
    present = arrays["present"]
    if present.dtype.kind != "b" and (odd := present[(present != 0) & (present != 1)]).size:
        raise InputError(f"{source}: present has {odd[0]}; it must be yes (1) or no (0)")
    if "ids" in arrays:
        ids: list[int] = arrays["ids"].tolist()
        for person_id in ids:
            if not 0 <= person_id < GREATEST_ID:
                raise InputError(f"{source}: ids has {person_id}; an id must be 0 to 2^53 - 1")
            if ids.count(person_id) > 1:
                raise InputError(f"{source}: ids has {person_id} twice; each person has an own one")
    for stature_m in arrays.get("stature", ()):
        if not SHORTEST_PERSON_M <= stature_m <= TALLEST_PERSON_M:
            raise InputError(
                f"{source}: stature has {stature_m:g}; it must be metres, "
                f"{SHORTEST_PERSON_M:g} to {TALLEST_PERSON_M:g}"
            )


def _orientations(
    arrays: Arrays, source: str
) -> tuple[tuple[str, ...], NDArray[np.float64] | None]:
    """Names and [F, R, B, 3, 3] orientations of those parts that are ours too."""
    if "Ts_camera_part" not in arrays:
        return (), None
    ours = [our_part_name(str(name)) for name in arrays["part_names"]]
    columns = [b for b, name in enumerate(ours) if name is not None]
    names = tuple(name for name in ours if name is not None)
    Rs_camera_part = arrays["Ts_camera_part"][:, :, columns, :3, :3].astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(Rs_camera_part @ np.swapaxes(Rs_camera_part, -1, -2) - np.eye(3)).max((-2, -1))
    is_no_rotation = ~(off <= ROTATION_ROUNDING) & ~np.isnan(Rs_camera_part).any((-2, -1))
    is_no_rotation &= arrays["present"].astype(bool)[..., None]
    if is_no_rotation.any():
        f, r, b = np.argwhere(is_no_rotation)[0]
        raise InputError(
            f"{source}: Ts_camera_part of {names[b]} of person {r + 1} in frame {f} turns by "
            "no rotation; its columns must be units at right angles, or NaN where unknown"
        )
    return names, Rs_camera_part


def _shares(arrays: Arrays) -> dict[str, NDArray[Any]]:
    """What hides each joint. Of one that faces away all round, files say that it is outside, and
    nothing else: where nothing of the person is, the own body hides it."""
    shares = {share: arrays[key] for share, key in _SHARES.items() if key in arrays}
    is_told = {"occluded_by_self", "outside"} <= shares.keys() and _ALL_OUTSIDE in arrays
    if is_told:
        own, outside = shares["occluded_by_self"], shares["outside"]
        is_whole = np.asarray(arrays[_ALL_OUTSIDE] == 0.0)[..., None]
        is_away = (outside == 1.0) & np.isnan(own) & is_whole
        shares["occluded_by_self"] = np.where(is_away, 1.0, own)
        shares["outside"] = np.where(is_away, 0.0, outside)
    return shares


def _composite(arrays: Arrays, source: str) -> ReferenceSequence:
    _require(arrays, ("joint_names", "joints"), source)
    R, F, K = _joint_axes(arrays["joints"], len(arrays["joint_names"]), source)
    shares = {}
    # With one person, what hides a joint is an object.
    if R > 1 and "joint_not_behind_other" in arrays:
        _check_shape(arrays, "joint_not_behind_other", (R, F, K), source)
        is_hidden = ~arrays["joint_not_behind_other"].astype(bool)
        shares = {"occluded_by_person": np.swapaxes(is_hidden, 0, 1)}
    return _reference(
        source,
        names=arrays["joint_names"],
        joints_camera=np.swapaxes(arrays["joints"], 0, 1),
        present=np.ones((F, R), bool),
        shares=shares,
    )


def _reference(
    source: str,
    names: NDArray[np.str_],
    joints_camera: NDArray[np.floating],
    present: NDArray[np.bool_],
    shares: Arrays,
    person_ids: NDArray[Any] | None = None,
    statures_m: NDArray[Any] | None = None,
    **told: Any,
) -> ReferenceSequence:
    """Our joints of [F, R, K, 3], and their shares."""
    joint_names, columns = select_joints([str(name) for name in names], source)
    is_in_reach = (np.abs(joints_camera) <= FARTHEST_READING_M).all(-1)  # NaN is not
    wrong = ~is_in_reach & present[..., None]
    if wrong.any():
        f, r, k = np.argwhere(wrong)[0]
        raise InputError(
            f"{source}: joints has {joints_camera[f, r, k]} for {names[k]} of person {r + 1} in "
            f"frame {f}; wherever the person is present, it must be finite metres, at most "
            f"{FARTHEST_READING_M:g} from the camera"
        )
    F, R = present.shape
    try:
        return ReferenceSequence(
            frame_index=np.arange(F),
            person_ids=np.arange(1, R + 1) if person_ids is None else person_ids.astype(np.int64),
            joint_names=joint_names,
            joints_camera=joints_camera[..., columns, :].astype(np.float64),
            present=present,
            statures_m=None if statures_m is None else statures_m.astype(np.float64),
            **{name: share[..., columns].astype(np.float64) for name, share in shares.items()},
            **told,
        )
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _require(arrays: Arrays, keys: tuple[str, ...], source: str) -> None:
    missing = [key for key in keys if key not in arrays]
    if missing:
        raise InputError(
            f"{source} lacks {', '.join(missing)}; it has {', '.join(sorted(arrays))} and "
            f"must have {', '.join(keys)}"
        )


def _joint_axes(joints: NDArray[Any], joint_count: int, source: str) -> tuple[int, int, int]:
    """The first three axes of `joints`, once they are known to fit the names."""
    if joints.ndim != 4 or joints.shape[2:] != (joint_count, 3) or joints.dtype.kind not in "fiu":
        raise InputError(
            f"{source}: joints is {joints.dtype} {joints.shape}; it must be numbers with four "
            f"axes, the last two {joint_count} (the names) and 3"
        )
    return joints.shape[0], joints.shape[1], joints.shape[2]


def _check_shape(arrays: Arrays, key: str, shape: tuple[int, ...], source: str) -> None:
    if arrays[key].shape != shape:
        raise InputError(
            f"{source}: {key} has shape {arrays[key].shape}; it must be {shape}, as joints has"
        )
