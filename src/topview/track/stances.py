"""Stances: standing, bending and sitting poses from which a new or lost pose is searched (ours).

The thesis starts from roughly standing; arbitrary initial poses are its future work (Sec. 7.1).
The limb search then finds arms and legs.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.body.model import BodyModel
from topview.body.parts import (
    HEAD,
    LEFT_FOREARM,
    LEFT_LOWER_LEG,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    PARTS,
    RIGHT_FOREARM,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_ARM,
    RIGHT_UPPER_LEG,
    UPPER_TORSO,
)
from topview.geometry.rotations import cross, rotations_from_angles, unit
from topview.records import read_only
from topview.track.pose import Pose

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Stance:
    """Angles in degrees, 0 for standing.

    Attributes:
        lean: of the trunk, forward.
        hip, knee, shoulder, elbow: flexion of both sides.
    """

    lean: float = 0.0
    hip: float = 0.0
    knee: float = 0.0
    shoulder: float = 0.0
    elbow: float = 0.0


HEAD_LEAN_SHARE: Final = 0.7  # of the trunk's lean, ours
STANDING: Final = Stance()
STANCES: Final = (
    STANDING,
    Stance(lean=40, hip=40, knee=5, shoulder=40),
    Stance(lean=80, hip=80, knee=10, shoulder=80),
    Stance(hip=85, knee=85, shoulder=20, elbow=70),
    Stance(lean=35, hip=110, knee=80, shoulder=50, elbow=20),
    Stance(lean=30, hip=80, knee=90, shoulder=60),
)


def facing(yaw_rad: float, up_camera: Array) -> Array:
    """[3, 3] rotation of somebody upright, turned by `yaw_rad` from facing the camera."""
    return _facing_camera(*up_camera.tolist()) @ rotations_from_angles(
        np.array([0.0, yaw_rad, 0.0])
    )


@lru_cache(maxsize=64)  # a room's is the same in every frame
def _facing_camera(*up_camera: float) -> Array:
    y = -unit(np.array(up_camera))
    z = unit(np.array([0.0, 0.0, -1.0]) + y * y[2])
    return read_only(np.stack([cross(y, z), y, z], axis=1))


def heading(R_camera_torso: Array, up_camera: Array) -> float:
    """The yaw of `facing` that comes nearest to a torso's rotation."""
    return float(headings(R_camera_torso[None], up_camera)[0])


def headings(Rs_camera_torso: Array, up_camera: Array) -> Array:
    """[M] of [M, 3, 3], as `heading`."""
    front, up = Rs_camera_torso[..., 2], Rs_camera_torso[..., 1]
    rise = np.vecdot(front, up_camera)[:, None]
    # Of a torso that is bent over by more than 90 degrees, the front points backwards.
    level = front - up_camera * rise + up * rise
    upright = _facing_camera(*up_camera.tolist()).T @ level[..., None]
    return np.arctan2(upright[:, 0, 0], upright[:, 2, 0])


@cache
def rotations_of(stance: Stance) -> Array:
    """[11, 3, 3] of the parts of a stance, in the frame of `facing`."""
    pitches = np.zeros((len(PARTS), 3))
    pitches[HEAD, 0] = -HEAD_LEAN_SHARE * stance.lean
    pitches[[UPPER_TORSO, LOWER_TORSO], 0] = -stance.lean
    pitches[[LEFT_UPPER_LEG, RIGHT_UPPER_LEG], 0] = stance.hip - stance.lean
    pitches[[LEFT_LOWER_LEG, RIGHT_LOWER_LEG], 0] = stance.hip - stance.lean - stance.knee
    pitches[[LEFT_UPPER_ARM, RIGHT_UPPER_ARM], 0] = stance.shoulder - stance.lean
    pitches[[LEFT_FOREARM, RIGHT_FOREARM], 0] = stance.shoulder - stance.lean + stance.elbow
    return rotations_from_angles(np.radians(pitches))


def stand(
    model: BodyModel, head_camera: Array, stance: Stance, yaw_rad: float, up_camera: Array
) -> Pose:
    """The pose of a stance below a head."""
    Rs = facing(yaw_rad, up_camera) @ rotations_of(stance)
    return Pose.below_head(head_camera, Rs, model)


def stand_all(
    model: BodyModel, head_camera: Array, yaws_rad: Iterable[float], up_camera: Array
) -> list[Pose]:
    """Every stance in every direction."""
    return [
        stand(model, head_camera, stance, yaw, up_camera) for yaw in yaws_rad for stance in STANCES
    ]
