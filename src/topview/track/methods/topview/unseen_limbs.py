"""Where limbs that are out of sight are on average (ours).

Nothing tells where a limb is that somebody else, furniture or the edge of the image hides, so the
search leaves it where chance had it. On average such limbs are elsewhere: a law that is linear in
the axes of all parts says where each points then, learnt from rendered people of whom something was
hidden, by `topview train-unseen-limbs`. What is told has them there; the search goes on without.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import LEFT_UPPER_LEG, PARTS, UPPER_TORSO
from topview.geometry.rotations import nearest_rotations, unit
from topview.track.elbows import limb_rotations
from topview.track.methods.topview.linear_law import LinearLaw
from topview.track.methods.topview.posture import posture_traits
from topview.track.pose import LIMBS, Pose

Array = NDArray[np.float64]

UNSEEN_LIMBS_FILE: Final = "data/unseen_limbs.npz"
LIMB_PARTS: Final = [part for upper in LIMBS for part in (upper, upper + 1)]
_LEGS: Final = [n for n, part in enumerate(LIMB_PARTS) if part >= LEFT_UPPER_LEG]


@dataclass(frozen=True, slots=True, eq=False)
class UnseenLimbs(LinearLaw):
    """A linear law of `posture_traits`, whose weights are [8, 3, T], of the axis of each of
    `LIMB_PARTS` in the frame of the upper torso."""

    def axes(self, traits: Array) -> Array:
        """[8, 3] axes of limbs in the frame of the upper torso, on average, not of length 1, of a
        pose with [T] traits."""
        return self.told_by(traits)

    def told(self, pose: Pose, model: BodyModel, up_camera: Array, out: Array) -> Pose:
        """A pose whose limbs are turned to where they are on average, by [11] shares of its parts
        that are out of sight. Of who shows nothing of either leg they stay: rendered people stand
        with their knees bent, others do not."""
        shares = out[LIMB_PARTS]
        shares[_LEGS] *= 1.0 - shares[_LEGS].min()
        if not shares.any():
            return pose
        traits = posture_traits(pose, model, up_camera)
        axes = unit(self.axes(traits) @ pose.Rs[UPPER_TORSO].T).reshape(-1, 2, 3)
        likely = [
            limb_rotations(own, pose.Rs[PARTS[upper].parent], upper)
            for upper, own in zip(LIMBS, axes, strict=True)
        ]
        Rs, own = pose.Rs.copy(), pose.Rs[LIMB_PARTS]
        Rs[LIMB_PARTS] = nearest_rotations(
            own + shares[:, None, None] * (np.concatenate(likely) - own)
        )
        return Pose(pose.neck_camera, Rs)


@cache
def shipped_unseen_limbs() -> UnseenLimbs:
    """That which comes with the project."""
    return UnseenLimbs.shipped(UNSEEN_LIMBS_FILE)
