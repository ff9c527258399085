"""Bodies rendered by the NumPy definition, as the tracker's evidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from topview.body.kinematics import joints_from_parts
from topview.body.model import BodyModel
from topview.body.proportions import ANATOMICAL
from topview.camera.projection import pixel_rays
from topview.camera.pyramid import Pyramid
from topview.geometry.quadrics import closed_cylinder_depths
from topview.geometry.rotations import rotations_from_angles
from topview.people.users import User
from topview.records import Camera, Frame
from topview.timing import StageClock
from topview.track.body_tracker import Subject
from topview.track.evidence import Evidence, gather
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand

CAMERA = Camera(fx=142.5, fy=142.5, cx=79.5, cy=59.5, width=160, height=120)
MODEL = BodyModel.of(1.75, ANATOMICAL)
UP = np.array([0.0, -1.0, 0.0])


def standing_pose(yaw_rad: float = 0.3, distance_m: float = 2.6) -> Pose:
    """Standing, with the arms held off the body and one elbow bent."""
    pose = stand(MODEL, np.array([0.05, -0.75, distance_m]), STANDING, yaw_rad, UP)
    Rs = pose.relative()
    for part, angles in ((3, (10, 0, 30)), (4, (40, 0, 0)), (5, (0, 0, -25)), (7, (5, 0, 6))):
        Rs[part] = rotations_from_angles(np.radians(angles))
    return Pose.from_relative(pose.neck_camera, Rs)


def joints_of(pose: Pose, model: BodyModel = MODEL) -> np.ndarray:
    """[16, 3] metres."""
    return joints_from_parts(model, pose.transforms(model))


def render(pose: Pose, model: BodyModel = MODEL, camera: Camera = CAMERA) -> np.ndarray:
    """[H, W] float32 metres, 0 beside the body."""
    rays = pixel_rays(camera).astype(np.float64)
    depth = np.full(rays.shape[:2], np.inf)
    for T, length, (rx, rz) in zip(
        pose.transforms(model), model.lengths_m, model.radii_m, strict=True
    ):
        depth = np.minimum(depth, closed_cylinder_depths(rays, T, length, rx, rz))
    return np.where(np.isfinite(depth), depth, 0.0).astype(np.float32)


def evidence_of(pose: Pose, model: BodyModel = MODEL, camera: Camera = CAMERA) -> Evidence:
    """What a noiseless camera sees of a lone body."""
    depth = render(pose, model, camera)
    head = pose.neck_camera - 0.5 * model.lengths_m[0] * pose.Rs[0][:, 1]
    return evidence_in(depth, depth > 0.0, head, model, camera)


def evidence_in(
    depth_m: np.ndarray,
    is_users: np.ndarray,
    head_camera: np.ndarray,
    model: BodyModel = MODEL,
    camera: Camera = CAMERA,
) -> Evidence:
    """What a depth image tells of the user with these pixels."""
    pixels = np.flatnonzero(is_users).astype(np.int32)
    user = User(1, head_camera, True, model.stature_m, True, pixels)
    labels = is_users.astype(np.int32)
    return gather(user, Pyramid(Frame(0, 0.0, depth_m, camera)), labels, None)


def at_frame(evidence: Evidence, index: int) -> Evidence:
    """The same, seen in a later frame."""
    return replace(evidence, timestamp_s=index / 30)


def subject(seed: int = 0, threads: int = 1) -> Subject:
    """Person 1."""
    return Subject(1, seed, threads, StageClock())
