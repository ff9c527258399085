"""Compute the frames of our body parts, and statures, for skeletons that have joints alone.

The axis of a part is the line between its joints. The turn about it follows from the line of the
shoulders or hips and, for bent limbs, from the hinge of elbow or knee, which lies
across both bones (as in the recommendations of the International Society of Biomechanics, G. Wu et
al., J. Biomech. 38, 2005). A limb that is nearly straight turns as the trunk does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body import PART_NAMES
from topview.body.proportions import ANATOMICAL
from topview.geometry.rotations import unit

_BONE_SHARES: Final = (
    ("shoulder", "elbow", ANATOMICAL.upper_arm),
    ("hip", "knee", ANATOMICAL.upper_leg),
    ("knee", "ankle", ANATOMICAL.lower_leg - ANATOMICAL.ankle_height),
)
STRAIGHT_SINE: Final = np.sin(np.radians(20.0))
"""Sine of the bend below which a limb's turn is unobservable (ours)."""

Array = NDArray[np.float64]


def rotations_from_joints(names: Sequence[str], joints: Array) -> Array:
    """[..., 11, 3, 3] orientations of the parts in `PART_NAMES`, axes as in
    `topview.records.Person`; NaN where joints are missing.

    Args:
        names: K of our joint names.
        joints: [..., K, 3] in any frame, NaN where unknown.
    """
    at = {name: joints[..., k, :] for k, name in enumerate(names)}
    missing = np.full((*joints.shape[:-2], 3), np.nan)

    def to(start: str, end: str) -> Array:
        return at.get(end, missing) - at.get(start, missing)

    shoulders, hips = to("left_shoulder", "right_shoulder"), to("left_hip", "right_hip")
    shoulders, hips = _filled(shoulders, hips), _filled(hips, shoulders)
    parts = {
        "head": _frame(to("head", "neck"), shoulders),
        "upper_torso": _frame(_filled(to("neck", "torso"), to("neck", "pelvis")), shoulders),
        "lower_torso": _frame(_filled(to("torso", "pelvis"), to("neck", "pelvis")), hips),
    }
    for side in ("left", "right"):
        for upper, lower, chain, across, bends in (
            ("upper_arm", "forearm", ("shoulder", "elbow", "hand"), shoulders, 1.0),
            ("upper_leg", "lower_leg", ("hip", "knee", "ankle"), hips, -1.0),
        ):
            first, middle, last = (f"{side}_{joint}" for joint in chain)
            bones = to(first, middle), to(middle, last)
            # Elbows bend to the front, knees to the back: the hinge's right is the part's +x.
            hinge = bends * np.cross(unit(bones[0]), unit(bones[1]))
            is_bent = np.linalg.norm(hinge, axis=-1, keepdims=True) > STRAIGHT_SINE
            right = np.where(is_bent, hinge, across)
            parts[f"{side}_{upper}"] = _frame(bones[0], right)
            parts[f"{side}_{lower}"] = _frame(bones[1], right)
    return np.stack([parts[name] for name in PART_NAMES], -3)


def statures_from_joints(names: Sequence[str], joints: Array) -> Array:
    """[P] statures in metres from the lengths of upper arms and legs (their medians over frames,
    over their shares of the stature); NaN where none of these bones is known.

    Args:
        names: K of our joint names.
        joints: [F, P, K, 3] metres, NaN where unknown.
    """
    at = {name: joints[:, :, k] for k, name in enumerate(names)}
    statures = [np.full((len(joints), joints.shape[1]), np.nan)]
    for side in ("left", "right"):
        for start, end, share in _BONE_SHARES:
            first, last = (f"{side}_{joint}" for joint in (start, end))
            if first in at and last in at:
                statures.append(np.linalg.norm(at[last] - at[first], axis=-1) / share)
    stacked = np.ma.masked_invalid(np.concatenate(statures))
    return np.ma.median(stacked, axis=0).filled(np.nan)


def _filled(vectors: Array, others: Array) -> Array:
    return np.where(np.isfinite(vectors), vectors, others)


def _frame(axis: Array, right: Array) -> Array:
    """[..., 3, 3] with +y along an axis and +x as near to `right` as can be."""
    y = unit(axis)
    x = unit(right - (right * y).sum(-1, keepdims=True) * y)
    return np.stack([x, y, np.cross(x, y)], -1)
