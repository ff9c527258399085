"""Poses as vectors for an optimiser: position, orientation and joint angles.

As in Oikonomidis, Kyriazis and Argyros (BMVC 2011) and Michel, Panagiotakis and Argyros (MVA 2015):
the global position, the global orientation, and the angle of every joint. Here they are the neck
joint in metres (3), the turn of the upper torso from a reference as a rotation vector (3), and 21
angles of Table 3.2; the head's turn about its own axis, which hardly shows, is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import rotations_in_camera, rotations_in_parent
from topview.body.limits import LIMITS_RAD, angles_rad
from topview.body.parts import HEAD, PARTS, UPPER_TORSO
from topview.geometry.rotations import (
    rotations_from_angles,
    rotations_from_vectors,
    vectors_from_rotations,
)
from topview.track.pose import FROM_UPPER_TORSO, Pose

Array = NDArray[np.float64]

PLACE, TURN = slice(0, 3), slice(3, 6)

# Which angle of which part, relative to its parent in the table of parts, each dimension from
# `N_GLOBAL` on is. The neck's belong to the upper torso, as in Table 3.2.
N_GLOBAL = 6
_ANGLES = tuple(
    (index, axis)
    for index, part in enumerate(PARTS)
    if index != HEAD
    for axis in ((0,) if part.is_hinge else (0, 2) if index == UPPER_TORSO else (0, 1, 2))
)
_PART, _AXIS = np.array(_ANGLES).T
N_DIMENSIONS = N_GLOBAL + len(_ANGLES)
LOW = np.append(np.full(N_GLOBAL, -np.inf), LIMITS_RAD[_PART, _AXIS, 0])
HIGH = np.append(np.full(N_GLOBAL, np.inf), LIMITS_RAD[_PART, _AXIS, 1])


@dataclass(frozen=True, slots=True, eq=False)
class PoseSpace:
    """The space around a reference direction, [3, 3] `R_camera_torso`."""

    R_camera_torso: Array

    def vector(self, pose: Pose) -> Array:
        """[27] of a pose; angles beyond Table 3.2 are brought within."""
        Rs_parent_part = rotations_in_parent(pose.Rs)
        angles = np.array([angles_rad(part, R) for part, R in enumerate(Rs_parent_part)])
        turn = vectors_from_rotations(self.R_camera_torso.T @ pose.Rs[UPPER_TORSO])
        vector = np.concatenate([pose.neck_camera, turn, angles[_PART, _AXIS]])
        return np.clip(vector, LOW, HIGH)

    def poses(self, vectors: Array) -> Pose:
        """[M, 27] to M poses at once; inverse of `vector` within the limits."""
        angles = np.zeros((len(PARTS), len(vectors), 3))
        angles[_PART, :, _AXIS] = vectors[:, N_GLOBAL:].T
        Rs = rotations_from_angles(angles)
        Rs[HEAD] = np.swapaxes(Rs[UPPER_TORSO], 1, 2)
        Rs[UPPER_TORSO] = self.R_camera_torso @ rotations_from_vectors(vectors[:, TURN])
        return Pose(vectors[:, PLACE], rotations_in_camera(Rs, FROM_UPPER_TORSO))

    def pose(self, vector: Array) -> Pose:
        """[27] to one pose."""
        many = self.poses(vector[None])
        return Pose(many.neck_camera[0], many.Rs[:, 0])
