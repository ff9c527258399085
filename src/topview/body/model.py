"""The body of one person: the table of parts, scaled to a stature in metres."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import (
    JOINTS,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    PARTS,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
)
from topview.body.proportions import Proportions
from topview.body.surface import Surface, straight
from topview.records import read_only

MID_SPINE_OVER_HIPS = 0.10  # share of H: height of the reported "torso" landmark; ours
HEAD_CENTRE = 0.5  # share of the head's length


@dataclass(frozen=True, slots=True, eq=False)
class BodyModel:
    """Numbers of the 11 cylinders, part by part as in `PARTS`, in metres.

    Attributes:
        stature_m: H.
        lengths_m: [11] along +y.
        radii_m: [11, 2] semi-axes along x and z.
        surface: that refinement fits.
        joints_parent: [11, 3] where a part's proximal joint lies in its parent's frame; for the
            head zeros.
        joints_part: [16, 3] where each reported joint lies in the frame of its part.
    """

    stature_m: float
    lengths_m: NDArray[np.float64]
    radii_m: NDArray[np.float64]
    surface: Surface
    joints_parent: NDArray[np.float64]
    joints_part: NDArray[np.float64]

    @classmethod
    def of(cls, stature_m: float, proportions: Proportions) -> BodyModel:
        """The body of a person of this stature."""
        one = _of_one_metre(proportions)
        lengths_m = read_only(one.lengths_m * stature_m)
        return cls(
            stature_m,
            lengths_m,
            read_only(one.radii_m * stature_m),
            Surface.of_parts(lengths_m, one.shapes_m * stature_m),
            read_only(one.joints_parent * stature_m),
            read_only(one.joints_part * stature_m),
        )

    @property
    def shapes_m(self) -> NDArray[np.float64]:
        """[11, 6] `Surface.shapes_m` of the parts."""
        return self.surface.shapes_m[: len(self.lengths_m)]

    def thicker(self, by_m: NDArray[np.float64]) -> BodyModel:
        """With a surface that lies farther out, by [11] metres of each part."""
        return replace(self, surface=self.surface.thicker(by_m))


@cache
def _of_one_metre(proportions: Proportions) -> BodyModel:
    """Each frame makes bodies of other statures, and all alike."""
    p = proportions
    arm, leg = (p.upper_arm_radius,) * 2, (p.upper_leg_radius,) * 2
    forearm, lower_leg = (p.forearm_radius,) * 2, (p.lower_leg_radius,) * 2
    limb_lengths = [p.upper_arm, p.forearm] * 2 + [p.upper_leg, p.lower_leg] * 2
    lengths = np.array([p.head, p.waist, p.torso - p.waist, *limb_lengths])
    radii = np.array(
        [p.head_radii, p.upper_torso_radii, p.lower_torso_radii]
        + [arm, forearm] * 2
        + [leg, lower_leg] * 2
    )
    joints_parent = np.zeros((len(PARTS), 3))
    for index, part in enumerate(PARTS):
        if part.parent >= 0:
            joints_parent[index, 1] = lengths[part.parent]
    for index, side in ((LEFT_UPPER_ARM, -1.0), (RIGHT_UPPER_ARM, 1.0)):
        joints_parent[index, :2] = side * p.shoulder_half_breadth, p.shoulder_drop
    for index, side in ((LEFT_UPPER_LEG, -1.0), (RIGHT_UPPER_LEG, 1.0)):
        joints_parent[index, 0] = side * p.hip_half_breadth

    joints_part = np.zeros((len(JOINTS), 3))
    along = {
        "head": HEAD_CENTRE * p.head,
        "torso": p.torso - p.waist - MID_SPINE_OVER_HIPS,
        "pelvis": p.torso - p.waist,
        "elbow": p.upper_arm,
        "hand": p.forearm,
        "knee": p.upper_leg,
        "ankle": p.lower_leg - p.ankle_height,
    }
    for index, joint in enumerate(JOINTS):
        joints_part[index, 1] = along.get(joint.name.split("_")[-1], 0.0)
    surface = Surface.of_parts(lengths, straight(radii))
    return BodyModel(1.0, lengths, radii, surface, joints_parent, joints_part)
