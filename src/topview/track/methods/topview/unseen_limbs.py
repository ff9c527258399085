"""Where limbs that are out of sight are on average (ours).

Nothing tells where a limb is that somebody else, furniture or the edge of the image hides, so the
search leaves it where chance had it. On average such limbs are elsewhere: where those of captured
people are whose other parts point alike, who lean alike, and whose heads are as high. That is told,
by `topview train-unseen-limbs` from captured motion; the search goes on without.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from topview.body.parts import LEFT_UPPER_LEG, PARTS, UPPER_TORSO
from topview.files import read_archive
from topview.geometry.rotations import nearest_rotations, unit
from topview.track.elbows import limb_rotations
from topview.track.methods.topview.posture import (
    HEIGHT_TRAIT,
    N_UPRIGHT,
    UP_TRAITS,
    Known,
    upright_traits,
)
from topview.track.pose import LIMBS, Pose

Array = NDArray[np.float64]

UNSEEN_LIMBS_FILE: Final = "data/unseen_limbs.npz"
LIMB_PARTS: Final = [part for upper in LIMBS for part in (upper, upper + 1)]
# How far traits are measured off, ours: an axis of a part, in sight and out of it, and the way up,
# as chords; the head's height in statures, and where that is not known.
SEEN_SIGMA: Final = 0.3
UNSEEN_SIGMA: Final = 1.0
UP_SIGMA: Final = 0.05
HEIGHT_SIGMA: Final = 0.02
ANY_HEIGHT_SIGMA: Final = 10.0
_LEGS: Final = [n for n, part in enumerate(LIMB_PARTS) if part >= LEFT_UPPER_LEG]


@dataclass(frozen=True, slots=True, eq=False)
class UnseenLimbs:
    """How `upright_traits` of captured people are spread: a normal distribution.

    Attributes:
        source: what it was learnt from, and how.
        mean: [37] of traits.
        covariance: [37, 37] of them.
    """

    source: str
    mean: Array
    covariance: Array

    def expected(self, traits: Array, sigmas: Array) -> Array:
        """[37] traits of a person, on average, of whom [37] were measured, off by [37] sigmas."""
        measured = self.covariance + np.diag(sigmas * sigmas)
        return self.mean + self.covariance @ solve(measured, traits - self.mean, assume_a="pos")

    def axes(self, pose: Pose, known: Known) -> Array:
        """[8, 3] axes of `LIMB_PARTS` in the frame of the upper torso, on average."""
        height = self.mean[HEIGHT_TRAIT] if known.head_height is None else known.head_height
        traits = upright_traits(pose.Rs[:, None], known.up_camera, height)[0]
        expected = self.expected(traits, _sigmas(known))
        return unit(expected[: UP_TRAITS.start].reshape(-1, 3)[LIMB_PARTS])

    def told(self, pose: Pose, known: Known) -> Pose:
        """A pose whose limbs are turned to where they are on average, by the shares of them that
        are out of sight. Of who shows nothing of either leg they stay: captured people stand with
        their knees bent, others do not."""
        shares = 1.0 - known.seen[LIMB_PARTS]
        shares[_LEGS] *= 1.0 - shares[_LEGS].min()
        if not shares.any():
            return pose
        axes = (self.axes(pose, known) @ pose.Rs[UPPER_TORSO].T).reshape(-1, 2, 3)
        likely = [
            limb_rotations(own, pose.Rs[PARTS[upper].parent], upper)
            for upper, own in zip(LIMBS, axes, strict=True)
        ]
        Rs, own = pose.Rs.copy(), pose.Rs[LIMB_PARTS]
        Rs[LIMB_PARTS] = nearest_rotations(
            own + shares[:, None, None] * (np.concatenate(likely) - own)
        )
        return Pose(pose.neck_camera, Rs)


def _sigmas(known: Known) -> Array:
    """[37] how far traits are measured off."""
    sigmas = np.empty(N_UPRIGHT)
    variances = SEEN_SIGMA**2 + (1.0 - known.seen) * (UNSEEN_SIGMA**2 - SEEN_SIGMA**2)
    sigmas[: UP_TRAITS.start] = np.sqrt(np.repeat(variances, 3))
    sigmas[UP_TRAITS] = UP_SIGMA
    sigmas[HEIGHT_TRAIT] = ANY_HEIGHT_SIGMA if known.head_height is None else HEIGHT_SIGMA
    return sigmas


@cache
def shipped_unseen_limbs() -> UnseenLimbs:
    """That which comes with the project."""
    files = resources.files("topview.track.methods.topview") / UNSEEN_LIMBS_FILE
    with resources.as_file(files) as path:
        arrays = read_archive(path)
    return UnseenLimbs(str(arrays.pop("source")), **arrays)
