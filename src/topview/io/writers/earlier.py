"""Skeletons of earlier versions of topview, as this one has them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from topview.body.ends import FEET_AT_REST, ends_of
from topview.body.parts import JOINT_NAMES, OUTPUT_JOINT_NAMES, PART_NAMES
from topview.skeletons import SkeletonSequence

# Of each end, in their order: the joint whose state and confidence it is told.
_LIKE: Final = [
    JOINT_NAMES.index(name) for name in ("left_hand", "right_hand", "left_ankle", "right_ankle")
]


def with_ends(sequence: SkeletonSequence) -> SkeletonSequence:
    """Skeletons that have the 16 joints which outputs had before wrists and feet: these follow from
    the parts, feet at rest, and their states and confidences are those of the hands and ankles. All
    other skeletons are as they are."""
    if sequence.joint_names != JOINT_NAMES or sequence.part_names != PART_NAMES:
        return sequence
    statures_m = np.append(sequence.heights_m, np.nan)
    who = np.searchsorted(sequence.people_ids, sequence.person_ids)
    feet_leg_m = statures_m[np.where(sequence.present, who, -1)][..., None, None] * FEET_AT_REST
    ends = ends_of(sequence.joints_camera, sequence.Ts_camera_part, feet_leg_m)

    def longer(array: NDArray[Any], ends: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([array, ends], axis=2)

    state, confidence = sequence.joint_state, sequence.joint_confidence
    return replace(
        sequence,
        joint_names=OUTPUT_JOINT_NAMES,
        joints_camera=longer(sequence.joints_camera, ends),
        joint_state=longer(state, state[:, :, _LIKE]),
        joint_confidence=longer(confidence, confidence[:, :, _LIKE]),
    )
