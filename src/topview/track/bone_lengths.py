"""How long somebody's bones are, learnt from where the joints are proposed over time (ours).

A stature does not say it all: children, heavy people, and joints that a proposer puts elsewhere
than `topview.body.proportions` does. Left and right count together. The robust mean of each length
weighs a frame by how sure its joints are along the bone; before any frame it is that of the
stature, or what is known of the person.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.known_body import BONE_NAMES, KnownBone, is_length
from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import (
    HEAD,
    JOINT_NAMES,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
)
from topview.body.proportions import ANATOMICAL
from topview.body.shapes import dressed_surface
from topview.detect.joints import JointProposals
from topview.geometry.rotations import cross, lengths, unit
from topview.kernels.proposed import variances_along
from topview.records import read_only
from topview.track.degrees_of_freedom import PARENT_OF
from topview.track.joint_fit import JOINT_PART, body_joints

Array = NDArray[np.float64]

# Lengths in shares of the stature: medians over rendered people. The two last are where the middle
# of the shoulders lies below and before the neck joint, in the frame of the upper torso.
PROPOSED_LENGTHS: Final[dict[str, float]] = {
    "head": 0.088,  # from its centre to the neck joint
    "upper_torso": 0.232,  # from the neck joint to the mid spine
    "lower_torso": 0.097,  # from there to the middle of the hips
    "upper_arm": 0.155,
    "forearm": 0.169,
    "upper_leg": 0.230,
    "lower_leg": 0.254,  # to the ankle
    "shoulder_breadth": 0.204,
    "hip_breadth": 0.134,
    "shoulder_drop": 0.058,
    "shoulder_front": 0.008,
}
# How far people and statures depart from these, in shares of the stature; ours. Joints whose scales
# are 1.5 cm weigh as much after some 3 frames.
PRIOR_SIGMA: Final = 0.01
# What is known of bones is no surer, metres; ours: other motions and rooms make the learnt lengths
# of one simulated person differ by about as much.
LEAST_SIGMA_M: Final = 0.005

_SHARES = np.array([PROPOSED_LENGTHS[name] for name in BONE_NAMES])


def _joint(name: str) -> int:
    return JOINT_NAMES.index(name)


# What is measured between two joints: the length, and the joints.
_BONES = [
    ("head", "head", "neck"),
    ("upper_torso", "neck", "torso"),
    ("lower_torso", "torso", "pelvis"),
    ("shoulder_breadth", "left_shoulder", "right_shoulder"),
    ("hip_breadth", "left_hip", "right_hip"),
    *(
        (length, f"{side}_{first}", f"{side}_{second}")
        for length, first, second in (
            ("upper_arm", "shoulder", "elbow"),
            ("forearm", "elbow", "hand"),
            ("upper_leg", "hip", "knee"),
            ("lower_leg", "knee", "ankle"),
        )
        for side in ("left", "right")
    ),
]
_FIRST = np.array([_joint(first) for _, first, _ in _BONES])
_SECOND = np.array([_joint(second) for _, _, second in _BONES])
_NECK, _TORSO = _joint("neck"), _joint("torso")
_SHOULDERS = [_joint("left_shoulder"), _joint("right_shoulder")]
# Of all that is measured: the length, and the joints whose errors count.
_LENGTH = np.array(
    [
        BONE_NAMES.index(name)
        for name in (*(b for b, _, _ in _BONES), "shoulder_drop", "shoulder_front")
    ]
)
_ENDS = np.concatenate([_FIRST, _SECOND, np.repeat([_NECK, *_SHOULDERS], 2)])
# What bones tell of a body: the parts that hang from another, and the joints at the ends of parts.
_HANGING = np.flatnonzero(PARENT_OF >= 0)
_PART_ENDS = np.flatnonzero(
    [name.endswith(("elbow", "hand", "knee", "pelvis")) for name in JOINT_NAMES]
)
_ANKLES = [_joint("left_ankle"), _joint("right_ankle")]


class BoneLengths:
    """Running estimate of one person's bones."""

    def __init__(self, known: Mapping[str, KnownBone] | None = None) -> None:
        """
        Args:
            known: of this person beforehand, by `BONE_NAMES`; None or empty if nothing is.
        """
        self._known = tuple(known[name] for name in BONE_NAMES) if known else None
        self._weight = np.zeros(len(BONE_NAMES))
        self._weighted_m = np.zeros(len(BONE_NAMES))

    def update(self, proposals: JointProposals, mode: int, stature_m: float) -> None:
        """Learn from one mode of the first person's proposals."""
        places, scales_m = body_joints(proposals)
        expected_m = self.lengths_m(stature_m)
        with np.errstate(invalid="ignore"):  # infinite scales give what is not finite
            length, measured_m, errors_m2 = _measured(places[mode], scales_m[mode], expected_m)
        spread_m2 = errors_m2 + (PRIOR_SIGMA * stature_m) ** 2
        surprise = (measured_m - expected_m[length]) ** 2 / spread_m2
        weight = 1.0 / (errors_m2 * np.sqrt(1.0 + surprise))
        np.add.at(self._weight, length, weight)
        np.add.at(self._weighted_m, length, weight * measured_m)

    def lengths_m(self, stature_m: float) -> Array:
        """[11] in the order of `BONE_NAMES`, metres."""
        prior_m, prior = self._prior(stature_m)
        return (prior * prior_m + self._weighted_m) / (prior + self._weight)

    def known(self, stature_m: float) -> dict[str, KnownBone]:
        """What has been learnt, for another recording, by `BONE_NAMES`; empty where joints have
        been proposed as nobody has them."""
        _, prior = self._prior(stature_m)
        sigmas_m = 1.0 / np.sqrt(prior + self._weight)
        lengths_m = dict(zip(BONE_NAMES, self.lengths_m(stature_m).tolist(), strict=True))
        if not all(is_length(name, length_m) for name, length_m in lengths_m.items()):
            return {}
        return {
            name: KnownBone(length_m, sigma_m)
            for (name, length_m), sigma_m in zip(lengths_m.items(), sigmas_m.tolist(), strict=True)
        }

    def _prior(self, stature_m: float) -> tuple[Array, Array]:
        """[11] lengths before any frame, metres, and [11] one over their variances."""
        if self._known is None:
            weight = 1.0 / (PRIOR_SIGMA * stature_m) ** 2
            return _SHARES * stature_m, np.full(len(BONE_NAMES), weight)
        lengths_m = np.array([bone.length_m for bone in self._known])
        sigmas_m = np.array([max(bone.sigma_m, LEAST_SIGMA_M) for bone in self._known])
        return lengths_m, sigmas_m**-2

    def model(self, stature_m: float) -> BodyModel:
        """The body of these bones; what they do not say, such as the radii, is that of the
        stature."""
        return model_of_bones(
            dict(zip(BONE_NAMES, self.lengths_m(stature_m), strict=True)), stature_m
        )


def dressed_body(stature_m: float) -> BodyModel:
    """The body of somebody of whom only the stature is known."""
    return BoneLengths().model(stature_m)


def model_of_bones(lengths_m: dict[str, float], stature_m: float) -> BodyModel:
    """A body whose bones have these lengths; it bends at the mid spine.

    Args:
        lengths_m: those of `PROPOSED_LENGTHS`, metres.
        stature_m: says the rest.
    """
    m = lengths_m
    body = BodyModel.of(stature_m, ANATOMICAL)
    above_centre_m = HEAD_CENTRE * body.lengths_m[HEAD]
    ankle_height_m = ANATOMICAL.ankle_height * stature_m
    lengths = np.array(
        [above_centre_m + m["head"], m["upper_torso"], m["lower_torso"]]
        + [m["upper_arm"], m["forearm"]] * 2
        + [m["upper_leg"], m["lower_leg"] + ankle_height_m] * 2
    )

    joints_parent = body.joints_parent.copy()
    joints_parent[_HANGING, 1] = lengths[PARENT_OF[_HANGING]]
    for index, side in ((LEFT_UPPER_ARM, -0.5), (RIGHT_UPPER_ARM, 0.5)):
        across = side * m["shoulder_breadth"]
        joints_parent[index] = across, m["shoulder_drop"], m["shoulder_front"]
    for index, side in ((LEFT_UPPER_LEG, -0.5), (RIGHT_UPPER_LEG, 0.5)):
        joints_parent[index, 0] = side * m["hip_breadth"]

    joints_part = body.joints_part.copy()
    joints_part[_PART_ENDS, 1] = lengths[JOINT_PART[_PART_ENDS]]
    joints_part[_ANKLES, 1] = m["lower_leg"]
    joints_part[_TORSO, 1] = 0.0
    return BodyModel(
        stature_m,
        read_only(lengths),
        body.radii_m,
        dressed_surface(stature_m, lengths, joints_parent),
        read_only(joints_parent),
        read_only(joints_part),
    )


def _measured(
    places: Array, scales_m: Array, expected_m: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """[N] index of each length that is measured, [N] metres, and [N] their mean squared errors.

    Errors across a bone change its length by half their square over the length. Whether it is too
    long or too short then depends on whether joints are measured with noise or are a mean of where
    they may be; so that is a reason to doubt a length, and not to correct it.

    Args:
        places, scales_m: [16, 3] of one mode, metres.
        expected_m: [11] all lengths.
    """
    ways = places[_SECOND] - places[_FIRST]
    down = places[_TORSO] - places[_NECK]
    right = places[_SHOULDERS[1]] - places[_SHOULDERS[0]]
    axes = unit(np.array([down, cross(right, down)]))
    middle = 0.5 * places[_SHOULDERS].sum(0) - places[_NECK]

    bones = unit(ways)
    directions = np.concatenate([bones, bones, axes, axes, axes])
    along_m2, all_m2 = np.empty(len(_ENDS)), np.empty(len(_ENDS))
    variances_along(places, scales_m, _ENDS, directions, along_m2, all_m2)
    N = len(bones)
    along_bones_m2 = along_m2[:N] + along_m2[N : 2 * N]
    of_neck, of_left, of_right = along_m2[2 * N :].reshape(3, 2)
    across_m2 = all_m2[:N] + all_m2[N : 2 * N] - along_bones_m2
    bent_m = across_m2 / (2.0 * expected_m[_LENGTH[:N]])
    errors_m2 = np.concatenate([along_bones_m2 + bent_m**2, of_neck + 0.25 * (of_left + of_right)])
    lengths_m = lengths(ways)
    measured_m = np.concatenate([lengths_m, axes @ middle])
    # Joints at one place have no direction, and tell nothing.
    is_known = np.isfinite(errors_m2) & (errors_m2 > 0.0)
    is_known[:N] &= lengths_m > 0.0
    return _LENGTH[is_known], measured_m[is_known], errors_m2[is_known]
