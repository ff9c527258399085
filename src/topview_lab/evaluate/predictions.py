"""Measure any system by its skeleton files, one for each recording, in place of the tracker.

`docs/bridge.md` describes the files. Missing statures and part frames are computed from the joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body import PART_NAMES
from topview.geometry.rotations import transform
from topview.records import JOINT_STATE_NAMES, ROTATION_TOLERANCE, InputError, JointState
from topview.skeletons import NOBODY_ID, SkeletonSequence, columns_as_slots, people_of
from topview_lab.datasets import EvaluatedRecording
from topview_lab.evaluate.part_frames import rotations_from_joints, statures_from_joints
from topview_lab.evaluate.run import Outcome
from topview_lab.evaluate.skeleton_files import check_same_recording, read_arrays
from topview_lab.evaluate.vocabulary import find_joints
from topview_lab.metrics import ReferenceSequence, measure_sequence

FARTHEST_JOINT_M: Final = 50.0
"""Joints further away than this cannot be in metres (ours)."""

CONFIDENCE_SLACK: Final = 0.01
"""By which a confidence may pass 0 and 1, of rounding (ours)."""

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Predictions:
    """Where predicted skeletons lie, and what their joints are called.

    Attributes:
        path: a file, for one recording, or a folder with NAME.npz or NAME/skeletons.npz of each;
            or the same as .csv.
        more: their joint names to ours, besides the known ones.
    """

    path: Path
    more: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.path.exists():
            raise InputError(f"{self.path}: no such file or folder; it must hold predictions")

    def file_of(self, name: str) -> Path:
        """The file of a recording. Raises InputError where there is none."""
        if self.path.is_file():
            return self.path
        places = [
            place
            for suffix in ("npz", "csv")
            for place in (self.path / f"{name}.{suffix}", self.path / name / f"skeletons.{suffix}")
        ]
        for place in places:
            if place.is_file():
                return place
        raise InputError(
            f"{self.path} has no predictions for it; there must be {places[0].name} or "
            f"{name}/{places[1].name}, or .csv files of these names"
        )


@dataclass(frozen=True, slots=True)
class PredictedJob:
    """One recording whose skeletons come from a file."""

    recording: EvaluatedRecording
    predictions: Predictions

    def __call__(self) -> Outcome:
        name = self.recording.name
        try:
            reference = self.recording.reference()
            predicted = read_predictions(
                self.predictions.file_of(name), reference, self.predictions.more
            )
            return Outcome(measure_sequence(predicted, reference, name), ())
        except InputError as error:
            return Outcome(None, (f"{name}: {error}",))


def predicted_jobs(
    recordings: Sequence[EvaluatedRecording], predictions: Predictions
) -> list[PredictedJob]:
    """A job for each recording.

    Raises:
        InputError: one file, but several recordings.
    """
    if predictions.path.is_file() and len(recordings) > 1:
        raise InputError(
            f"{predictions.path} is one file for {len(recordings)} recordings; it must be a folder "
            "with NAME.npz of each, or choose one with --sequences"
        )
    return [PredictedJob(recording, predictions) for recording in recordings]


def read_predictions(
    path: Path, reference: ReferenceSequence, more: Mapping[str, str] | None = None
) -> SkeletonSequence:
    """Read skeletons at the frames of a reference, with our joints; missing frames hold nobody.

    Raises:
        InputError: the file is unreadable, or what it holds cannot be compared; one line.
    """
    try:
        arrays = read_arrays(path, reference.frame_index)
        return _predictions(arrays, reference, more, str(path))
    except InputError as error:
        message = str(error)
        raise InputError(
            message if message.startswith(str(path)) else f"{path}: {message}"
        ) from None


def _predictions(
    arrays: Arrays, reference: ReferenceSequence, more: Mapping[str, str] | None, source: str
) -> SkeletonSequence:
    _check_lists(arrays)
    joints = _joints(arrays)
    F, S, K = joints.shape[:3]
    frames = _frame_index(arrays, F, reference)
    columns = find_joints([str(name) for name in arrays["joint_names"]], source, more)
    names = tuple(columns)
    joints = np.stack([joints[:, :, c].mean(2) for c in columns.values()], 2)
    confidence = _confidence(arrays, (F, S, K))
    confidence = np.stack([confidence[:, :, c].mean(2) for c in columns.values()], 2)
    state = np.where(np.isfinite(joints).all(-1), JointState.VISIBLE, JointState.ABSENT)
    rotations = _rotations(arrays, names, joints)
    people = _people(arrays, frames, names, joints)

    # At the reference's frames; missing ones hold nobody.
    last = max(int(frames.max(initial=0)), int(reference.frame_index.max(initial=0)))
    row = np.full(last + 1, F)
    row[frames] = np.arange(F)
    rows = row[reference.frame_index]

    def placed(values: NDArray[Any], absent: float) -> NDArray[Any]:
        nobody = np.full((1, *values.shape[1:]), absent, values.dtype)
        return np.concatenate([values, nobody])[rows]

    return SkeletonSequence(
        frame_index=reference.frame_index.copy(),
        timestamps_s=_times_s(arrays, frames, reference.frame_index),
        joint_names=names,
        joints_camera=placed(joints, np.nan),
        joint_state=placed(_states(arrays, columns, state.astype(np.uint8)), JointState.ABSENT),
        joint_confidence=placed(confidence.astype(np.float32), np.nan),
        part_names=PART_NAMES,
        Ts_camera_part=placed(transform(rotations, np.zeros((F, S, len(PART_NAMES), 3))), np.nan),
        person_ids=placed(people.pop("person_ids"), NOBODY_ID),
        **people,
    )


def _people(
    arrays: Arrays,
    frames: NDArray[np.int64],
    names: tuple[str, ...],
    joints: NDArray[np.float64],
) -> dict[str, Any]:
    """Who is where, as in a `SkeletonSequence`, of [F, S, N, 3] joints."""
    F, S = joints.shape[:2]
    present = np.asarray(np.isfinite(joints).all(-1).any(-1))
    ids = arrays.get("person_ids", np.arange(1, S + 1))
    if ids.shape not in ((S,), (F, S)) or ids.dtype.kind not in "iu":
        raise InputError(
            f"person_ids is {ids.dtype} {ids.shape}; it must be whole numbers, "
            f"{(S,)} of columns or {(F, S)} of slots"
        )
    if ids.ndim == 1:
        numbered = ids.astype(np.int64) + (1 - ids.min(initial=1))  # so that 0 is nobody
        heights_m = _numbers(arrays, "heights_m", (S,), statures_from_joints(names, joints))
        return columns_as_slots(numbered, present, frames, heights_m)
    ids = np.where(present, ids, NOBODY_ID).astype(np.int64)
    _check_once(ids, frames)
    people = people_of(ids, frames)
    heights_m = [
        _told_height(arrays, i) or float(statures_from_joints(names, joints[ids == i][:, None])[0])
        for i in people["people_ids"]
    ]
    return people | {"person_ids": ids, "heights_m": np.array(heights_m, np.float64)}


def _check_once(ids: NDArray[np.int64], frames: NDArray[np.int64]) -> None:
    """Raises InputError for a frame with somebody twice."""
    ordered = np.sort(ids, 1)
    twice = (ordered[:, 1:] == ordered[:, :-1]) & (ordered[:, 1:] != NOBODY_ID)
    for f, s in np.argwhere(twice)[:1]:
        raise InputError(
            f"person_ids has {ordered[f, s]} twice in frame {frames[f]}; "
            "each person must be there once"
        )


def _told_height(arrays: Arrays, person_id: int) -> float | None:
    """Of somebody, where the file has a table of people."""
    if "people_ids" not in arrays:
        return None
    P = len(arrays["people_ids"])
    ids, heights_m = _numbers(arrays, "people_ids", (P,), 0), _numbers(arrays, "heights_m", (P,), 0)
    told = heights_m[ids == person_id]
    return float(told[0]) if len(told) else None


def _check_lists(arrays: Arrays) -> None:
    for key in ("joint_names", "part_names", "joint_state_names", "people_ids"):
        if key in arrays and arrays[key].ndim != 1:
            raise InputError(f"{key} has shape {arrays[key].shape}; it must be a list")


def _joints(arrays: Arrays) -> NDArray[np.float64]:
    """[F, P, K, 3], NaN where missing."""
    joints = arrays["joints_camera"]
    K = len(arrays["joint_names"])
    if joints.ndim == 3:
        joints = joints[:, None]
    if joints.ndim != 4 or joints.shape[2:] != (K, 3) or joints.dtype.kind not in "fiu":
        raise InputError(
            f"joints_camera is {joints.dtype} {arrays['joints_camera'].shape}; it must be numbers, "
            f"frames x people x {K} (the joint names) x 3"
        )
    joints = joints.astype(np.float64)
    is_told = np.isfinite(joints).all(-1, keepdims=True) & (joints != 0.0).any(-1, keepdims=True)
    joints = np.where(is_told, joints, np.nan)
    farthest = np.abs(joints[np.isfinite(joints)]).max(initial=0.0)
    if farthest > FARTHEST_JOINT_M:
        raise InputError(
            f"joints_camera reaches {farthest:g}; it must be metres, up to {FARTHEST_JOINT_M:g}"
        )
    return joints


def _frame_index(arrays: Arrays, F: int, reference: ReferenceSequence) -> NDArray[np.int64]:
    expected = int(reference.frame_index.max(initial=-1)) + 1
    if "frame_index" not in arrays:
        if expected != F:
            raise InputError(
                f"has {F} frames, the reference {expected}; it must have as many, or a frame_index"
            )
        return np.arange(F)
    frames = arrays["frame_index"]
    if frames.shape != (F,) or frames.dtype.kind not in "iu" or (frames < 0).any():
        raise InputError(
            f"frame_index is {frames.dtype} {frames.shape}; it must be {F} frame numbers, from 0"
        )
    if len(np.unique(frames)) < F:
        raise InputError("frame_index names a frame twice; it must name each once")
    check_same_recording(frames, reference.frame_index)
    return frames.astype(np.int64)


def _times_s(
    arrays: Arrays, frames: NDArray[np.int64], wanted: NDArray[np.int64]
) -> NDArray[np.float64]:
    """[F] of the wanted frames; between those of the file in proportion to their numbers, and all 0
    where it tells none."""
    times_s = _numbers(arrays, "timestamps_s", frames.shape, 0.0)
    order = np.argsort(frames)
    times_s = times_s[order]
    if not np.isfinite(times_s).all() or (np.diff(times_s) < 0.0).any():
        raise InputError("timestamps_s must be seconds that rise with the frames")
    if not len(frames):
        return np.zeros(len(wanted))
    return np.interp(wanted, frames[order], times_s)


def _numbers(
    arrays: Arrays, key: str, shape: tuple[int, ...], otherwise: float | NDArray[Any]
) -> NDArray[np.float64]:
    """An array that may be missing."""
    if key not in arrays:
        return np.broadcast_to(otherwise, shape).astype(np.float64)
    values = arrays[key]
    if values.ndim == 2 and len(shape) == 3:  # of one person
        values = values[:, None]
    if values.shape != shape or values.dtype.kind not in "fiu":
        raise InputError(f"{key} is {values.dtype} {values.shape}; it must be numbers {shape}")
    return values.astype(np.float64)


def _confidence(arrays: Arrays, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """NaN where it is not told."""
    confidence = _numbers(arrays, "joint_confidence", shape, np.nan)
    known = confidence[~np.isnan(confidence)]
    for value in known[(known < -CONFIDENCE_SLACK) | (known > 1.0 + CONFIDENCE_SLACK)][:1]:
        raise InputError(f"joint_confidence has {value:g}; it must be 0 to 1, or NaN")
    return np.clip(confidence, 0.0, 1.0)


def _states(
    arrays: Arrays, columns: Mapping[str, tuple[int, ...]], otherwise: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """[F, P, N] the file's own, where it calls them as we do."""
    names = arrays.get("joint_state_names")
    state = arrays.get("joint_state")
    if names is None or state is None or tuple(map(str, names)) != JOINT_STATE_NAMES:
        return otherwise
    shape = (*otherwise.shape[:2], len(arrays["joint_names"]))
    if state.shape != shape or state.dtype.kind not in "iu":
        raise InputError(
            f"joint_state is {state.dtype} {state.shape}; it must be whole numbers {shape}"
        )
    own = state[:, :, [c[0] for c in columns.values()]]
    return np.where(otherwise == JointState.ABSENT, otherwise, own).astype(np.uint8)


def _rotations(
    arrays: Arrays, names: tuple[str, ...], joints: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[F, P, 11, 3, 3] of our parts: from the file, else computed from the joints."""
    rotations = rotations_from_joints(names, joints)
    if "Ts_camera_part" not in arrays or "part_names" not in arrays:
        return rotations
    Ts, own_names = arrays["Ts_camera_part"], [str(name) for name in arrays["part_names"]]
    shape = (*joints.shape[:2], len(own_names), 4, 4)
    if Ts.shape != shape or Ts.dtype.kind not in "fiu":
        raise InputError(f"Ts_camera_part is {Ts.dtype} {Ts.shape}; it must be numbers {shape}")
    Rs = Ts[..., :3, :3]
    if (np.abs(Rs) > 1.0 + ROTATION_TOLERANCE).any():
        raise InputError(
            f"Ts_camera_part has {np.abs(Rs[~np.isnan(Rs)]).max():g} in a rotation; "
            "it must be -1 to 1, or NaN where it is not known"
        )
    for b, name in enumerate(PART_NAMES):
        if name in own_names:
            rotations[:, :, b] = Rs[:, :, own_names.index(name)]
    return rotations
