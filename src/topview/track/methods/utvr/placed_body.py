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
from topview.kernels.limits import bend_about_hinge, hinge_excess, part_excess
from topview.kernels.utvr import take_inside
from topview.score.utvr import FIRST_LAYER, Observed, placed_parts
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
class Remaining:
    """What no part has taken yet of the user's points; of several ways to place the last part, a
    layer each.

    Attributes:
        fine: all of them.
        coarse_view: the scene's depth at half the resolution.
    """

    fine: Observed
    coarse_view: DepthView

    @classmethod
    def of(cls, evidence: Evidence) -> Remaining:
        return cls(evidence.observed(is_coarse=False), evidence.coarse_view)

    @property
    def coarse(self) -> Observed:
        """Those that half the resolution shows, too."""
        return Observed(self.coarse_view, np.ascontiguousarray(self.fine.own[::2, ::2]))

    def layer(self, index: int) -> Remaining:
        """One of the layers, as the first."""
        own = (self.fine.own >> np.uint8(index)) & np.uint8(FIRST_LAYER)
        return replace(self, fine=replace(self.fine, own=own))


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
        joints = np.empty((len(Rs), 3))
        joints[:] = place_part(self.model, part, self.Rs[parent], self.origins[parent])
        return joints

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
            bend_about_hinge(self.Rs[upper], self.Rs[part], HINGE_BENDS[upper], KNOWN_BEND)

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

    def left_by(self, part: int, Rs: Array, remaining: Remaining) -> Remaining:
        """What a part leaves over that is turned like each of [K, 3, 3], at most 8, in a layer for
        each: without the points inside, and of the torso without those near it.

        Args:
            remaining: in the first layer.
        """
        view = remaining.fine.view
        own = remaining.fine.own * np.uint8(2 ** len(Rs) - 1)
        reach_m = self._settings.torso_reach_m if part in TORSO_PARTS else self._settings.clothing_m
        f4 = np.float32
        rx_m, rz_m = (self.model.radii_m[part] + reach_m).astype(f4)
        take_inside(
            view.depth_m, f4(view.fx), f4(view.fy), f4(view.cx), f4(view.cy), Rs.astype(f4),
            self.cylinders_of(part, Rs, self.joints_of(part, Rs)).astype(f4),
            f4(self.lengths_m[part]), rx_m, rz_m, own,
        )  # fmt: skip
        return replace(remaining, fine=replace(remaining.fine, own=own))


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
