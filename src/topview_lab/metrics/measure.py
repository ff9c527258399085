"""Measure a tracked recording against its reference: match people, keep every present person."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, PART_NAMES
from topview.body.parts import END_NAMES
from topview.records import InputError
from topview.skeletons import SkeletonSequence
from topview_lab.metrics.matching import (
    NOBODY,
    PERSON_GATE_M,
    count_people,
    match_people,
    people_distances,
    people_matched,
)
from topview_lab.metrics.reference import ReferenceSequence
from topview_lab.metrics.samples import Evaluation, Samples, SequenceErrors
from topview_lab.metrics.tracking import count_tracking


def evaluate_sequence(
    predicted: SkeletonSequence,
    reference: ReferenceSequence,
    name: str = "",
    seconds: float = 0.0,
    gate_m: float = PERSON_GATE_M,
) -> Evaluation:
    """Measure one tracked recording against its reference."""
    return Evaluation((measure_sequence(predicted, reference, name, seconds, gate_m),))


def measure_sequence(
    predicted: SkeletonSequence,
    reference: ReferenceSequence,
    name: str = "",
    seconds: float = 0.0,
    gate_m: float = PERSON_GATE_M,
) -> SequenceErrors:
    """Match people frame by frame and keep every present person.

    Raises:
        InputError: the two have no frame or no joint in common.
    """
    of_predicted, of_reference = _common_frames(predicted, reference, name)
    ends = _Ordered(predicted.joint_names, END_NAMES)
    joints = _Ordered(predicted.joint_names, JOINT_NAMES)
    predicted_camera = joints(predicted.joints_camera[of_predicted], 2)
    present = reference.present[of_reference]
    reference_camera = np.where(
        present[..., None, None],
        _Ordered(reference.joint_names, JOINT_NAMES)(reference.joints_camera[of_reference], 2),
        np.nan,
    )
    predicted_present = predicted.present[of_predicted]
    who = np.searchsorted(predicted.people_ids, predicted.person_ids[of_predicted])
    who = np.where(predicted_present, who, NOBODY)
    distances_m = people_distances(reference_camera, predicted_camera)
    matches = match_people(distances_m, gate_m, who)
    f, r = np.nonzero(present)
    slot = matches[f, r]
    found = slot != NOBODY

    def of_found(values: NDArray[Any], ordered: _Ordered, missing: float) -> NDArray[Any]:
        """[N, J or B, ...] of the predicted [F, S, ...], `missing` where nobody was found."""
        where = (...,) + (None,) * (values.ndim - 2)
        if not values.shape[1]:  # nobody in the whole recording
            values = np.full((len(values), 1, *values.shape[2:]), missing)
        chosen = values[of_predicted[f], slot]
        return ordered(np.where(found[where], chosen, missing), 1, missing)

    is_false = predicted_present.copy()
    is_false[f[found], slot[found]] = False
    parts = _Ordered(predicted.part_names, PART_NAMES)
    confidence = np.where(
        np.isfinite(predicted.joints_camera).all(-1), predicted.joint_confidence, np.nan
    )
    samples = Samples(
        person=r,
        frame=reference.frame_index[of_reference[f]],
        time_s=predicted.timestamps_s[of_predicted[f]],
        found=found,
        stature_m=_statures(
            reference, r, _found_heights(predicted, people_matched(matches, who)[f, r])
        ),
        reference_camera=reference_camera[f, r],
        predicted_camera=of_found(predicted.joints_camera, joints, np.nan),
        Rs_camera_true_part=_true_rotations(reference, of_reference[f], r),
        Rs_camera_part=of_found(predicted.Ts_camera_part[..., :3, :3], parts, np.nan),
        joint_state=of_found(predicted.joint_state, joints, 0).astype(np.uint8),
        joint_confidence=of_found(confidence, joints, np.nan),
        joint_covariance_m2=of_found(predicted.joint_covariance_m2, joints, np.nan),
        hidden=_hidden(reference, of_reference[f], r, JOINT_NAMES),
        reference_ends_camera=_Ordered(reference.joint_names, END_NAMES)(
            reference.joints_camera[of_reference[f], r], 1
        ),
        predicted_ends_camera=of_found(predicted.joints_camera, ends, np.nan),
        end_state=of_found(predicted.joint_state, ends, 0).astype(np.uint8),
        end_confidence=of_found(confidence, ends, np.nan),
        hidden_ends=_hidden(reference, of_reference[f], r, END_NAMES),
        action=_labels(reference.actions, (of_reference[f], r)),
        body=_labels(None if reference.bodies is None else np.array(reference.bodies), (r,)),
    )
    return SequenceErrors(
        name=name,
        samples=samples,
        people=count_people(
            matches,
            present,
            predicted_present,
            frames_unread=len(reference.frame_index) - len(of_reference),
            who=who,
        ),
        tracking=count_tracking(distances_m, matches, present, predicted_present, gate_m, who),
        false_confidence=joints(confidence[of_predicted][is_false], 1),
        tracked_frames=len(predicted.frame_index),
        seconds=seconds,
    )


def _common_frames(
    predicted: SkeletonSequence, reference: ReferenceSequence, name: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices into both of the frames that both have; raises InputError as `measure_sequence`."""
    if not set(predicted.joint_names) & set(reference.joint_names) & set(JOINT_NAMES):
        raise InputError(
            f"{name or 'sequence'}: tracked joints {', '.join(predicted.joint_names) or 'none'}, "
            f"reference joints {', '.join(reference.joint_names) or 'none'}; "
            "they must have at least one name in common"
        )
    _, of_predicted, of_reference = np.intersect1d(
        predicted.frame_index, reference.frame_index, return_indices=True
    )
    if len(of_predicted) == 0:
        raise InputError(
            f"{name or 'sequence'}: no tracked frame has a reference; tracked "
            f"{_span(predicted.frame_index)}, reference {_span(reference.frame_index)}"
        )
    return of_predicted, of_reference


class _Ordered:
    """Brings named joints or parts into the order of ours."""

    def __init__(self, names: Sequence[str], ours: Sequence[str]) -> None:
        self.count = len(ours)
        self.to = [i for i, name in enumerate(ours) if name in names]
        self.of = [names.index(ours[i]) for i in self.to]

    def __call__(self, values: NDArray[Any], axis: int, missing: float = np.nan) -> NDArray[Any]:
        """The values along `axis` in our order, `missing` where there is none of that name."""
        values = np.moveaxis(values, axis, 0)
        ordered = np.full((self.count, *values.shape[1:]), missing)
        ordered[self.to] = values[self.of]
        return np.moveaxis(ordered, 0, axis)


def _found_heights(predicted: SkeletonSequence, p: NDArray[np.int64]) -> NDArray[np.float64]:
    """[N] predicted statures of people, NaN for nobody."""
    heights_m = np.append(predicted.heights_m, np.nan)  # NOBODY is the last
    return np.where(heights_m > 0.0, heights_m, np.nan)[p]


def _statures(
    reference: ReferenceSequence, r: NDArray[np.int64], predicted_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[N] of the reference people where known, else as predicted; NaN where neither is."""
    if reference.statures_m is None:
        return predicted_m
    known_m = reference.statures_m[r]
    return np.where(known_m > 0.0, known_m, predicted_m)


def _true_rotations(
    reference: ReferenceSequence, f: NDArray[np.int64], r: NDArray[np.int64]
) -> NDArray[np.float64]:
    if reference.Rs_camera_part is None:
        return np.full((len(f), len(PART_NAMES), 3, 3), np.nan)
    return _Ordered(reference.part_names, PART_NAMES)(reference.Rs_camera_part[f, r], 1)


def _hidden(
    reference: ReferenceSequence,
    f: NDArray[np.int64],
    r: NDArray[np.int64],
    names: Sequence[str],
) -> NDArray[np.float64]:
    """[N, J, 4] shares of these joints by `CAUSES`."""
    by_cause = (
        reference.occluded_by_person,
        reference.occluded_by_self,
        reference.occluded_by_object,
        reference.outside,
    )
    ordered = _Ordered(reference.joint_names, names)
    unknown = np.full((len(f), len(names)), np.nan)
    return np.stack(
        [unknown if shares is None else ordered(shares[f, r], 1) for shares in by_cause], axis=-1
    )


def _labels(
    labels: NDArray[np.str_] | None, where: tuple[NDArray[np.int64], ...]
) -> NDArray[np.str_]:
    return np.full(len(where[0]), "", np.str_) if labels is None else labels[where]


def _span(frame_index: NDArray[np.int64]) -> str:
    return f"{frame_index[0]} to {frame_index[-1]}" if len(frame_index) else "none"
