"""Skeletons of earlier versions of topview, as this one has them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.ends import FEET_AT_REST, ends_of
from topview.body.parts import JOINT_NAMES, OUTPUT_JOINT_NAMES, PART_NAMES
from topview.skeletons import SkeletonSequence

# Of each end, in their order: the joint whose state, confidence and covariance it is told.
_LIKE: Final = [
    JOINT_NAMES.index(name) for name in ("left_hand", "right_hand", "left_ankle", "right_ankle")
]


def with_ends(sequence: SkeletonSequence) -> SkeletonSequence:
    """Skeletons that have the 16 joints which outputs had before wrists and feet: these follow from
    the parts, feet at rest, and their states, confidences and covariances are those of the hands
    and ankles. All other skeletons are as they are."""
    if sequence.joint_names != JOINT_NAMES or sequence.part_names != PART_NAMES:
        return sequence
    statures_m = np.append(sequence.heights_m, np.nan)
    who = np.searchsorted(sequence.people_ids, sequence.person_ids)
    feet_leg_m = statures_m[np.where(sequence.present, who, -1)][..., None, None] * FEET_AT_REST
    ends = ends_of(sequence.joints_camera, sequence.Ts_camera_part, feet_leg_m)

    def longer(array: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([array, array[:, :, _LIKE]], axis=2)

    return replace(
        sequence,
        joint_names=OUTPUT_JOINT_NAMES,
        joints_camera=np.concatenate([sequence.joints_camera, ends], axis=2),
        joint_state=longer(sequence.joint_state),
        joint_confidence=longer(sequence.joint_confidence),
        joint_covariance_m2=longer(sequence.joint_covariance_m2),
    )
