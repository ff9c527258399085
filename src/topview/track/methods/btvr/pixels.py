"""Which of a user's pixels torso, head and legs do not explain: those of the arms."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.kernels.arms import BODYS, OPEN, OTHERS
from topview.track.evidence import Evidence
from topview.track.methods.btvr.torso import Torso

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# All ours; distances from a part's surface.
BODY_CLOTHING_M: Final = 0.01  # what is this near to torso, head or legs is theirs
CLEARLY_OFF_M: Final = 0.07  # what is farther from all of them is an arm's
ARM_CLOTHING_M: Final = 0.03  # what is this near to an arm is that arm's: sleeves are wide


class UserPixels:
    """One user's pixels in one frame, thinned as the evidence is.

    Attributes:
        points: [N, 3] metres.
        weights: [N] how much each needs an arm to explain it: 0 on torso and head, 1 well away.
    """

    def __init__(self, torso: Torso, model: BodyModel, evidence: Evidence) -> None:
        view = evidence.view
        self._where = np.nonzero(evidence.user_mask | _in_front(torso, model, evidence))
        self.points = view.points(*self._where)
        off_m = _distance_from_body(self.points, torso, model, evidence)
        self.weights = np.clip(
            (off_m - BODY_CLOTHING_M) / (CLEARLY_OFF_M - BODY_CLOTHING_M), 0.0, 1.0
        )
        self._shape = view.depth_m.shape
        self._arms: dict[int, Mask] = {}

    def assign(self, upper: int, joints_camera: Array, radii_m: Array) -> None:
        """Give the points near an arm to it, so that they are not open to the other one.

        Args:
            upper: index of the upper arm.
            joints_camera: [3, 3] shoulder, elbow and palm, metres.
            radii_m: [2] of upper arm and forearm.
        """
        is_arms = np.zeros(len(self.points), np.bool_)
        for k in range(2):
            distance_m = _to_segment(self.points, joints_camera[k], joints_camera[k + 1])
            is_arms |= distance_m < radii_m[k] + ARM_CLOTHING_M
        self._arms[upper] = is_arms

    def open_to(self, upper: int, shoulder_camera: Array, reach_m: float) -> Mask:
        """[N] True for the points within an arm's reach that nothing else explains."""
        is_near = ((self.points - shoulder_camera) ** 2).sum(1) < reach_m**2
        is_open = is_near & (self.weights > 0.0)
        for other, is_arms in self._arms.items():
            if other != upper:
                is_open &= ~is_arms
        return is_open

    def images(self, is_open: Mask) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """[H, W] owner and weight of each pixel, for `compare_arms`, given which of the [N] points
        are open."""
        owners = np.full(self._shape, OTHERS, np.uint8)
        owners[self._where] = np.where(is_open, OPEN, BODYS)
        weights = np.zeros(self._shape, np.float32)
        weights[self._where] = np.where(is_open, self.weights, 0.0)
        return owners, weights


def _in_front(torso: Torso, model: BodyModel, evidence: Evidence) -> Mask:
    """[H, W] unowned pixels before the torso, within the arms' reach: most likely a fist whose arm
    has no reading."""
    view = evidence.view
    if evidence.unowned_mask is None:
        return np.zeros(view.depth_m.shape, np.bool_)
    arm = [LEFT_UPPER_ARM, LEFT_UPPER_ARM + 1]
    reach_m = float(model.lengths_m[arm].sum() + model.joints_parent[RIGHT_UPPER_ARM, 0])
    drop_m = model.joints_parent[LEFT_UPPER_ARM, 1]
    between_shoulders = torso.neck_camera + drop_m * torso.R_camera_torso[:, 1]
    z = between_shoulders[2]
    farthest_m = z - model.radii_m[UPPER_TORSO, 1] - CLEARLY_OFF_M
    depth = view.depth_m
    is_before = evidence.unowned_mask & (depth > max(z - reach_m, 0.1)) & (depth < farthest_m)
    pixels = np.nonzero(is_before)
    off = view.points(*pixels) - between_shoulders
    is_before[pixels] = (off**2).sum(1) < reach_m**2
    return is_before


def _distance_from_body(points: Array, torso: Torso, model: BodyModel, evidence: Evidence) -> Array:
    """[N] metres from torso, head and neck, and from where the legs are while somebody stands;
    roughly, and negative inside."""
    R = torso.R_camera_torso
    length_m = float(model.lengths_m[UPPER_TORSO] + model.lengths_m[LOWER_TORSO])
    rx, rz = model.radii_m[UPPER_TORSO]
    x, y, z = ((points - torso.neck_camera) @ R).T
    beside = (np.sqrt((x / rx) ** 2 + (z / rz) ** 2) - 1.0) * min(rx, rz)
    from_torso = np.maximum(beside, np.maximum(-y, y - length_m))

    half_head_m = HEAD_CENTRE * model.lengths_m[HEAD]
    from_head = _to_segment(points, evidence.head_camera, torso.neck_camera) - half_head_m

    hips = torso.neck_camera + length_m * R[:, 1]
    knees = hips - model.lengths_m[LEFT_UPPER_LEG] * evidence.up_camera
    legs_m = model.radii_m[LEFT_UPPER_LEG, 0] + model.joints_parent[RIGHT_UPPER_LEG, 0]
    from_legs = _to_segment(points, hips, knees) - legs_m
    return np.minimum(np.minimum(from_torso, from_head), from_legs)


def _to_segment(points: Array, start: Array, end: Array) -> Array:
    """[N] distances in metres."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)
