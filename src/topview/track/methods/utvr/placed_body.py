"""The parts that are placed in one frame, and the points that they have left over."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.kinematics import place_part
from topview.body.limits import LIMITS_RAD
from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import HEAD, LOWER_TORSO, PARTS, UPPER_TORSO
from topview.camera.pyramid import DepthView
from topview.geometry.rotations import rotations_from_angles, unit
from topview.kernels.limits import hinge_excess, part_excess
from topview.score.utvr import placed_parts
from topview.track.evidence import Evidence
from topview.track.methods.btvr.torso import NO_PARTS
from topview.track.methods.utvr.particles import across, frames_of
from topview.track.methods.utvr.settings import UtvrSettings
from topview.track.pose import HINGE_BENDS, FittedBody

Array = NDArray[np.float64]

# All ours.
# Of the radii of placed parts, when collisions are counted: skin that touches does not collide.
# Adjoining parts share a joint and are left out.
COLLISION_SHARE: Final = 0.8
KNOWN_BEND: Final = 0.1  # sine of the bend from which on it tells the hinge better than memory does

TORSO_PARTS: Final = (UPPER_TORSO, LOWER_TORSO)
UPPER_LIMBS: Final = frozenset(part.parent for part in PARTS if part.is_hinge)


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """The points that no part has taken yet, and the scene at their resolution.

    Attributes:
        points_camera: [N, 3] metres.
        is_coarse: [N] which of them half the resolution shows, too.
        view: the scene's depth.
    """

    points_camera: Array
    is_coarse: NDArray[np.bool_]
    view: DepthView

    @classmethod
    def of(cls, evidence: Evidence) -> Cloud:
        return cls(evidence.all_points_camera, evidence.is_coarse, evidence.view)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> Cloud:
        return replace(
            self, points_camera=self.points_camera[chosen], is_coarse=self.is_coarse[chosen]
        )

    def coarse(self, evidence: Evidence) -> Cloud:
        """At half the resolution."""
        return replace(self[self.is_coarse], view=evidence.coarse_view)


class PlacedBody:
    """The parts that are placed in this frame, from the head down.

    Attributes:
        lengths_m: [11] of the cylinders.
    """

    def __init__(self, model: BodyModel, evidence: Evidence, settings: UtvrSettings) -> None:
        self.model = model
        self.lengths_m = np.array(model.lengths_m)
        self.lengths_m[LOWER_TORSO] += settings.torso_below_hips * model.stature_m
        self.head_camera = evidence.head_camera
        self._settings = settings
        self.up_camera = evidence.up_camera
        self._nearer_parts = np.concatenate(
            [NO_PARTS, *(parts_of(body) for body in evidence.nearer_bodies)]
        )
        self.Rs = np.empty((len(PARTS), 3, 3))
        self.origins = np.empty((len(PARTS), 3))

    def joints_of(self, part: int, Rs: Array) -> Array:
        """[M, 3] proximal joints in metres, camera frame, of a part turned like `Rs` [M, 3, 3]:
        the crown above the measured head, the neck below it, any other joint on the part above."""
        if part == HEAD:
            return self.head_camera - HEAD_CENTRE * self.model.lengths_m[HEAD] * Rs[:, :, 1]
        parent = PARTS[part].parent
        if part == UPPER_TORSO and self._settings.neck is not None:
            below, behind = self._settings.neck
            downwards = unit(Rs[:, :, 1] - self.up_camera)
            away = below * downwards - behind * Rs[:, :, 2]
            return self.head_camera + self.model.stature_m * away
        joint = place_part(self.model, part, self.Rs[parent], self.origins[parent])
        return np.broadcast_to(joint, (len(Rs), 3))

    def cylinders_of(self, part: int, Rs: Array, joints: Array) -> Array:
        """[M, 3] origins of the cylinders of a part with these proximal joints."""
        if part not in TORSO_PARTS:
            return joints
        return joints + self._settings.torso_ahead * self.model.stature_m * Rs[:, :, 2]

    def place(self, part: int, R: Array) -> None:
        """Fix a part; a forearm or lower leg turns the part above about its own axis, so that it
        bends about the hinge."""
        self.origins[part] = self.joints_of(part, R[None])[0]
        self.Rs[part] = R
        if PARTS[part].is_hinge:
            upper = PARTS[part].parent
            self.Rs[[upper, part]] = self._bent(part, R[None])[0]

    def turn_head(self) -> None:
        """Let the head face where the torso does, on an axis from its measured centre to the
        neck."""
        to_neck = unit(self.origins[UPPER_TORSO] - self.head_camera)[None]
        self.Rs[HEAD] = frames_of(across(self.Rs[UPPER_TORSO, :, 0][None], to_neck), to_neck)[0]

    def anywhere(self, part: int, count: int, rng: np.random.Generator) -> Array:
        """[M, 3, 3] hypotheses of a part from all over the limits of Table 3.2, `count` at the
        most."""
        low, high = LIMITS_RAD[part].T
        Rs = self.Rs[PARTS[part].parent]
        if PARTS[part].is_hinge:  # whichever way the part above it is turned about its own axis
            turns_rad = np.zeros((count, 3))
            least_rad, most_rad = LIMITS_RAD[PARTS[part].parent, 1]
            turns_rad[:, 1] = rng.uniform(least_rad, most_rad, count)
            Rs = Rs @ rotations_from_angles(turns_rad)
        Rs = Rs @ rotations_from_angles(rng.uniform(low, high, (count, 3)))
        return Rs[self.excess_rad(part, Rs) <= 0.0]

    def excess_rad(self, part: int, Rs: Array) -> Array:
        """[M] by how much hypotheses [M, 3, 3] leave the limits of Table 3.2."""
        if part == HEAD or (part == UPPER_TORSO and self._settings.neck is not None):
            return np.zeros(len(Rs))
        parent = PARTS[part].parent
        beyond_rad = np.empty(len(Rs))
        if PARTS[part].is_hinge:
            hinge_excess(
                Rs, self.Rs[parent], self.Rs[PARTS[parent].parent], LIMITS_RAD[parent],
                float(np.abs(LIMITS_RAD[part, 0]).max()), HINGE_BENDS[parent], KNOWN_BEND,
                beyond_rad,
            )  # fmt: skip
        else:  # an upper limb's turn about its own axis is not searched
            part_excess(Rs, self.Rs[parent], LIMITS_RAD[part], part not in UPPER_LIMBS, beyond_rad)
        return beyond_rad

    def _bent(self, lower: int, Rs: Array) -> Array:
        """[M, 2, 3, 3] rotations of an upper limb and the part below it, for each hypothesis of
        where the latter points: the hinge is perpendicular to both; a straight limb keeps it."""
        R_upper = self.Rs[PARTS[lower].parent]
        ys_lower = Rs[:, :, 1]
        ys_upper = np.broadcast_to(R_upper[:, 1], ys_lower.shape)
        hinges = HINGE_BENDS[PARTS[lower].parent] * np.cross(ys_upper, ys_lower)
        hinges += KNOWN_BEND * R_upper[:, 0]
        xs_upper = across(hinges, ys_upper)
        return np.stack(
            [frames_of(xs_upper, ys_upper), frames_of(across(xs_upper, ys_lower), ys_lower)], axis=1
        )

    def obstacles(self, part: int) -> NDArray[np.float32]:
        """[K, 15] placed parts that do not adjoin this one, shrunk, and those of nearer users, for
        f_coll (Eq. 5.9)."""
        parent = PARTS[part].parent
        others = [
            other for other in range(part) if other != parent and PARTS[other].parent != parent
        ]
        own = placed_parts(
            self.Rs[others],
            self.origins[others],
            self.lengths_m[others],
            COLLISION_SHARE * self.model.radii_m[others],
        )
        return np.concatenate([own, self._nearer_parts])

    def has_inside(self, part: int, points: Array) -> NDArray[np.bool_]:
        """[N] True for the [N, 3] points that are a placed part's: those inside, and of the torso
        those near it."""
        R = self.Rs[part]
        origin = self.cylinders_of(part, R[None], self.origins[part][None])[0]
        x, y, z = ((points - origin) @ R).T
        s = self._settings
        rx, rz = self.model.radii_m[part] + (
            s.torso_reach_m if part in TORSO_PARTS else s.clothing_m
        )
        is_between = (y >= 0.0) & (y <= self.lengths_m[part])
        return is_between & ((x / rx) ** 2 + (z / rz) ** 2 <= 1.0)


def parts_of(body: FittedBody) -> NDArray[np.float32]:
    """[K, 15] the tracked parts of another user, shrunk."""
    Ts = body.Ts_camera_part
    is_tracked = np.isfinite(Ts).all((1, 2))
    return placed_parts(
        Ts[is_tracked, :3, :3],
        Ts[is_tracked, :3, 3],
        body.model.lengths_m[is_tracked],
        COLLISION_SHARE * body.model.radii_m[is_tracked],
    )
