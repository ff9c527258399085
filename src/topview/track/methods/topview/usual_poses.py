"""What bodies usually do: a pose is held to poses of captured motion that are like it (ours).

Points alone leave a limb that is hidden, or that touches the trunk, free to be anywhere. The table
by which whole bodies are looked up (`lookup`) knows how people move; the mean of those of its poses
that are most like the last one tells what the next one may be. What is out of sight tells nothing
of which they are: of who stands behind a counter the legs are as those of people usually are whose
trunks lean like this, and whose heads are as high.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import rotations_in_parent
from topview.body.parts import PARTS, UPPER_TORSO
from topview.geometry.rotations import nearest_rotations, shortest_turns, unit
from topview.kernels.lookup import squared_distances, squares_of_nearest
from topview.room.floor import CAMERA_UP
from topview.track.methods.topview.lookup import shipped_poses
from topview.track.methods.topview.posture import (
    HEIGHT_TRAIT,
    N_UPRIGHT,
    UP_TRAITS,
    Known,
    head_height,
    head_heights,
    known_of,
    upright_traits,
)
from topview.track.methods.topview.whole_body import FrameContext
from topview.track.pose import FROM_UPPER_TORSO, TRUNK_PARTS, Pose, mirrored

Array = NDArray[np.float64]

# All ours.
AKIN: Final = 30  # poses whose mean is taken
LIKEST: Final = 5  # poses, whose mean distance says how unusual one is
UP_WEIGHT: Final = 2.0  # of which way is up in the torso's frame, against the axis of a part
HEIGHT_WEIGHT: Final = 15.0  # of the head's height in statures, against that
_WEIGHTS: Final = np.array([1.0] * UP_TRAITS.start + [UP_WEIGHT] * 3 + [HEIGHT_WEIGHT])


@dataclass(frozen=True, slots=True, eq=False)
class UsualPoses:
    """Poses of captured motion, and their mirror images.

    Attributes:
        traits: [37, P] their parts' own axes and the way up, in the frame of the upper torso, and
            how high the head's centre is above the lower foot, in statures; both weighted.
        Rs_relative: [P, 11, 3, 3] their rotations, as `Pose.relative`.
    """

    traits: NDArray[np.float32]
    Rs_relative: Array

    @classmethod
    def of(cls, Rs: Array) -> UsualPoses:
        """Of [P / 2, 11, 3, 3] rotations of parts in any upright frame, y down."""
        Rs = np.swapaxes(np.concatenate([Rs, mirrored(Rs)]), 0, 1)
        relative = rotations_in_parent(Rs, FROM_UPPER_TORSO)
        return cls(
            np.ascontiguousarray(_traits(Rs, CAMERA_UP, head_heights(Rs)).T),
            np.ascontiguousarray(np.swapaxes(relative, 0, 1)),
        )

    def towards(self, pose: Pose, share: float | Array, known: Known | None = None) -> Pose:
        """A pose whose limbs and head are turned by this share, or by [11] shares, of the way to
        the mean of those that are like it; the neck and the upper torso stay. But where something
        is `known`, the torso leans as is usual, by its share and as far as the trunk is hidden."""
        like, weights = self._akin(pose, known)
        shares = np.broadcast_to(share, len(PARTS))
        own = pose.relative()
        mean = np.einsum("k,kpij->pij", weights, self.Rs_relative[like])
        Rs = nearest_rotations(own + shares[:, None, None] * (mean - own))
        Rs[UPPER_TORSO] = own[UPPER_TORSO]
        if known is not None:
            usual_up = unit(self.traits[UP_TRAITS, like] @ weights)
            lean = float(shares[UPPER_TORSO]) * (1.0 - float(known.seen[TRUNK_PARTS].min()))
            Rs[UPPER_TORSO] = _leant(own[UPPER_TORSO], known.up_camera, usual_up, lean)
        return Pose.from_relative(pose.neck_camera, Rs)

    def unlikeness(self, poses: Pose, up_camera: Array, head_height: float | None) -> Array:
        """[M] squared distances of M poses' traits from those that are most like each, their mean.

        Args:
            poses: M of them.
            up_camera: [3] unit vector.
            head_height: of the head's centre above the floor, in statures; None if it is not known.
        """
        traits = _traits(poses.Rs, up_camera, head_height or 0.0)
        counts = np.ones(N_UPRIGHT, np.float32)
        counts[HEIGHT_TRAIT] = head_height is not None
        lowest, squares = np.empty(LIKEST, np.float32), np.empty(len(traits), np.float32)
        squares_of_nearest(self.traits, counts, traits, lowest, squares)
        return squares.astype(np.float64)

    def _akin(self, pose: Pose, known: Known | None) -> tuple[NDArray[np.intp], Array]:
        """Which poses are most like one, and how much each counts; the sum is 1."""
        traits, counts = _traits_of(pose, known)
        squares = np.empty(len(self.Rs_relative), np.float32)
        squared_distances(self.traits, np.diag(counts), counts * traits, squares)
        squares = np.maximum(squares + (counts * traits * traits).sum(), 0.0)
        like = np.argpartition(squares, AKIN)[:AKIN]
        weights = np.exp(-0.5 * squares[like] / max(float(np.median(squares[like])), 1e-6))
        return like, weights.astype(np.float64) / weights.sum()


def _traits_of(pose: Pose, known: Known | None) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """[37] as in `UsualPoses.traits`, and [37] how much each counts."""
    counts = np.zeros(N_UPRIGHT, np.float32)
    counts[: UP_TRAITS.start] = 1.0
    if known is None:
        return _traits(pose.Rs[:, None], CAMERA_UP, 0.0)[0], counts
    counts[: UP_TRAITS.stop] = np.repeat([*known.seen, known.seen[UPPER_TORSO]], 3)
    counts[HEIGHT_TRAIT] = known.head_height is not None
    return _traits(pose.Rs[:, None], known.up_camera, known.head_height or 0.0)[0], counts


def _traits(Rs: Array, up: Array, head_heights: Array | float) -> NDArray[np.float32]:
    """[P, 37] as in `UsualPoses.traits`: weighted `upright_traits`."""
    return (_WEIGHTS * upright_traits(Rs, up, head_heights)).astype(np.float32)


def _leant(R: Array, up_camera: Array, usual_up: Array, share: float) -> Array:
    """[3, 3] the rotation of a torso, leant by this share of the way to where up is [3] in its
    frame."""
    up = R.T @ up_camera
    return R @ shortest_turns(unit(up + share * (usual_up - up)), up)


@cache
def usual_poses() -> UsualPoses:
    """Those of the table that comes with the project."""
    return UsualPoses.of(shipped_poses().Rs)


def how_unusual(poses: Pose, look: FrameContext) -> Array:
    """[M] how far M poses are from what bodies usually do whose heads are as high: each part's axis
    in the frame of the upper torso, and which way is up there, squared and added up."""
    return usual_poses().unlikeness(
        poses, look.evidence.up_camera, head_height(look.evidence, look.model)
    )


def usual_where_hidden(pose: Pose, look: FrameContext) -> Pose:
    """A pose whose parts that are out of sight are as is usual with the others."""
    known = known_of(pose, look.model, look.evidence)
    return usual_poses().towards(pose, 1.0 - known.seen, known)
