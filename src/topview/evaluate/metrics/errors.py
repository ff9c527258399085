"""What is measured of one recording: who was found, and every joint's and part's error.

Nothing is averaged here, so that recordings can be measured by several processes and pooled
afterwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, JOINTS, PART_NAMES
from topview.evaluate.metrics.matching import (
    GATE_M,
    NOBODY,
    PeopleCounts,
    count_people,
    match_people,
)
from topview.evaluate.metrics.reference import ReferenceSequence
from topview.records import InputError, SkeletonSequence, read_only


@dataclass(frozen=True, slots=True)
class Bone:
    """The two reference joints whose line a part's axis is compared with, from its origin's end."""

    part: str
    start: str
    end: str


BONES: Final[tuple[Bone, ...]] = (
    Bone("head", "head", "neck"),
    Bone("upper_torso", "neck", "torso"),
    Bone("lower_torso", "torso", "pelvis"),
    *(
        Bone(f"{side}_{part}", f"{side}_{start}", f"{side}_{end}")
        for side in ("left", "right")
        for part, start, end in (
            ("upper_arm", "shoulder", "elbow"),
            ("forearm", "elbow", "hand"),
            ("upper_leg", "hip", "knee"),
            ("lower_leg", "knee", "ankle"),
        )
    ),
)

_JOINT_PARTS: Final = [joint.part for joint in JOINTS]
_BONE_PARTS: Final = [PART_NAMES.index(bone.part) for bone in BONES]
_BONE_STARTS: Final = [JOINT_NAMES.index(bone.start) for bone in BONES]
_BONE_ENDS: Final = [JOINT_NAMES.index(bone.end) for bone in BONES]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Errors of N matched person-frames; joints as in `JOINT_NAMES`, bones as in `BONES`.

    Attributes:
        person: [N] int64, which reference person of the recording (column).
        stature_m: [N] the scale of the constant offsets: the reference's, else the predicted one.
        distances_m: [N, J] from predicted to reference joint, NaN where either is missing.
        errors_part_m: [N, J, 3] reference minus predicted joint in the frame of the predicted part
            that carries the joint, NaN where either or the part's pose is missing.
        bones_part: [N, B, 3] unit direction of the reference bone in the frame of the predicted
            part; +y where the part's axis is right.
        joint_occluded: [N, J] share that another person hides, NaN where unknown.
        bone_occluded: [N, B] mean of its two joints.
    """

    person: NDArray[np.int64]
    stature_m: NDArray[np.float64]
    distances_m: NDArray[np.float64]
    errors_part_m: NDArray[np.float64]
    bones_part: NDArray[np.float64]
    joint_occluded: NDArray[np.float64]
    bone_occluded: NDArray[np.float64]

    def __post_init__(self) -> None:
        for field in fields(self):
            read_only(getattr(self, field.name))

    @classmethod
    def pooled(cls, parts: Sequence[Samples]) -> Samples:
        """The samples of at least one recording, one after the other."""
        return cls(
            *(
                np.concatenate([getattr(part, field.name) for part in parts])
                for field in fields(cls)
            )
        )


@dataclass(frozen=True, slots=True, eq=False)
class SequenceErrors:
    """All that is kept of one evaluated recording.

    Attributes:
        name: of the recording.
        samples: errors of the people found.
        people: counts of people found, missed, false, swapped.
        tracked_frames: how many frames the tracker was given.
        seconds: spent in the tracker, 0 where not measured.
    """

    name: str
    samples: Samples
    people: PeopleCounts
    tracked_frames: int
    seconds: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """One or several measured recordings."""

    sequences: tuple[SequenceErrors, ...]

    @classmethod
    def pooled(cls, evaluations: Iterable[Evaluation]) -> Evaluation:
        return cls(tuple(s for evaluation in evaluations for s in evaluation.sequences))


def evaluate_sequence(
    predicted: SkeletonSequence,
    reference: ReferenceSequence,
    name: str = "",
    seconds: float = 0.0,
    gate_m: float = GATE_M,
) -> Evaluation:
    """Measure one tracked recording against its reference."""
    return Evaluation((measure_sequence(predicted, reference, name, seconds, gate_m),))


def measure_sequence(
    predicted: SkeletonSequence,
    reference: ReferenceSequence,
    name: str = "",
    seconds: float = 0.0,
    gate_m: float = GATE_M,
) -> SequenceErrors:
    """Match people frame by frame and keep every error.

    Raises:
        InputError: the two have no frame in common.
    """
    _, of_predicted, of_reference = np.intersect1d(
        predicted.frame_index, reference.frame_index, return_indices=True
    )
    if len(of_predicted) == 0:
        raise InputError(
            f"{name or 'sequence'}: no tracked frame has a reference; tracked "
            f"{_span(predicted.frame_index)}, reference {_span(reference.frame_index)}"
        )
    predicted_joints = _ordered(predicted.joints_camera[of_predicted], predicted.joint_names)
    reference_present = reference.present[of_reference]
    reference_joints = np.where(
        reference_present[..., None, None],
        _ordered(reference.joints_camera[of_reference], reference.joint_names),
        np.nan,
    )
    matches = match_people(reference_joints, predicted_joints, gate_m)
    people = count_people(
        matches,
        reference_present,
        predicted.present[of_predicted],
        frames_unread=len(reference.frame_index) - len(of_reference),
    )
    f, r = np.nonzero(matches != NOBODY)
    p = matches[f, r]
    parts = predicted.Ts_camera_part[of_predicted[f], p]
    Rs_camera_part = _ordered_parts(parts[..., :3, :3], predicted.part_names)
    samples = _samples(
        person=r,
        stature_m=_statures(reference, r, predicted.heights_m[p]),
        reference_camera=reference_joints[f, r],
        predicted_camera=predicted_joints[f, p],
        Rs_camera_part=Rs_camera_part,
        occluded=_occlusion(reference, of_reference[f], r),
    )
    return SequenceErrors(name, samples, people, len(predicted.frame_index), seconds)


def _samples(
    person: NDArray[np.int64],
    stature_m: NDArray[np.float64],
    reference_camera: NDArray[np.float64],
    predicted_camera: NDArray[np.float64],
    Rs_camera_part: NDArray[np.float64],
    occluded: NDArray[np.float64],
) -> Samples:
    """Errors of N person-frames from [N, J, 3] joints, [N, 11, 3, 3] and [N, J] occlusion."""
    errors_camera = reference_camera - predicted_camera
    bones_camera = reference_camera[:, _BONE_ENDS] - reference_camera[:, _BONE_STARTS]
    length = np.linalg.norm(bones_camera, axis=-1, keepdims=True)
    directions = bones_camera / np.where(length > 0.0, length, np.nan)
    return Samples(
        person=person,
        stature_m=stature_m,
        distances_m=np.linalg.norm(errors_camera, axis=-1),
        errors_part_m=_into_part(Rs_camera_part[:, _JOINT_PARTS], errors_camera),
        bones_part=_into_part(Rs_camera_part[:, _BONE_PARTS], directions),
        joint_occluded=occluded,
        bone_occluded=(occluded[:, _BONE_STARTS] + occluded[:, _BONE_ENDS]) / 2.0,
    )


def _into_part(
    Rs_camera_part: NDArray[np.float64], vectors_camera: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[..., 3] vectors told in the parts' frames."""
    return np.einsum("...ij,...i->...j", Rs_camera_part, vectors_camera)


def _statures(
    reference: ReferenceSequence, r: NDArray[np.int64], predicted_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] of the reference people where known, else as predicted; NaN where neither is."""
    statures_m = np.where(predicted_m > 0.0, predicted_m, np.nan)
    if reference.statures_m is None:
        return statures_m
    known_m = reference.statures_m[r]
    return np.where(known_m > 0.0, known_m, statures_m)


def _occlusion(
    reference: ReferenceSequence, f: NDArray[np.int64], r: NDArray[np.int64]
) -> NDArray[np.float64]:
    """[N, J] share that another person hides, NaN where the reference does not say."""
    if reference.occluded_by_person is None:
        return np.full((len(f), len(JOINT_NAMES)), np.nan)
    occluded = reference.occluded_by_person[f, r, :, None]
    return _ordered(occluded, reference.joint_names)[..., 0]


def _ordered(joints: NDArray[np.float64], names: Sequence[str]) -> NDArray[np.float64]:
    """[..., K, c] values of the named joints as [..., J, c] of `JOINT_NAMES`, NaN where absent."""
    ordered = np.full((*joints.shape[:-2], len(JOINT_NAMES), joints.shape[-1]), np.nan)
    for j, name in enumerate(JOINT_NAMES):
        if name in names:
            ordered[..., j, :] = joints[..., names.index(name), :]
    return ordered


def _ordered_parts(rotations: NDArray[np.float64], names: Sequence[str]) -> NDArray[np.float64]:
    """[..., B, 3, 3] rotations of the named parts in the order of `PART_NAMES`, NaN if absent."""
    ordered = np.full((*rotations.shape[:-3], len(PART_NAMES), 3, 3), np.nan)
    for b, name in enumerate(PART_NAMES):
        if name in names:
            ordered[..., b, :, :] = rotations[..., names.index(name), :, :]
    return ordered


def _span(frame_index: NDArray[np.int64]) -> str:
    return f"{frame_index[0]} to {frame_index[-1]}" if len(frame_index) else "none"
