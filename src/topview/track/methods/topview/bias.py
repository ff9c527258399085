"""How far off a found pose is on average, by what lies how on its surface (ours).

No surface of few numbers is a person's in clothes. The pose with which it explains most of what is
seen is off therefore, and alike each time where poses are alike and points lie alike on them: the
hips of who sits, for one, are found too near the camera. How far off is a linear law of some
traits, learnt from rendered people by `topview train-bias`.

What is told is the pose without it; where nothing is hidden, the search goes on with that. So what
is found then is off otherwise than it was without a law: it is learnt twice, the second time of
what is found with the first law.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_LOWER_LEG,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.files import read_archive
from topview.filter.over_time import FRAME_S, share_after
from topview.geometry.rotations import nearest_rotations, rotations_from_vectors
from topview.track.evidence import Evidence
from topview.track.methods.topview.posture import (
    POSTURE_BLOCKS,
    mirrored_traits,
    posture_traits,
)
from topview.track.methods.topview.refinement import Explained
from topview.track.methods.topview.whole_body import (
    Found,
    FrameContext,
    parts_out_of_sight,
)
from topview.track.pose import LIMBS, OTHER_SIDE, Pose

Array = NDArray[np.float64]

BIAS_FILE: Final = "data/bias.npz"
# All ours.
BIAS_S: Final = 0.09  # after which a bias is by 63 % what a frame says
FEW_POINTS: Final = 3.0  # that lie on a part where none do, as they should
AREA_M2: Final = 0.01  # seen surface of a part, in which its logarithm is told

_LEGS: Final = [LEFT_UPPER_LEG, LEFT_LOWER_LEG, RIGHT_UPPER_LEG, RIGHT_LOWER_LEG]
# The steps after those of the neck: which part each turns, about which of its axes. A limb swings
# and turns about its axis with the upper part, and bends with the lower one.
TURNED: Final = np.array(
    [(part, axis) for part in (UPPER_TORSO, HEAD, LOWER_TORSO, *LIMBS) for axis in range(3)]
    + [(upper + 1, 0) for upper in LIMBS]
)
N_STEPS: Final = 3 + len(TURNED)
_STEPPING: Final = np.append([UPPER_TORSO] * 3, TURNED[:, 0])  # the part of each step


@dataclass(frozen=True, slots=True, eq=False)
class PoseBias:
    """A linear law.

    Attributes:
        source: what it was learnt from, and how.
        weights: [28, T] of each trait, for each step: the neck moves along the axes of the upper
            torso, metres; parts turn as `TURNED` says, radians.
        lowest, highest: [T] traits are taken as no farther out than those it was learnt from.
    """

    source: str
    weights: Array
    lowest: Array
    highest: Array

    def steps(self, traits: Array) -> Array:
        """[28] from a pose with [T] traits to where the person is, on average; or [28, N] of
        [T, N]."""
        return self.weights @ np.clip(traits.T, self.lowest, self.highest).T


class Unbiased:
    """One person's poses without their bias, which changes smoothly."""

    def __init__(self) -> None:
        self._steps: Array | None = None

    def update(self, found: Found, look: FrameContext, explained: Explained) -> Pose:
        """The pose that was found in the evidence of a frame, of which it explains so much, without
        its bias; that of parts that are out of sight, which nothing tells, would add up."""
        traits = pose_traits(found.pose, found.model, look.evidence, explained)
        out = parts_out_of_sight(found.pose, found.model, look.evidence)
        steps = (1.0 - out[_STEPPING]) * self.steps(found, traits)
        if self._steps is not None and not found.is_new:
            share = share_after(max(look.elapsed_s, FRAME_S), BIAS_S)
            steps = self._steps + share * (steps - self._steps)
        self._steps = steps
        return _with_legs_of(stepped(found.pose, steps), found.pose, out)

    def steps(self, found: Found, traits: Array) -> Array:
        """[28] that a frame says."""
        return shipped_bias().steps(traits)

    def forget(self) -> None:
        """Nothing is known of the next pose's."""
        self._steps = None


@cache
def shipped_bias() -> PoseBias:
    """That which comes with the project."""
    with resources.as_file(resources.files("topview.track.methods.topview") / BIAS_FILE) as path:
        arrays = read_archive(path)
    return PoseBias(str(arrays.pop("source")), **arrays)


def pose_traits(pose: Pose, model: BodyModel, evidence: Evidence, explained: Explained) -> Array:
    """[T] what tells how far off a pose is: `posture_traits`; and of each part, in its frame, how
    far the points on it are off its surface and where they lie, how much is seen of it, and which
    share of that it leaves unexplained."""
    surfaces, shares = explained
    is_on = surfaces.labels == np.arange(len(PARTS))[:, None]
    weights = is_on * shares
    sums = weights.sum(1)
    normals = np.where(shares[:, None] > 0.0, surfaces.normals_camera, 0.0)
    off = _in_parts(surfaces.distances_m[:, None] * normals, weights, pose)
    lie = _in_parts(evidence.points_camera, weights, pose)
    at = np.einsum("kji,kj->ki", pose.Rs, pose.origins(model)) * sums[:, None]
    counts = is_on.sum(1)
    return np.concatenate(
        [
            posture_traits(pose, model, evidence.up_camera),
            (off / (sums + FEW_POINTS)[:, None]).ravel(),
            ((lie - at) / (sums + FEW_POINTS)[:, None]).ravel(),
            np.log1p(counts * evidence.point_area_m2 / AREA_M2),
            1.0 - sums / np.maximum(counts, 1),
        ]
    )


MIRRORED_TRAITS: Final = mirrored_traits(
    [*POSTURE_BLOCKS, (OTHER_SIDE, 3), (OTHER_SIDE, 3), (OTHER_SIDE, 1), (OTHER_SIDE, 1)]
)


def _in_parts(vectors: Array, weights: Array, pose: Pose) -> Array:
    """[11, 3] weighted sums of [N, 3] vectors, in the frames of the parts whose [11, N] weights
    they have."""
    return np.einsum("kji,kj->ki", pose.Rs, weights @ vectors)


def _with_legs_of(pose: Pose, before: Pose, shares: Array) -> Pose:
    """A pose whose legs point where they did before, by [11] shares of its parts: what is out of
    sight stands on the floor, however the trunk turned."""
    if not shares[_LEGS].any():
        return pose
    Rs = pose.Rs.copy()
    Rs[_LEGS] = nearest_rotations(Rs[_LEGS] + shares[_LEGS, None, None] * (before.Rs - Rs)[_LEGS])
    return Pose(pose.neck_camera, Rs)


def stepped(pose: Pose, steps: Array) -> Pose:
    """A pose moved by [28] steps, as `PoseBias` has them; the same one if there are none."""
    if not steps.any():
        return pose
    vectors = np.zeros((len(PARTS), 3))
    vectors[TURNED[:, 0], TURNED[:, 1]] = steps[3:]
    neck_camera = pose.neck_camera + pose.Rs[UPPER_TORSO] @ steps[:3]
    return Pose.from_relative(neck_camera, pose.relative() @ rotations_from_vectors(vectors))
