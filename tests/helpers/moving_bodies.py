"""Rigid people who move before a tilted camera, as a tracker would tell them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.body.ends import output_joints
from topview.body.kinematics import (
    R_CAMERA_FACING,
    forward_kinematics,
    rotations_in_camera,
)
from topview.body.limits import LIMITS_RAD
from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.geometry.rotations import rotations_from_angles
from topview.skeletons import About, SkeletonSequence, TrackedFrame

STATURES_M = {1: 1.8, 3: 1.6}
TILT_RAD = 0.3
CAMERA_HEIGHT_M = 1.4
UP_CAMERA = np.array([0.0, -np.cos(TILT_RAD), -np.sin(TILT_RAD)])
# Who is there at which time: person 3 leaves and returns, a frame is missing at 0.3 s.
WHO = {0.0: [1], 0.1: [1, 3], 0.2: [1], 0.4: [1, 3], 0.5: [3]}


def pose(
    angles_rad: NDArray[np.float64], stature_m: float = 1.8, place: tuple[float, ...] = (0, -0.6, 3)
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[J, 3] joints and [B, 4, 4] parts of a body that faces the camera, its crown at a place, with
    [B, 3] turns of its parts about x, y and z."""
    model = BodyModel.of(stature_m, ANATOMICAL)
    Rs = rotations_from_angles(angles_rad)
    Rs[0] = R_CAMERA_FACING @ Rs[0]
    Ts = forward_kinematics(model, np.array(place), rotations_in_camera(Rs))
    return output_joints(model, Ts), Ts


def moving_people(who: dict[float, list[int]] = WHO) -> SkeletonSequence:
    """Poses within the limits of the joints, at random."""
    rng = np.random.default_rng(1)
    low, high = np.clip(np.moveaxis(LIMITS_RAD, -1, 0), -1.2, 1.2)
    about = About(OUTPUT_JOINT_NAMES, PART_NAMES, {"recording": "made"})
    frames = []
    for f, (time_s, ids) in enumerate(who.items()):
        people = np.zeros(len(ids), about.person_type)
        for row, person_id in zip(people, ids, strict=True):
            place = (0.5 * person_id - 1.0, -0.6, 3.0 + 0.1 * f)
            joints, Ts = pose(rng.uniform(low, high), STATURES_M[person_id], place)
            row["id"], row["height_m"] = person_id, STATURES_M[person_id]
            row["joints_camera"], row["Ts_camera_part"] = joints, Ts
            row["joint_state"], row["joint_confidence"] = 1, 0.5
        frames.append(
            TrackedFrame(f, time_s, f"{f}.png", people, (*UP_CAMERA.tolist(), CAMERA_HEIGHT_M))
        )
    return SkeletonSequence.from_frames(frames, about)


def upright(points_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points with x right, y up and z towards the camera, from the floor below it."""
    turned = Rotation.from_rotvec([np.pi - TILT_RAD, 0.0, 0.0]).apply(points_camera.reshape(-1, 3))
    return (turned + np.array([0.0, CAMERA_HEIGHT_M, 0.0])).reshape(points_camera.shape)
