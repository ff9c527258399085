"""People of the simulator in postures that no capture shows, as recordings to learn joints from."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.detect.joints import PROPOSED_JOINTS
from topview.records import InputError
from topview_lab.sim.bodies import SIM_JOINT_NAMES, SIM_PART_NAMES
from topview_lab.sim.recording import SimulatedRecording
from topview_lab.sim.scene import Scene
from topview_lab.sim.scenes import KINECT_V1_HALF
from topview_lab.sim.scenes.postures import posture_scene, seated_scene, touching_scene
from topview_lab.sim.truth import GroundTruth, stack_truth
from topview_lab.training.joints.recordings import LabelledRecording, our_joint_name

Array = NDArray[np.float64]

MOST_POSTURES: Final = 10_000
CENTRE_PARTS: Final = {
    "head_top": "head", "head": "head", "neck": "upper_torso", "shoulder": "upper_torso",
    "torso": "lower_torso", "pelvis": "lower_torso", "hip": "lower_torso",
    "elbow": "upper_arm", "wrist": "forearm", "hand": "hand",
    "knee": "upper_leg", "ankle": "lower_leg", "foot": "foot",
}  # fmt: skip
"""The part with whose axes each joint goes, of the own side."""
JOINT_CENTRES: Final[dict[str, tuple[float, float, float]]] = {
    "head_top": (0.000, -0.005, -0.011), "head": (0.000, -0.009, -0.007),
    "neck": (0.000, -0.013, 0.007), "shoulder": (0.012, 0.013, 0.002),
    "torso": (0.000, 0.006, -0.011), "pelvis": (0.000, 0.003, -0.013),
    "hip": (0.020, 0.003, -0.015), "elbow": (0.004, -0.009, -0.008),
    "wrist": (0.010, -0.009, 0.009), "hand": (0.011, -0.006, 0.012),
    "knee": (0.001, 0.000, 0.004), "ankle": (0.000, -0.005, -0.015),
    "foot": (-0.004, -0.009, 0.005),
}  # fmt: skip
"""Where the rig of the rendered people has its joints, seen from the simulator's: along x (to the
person's right; of left joints to the left), y and z of their parts, in shares of the stature.
`scripts/fit_joint_centres.py` printed it, with the network that had seen rendered people only."""


def check_postures(count: int) -> None:
    """Raises InputError if so many people in postures cannot be simulated."""
    if not 0 <= count <= MOST_POSTURES:
        raise InputError(f"--postures is {count}; it must be 0 to {MOST_POSTURES}")


def posture_recording(number: int) -> LabelledRecording:
    """Simulated people in all postures of the scenes of a seed (`posture_scenes`)."""
    first, *others = (simulated_recording(scene) for scene in posture_scenes(number))
    frames = {
        field: np.concatenate([getattr(own, field) for own in (first, *others)])
        for field in ("depth_mm", "masks", "joints_camera", "hidden", "is_present")
    }
    return replace(first, **frames)


def posture_scenes(number: int) -> tuple[Scene, ...]:
    """Somebody in postures, somebody on a seat, and somebody with hands on the own body."""
    scenes = posture_scene, seated_scene, touching_scene
    return tuple(scene(number, KINECT_V1_HALF) for scene in scenes)


def simulated_recording(scene: Scene) -> LabelledRecording:
    """All frames of a scene, joints where the rendered people have them."""
    recording = SimulatedRecording(scene)
    frames = [recording.simulate(index) for index in range(recording.frame_count)]
    truth = stack_truth(scene, [frame.truth for frame in frames])
    columns = [SIM_JOINT_NAMES.index(name) for name in _SIM_NAMES]
    camera = scene.camera
    return LabelledRecording(
        scene.name,
        np.stack([frame.depth_mm for frame in frames]),
        np.stack([frame.mask for frame in frames]),
        joints_of_rig(truth)[:, :, columns].astype(np.float32),
        truth.joint_occ_inter[:, :, columns],
        truth.present,
        truth.ids,
        (camera.fx, camera.fy, camera.cx, camera.cy),
    )


def joints_of_rig(truth: GroundTruth) -> Array:
    """[F, P, 21, 3] the simulator's joints, each moved to where the rendered people have it."""
    joints = truth.joints.astype(np.float64)
    for j, name in enumerate(SIM_JOINT_NAMES):
        stem, side = stem_and_side(name)
        part = sim_part(stem, side)
        way = np.array(JOINT_CENTRES[stem]) * [-1.0 if side == "_l" else 1.0, 1.0, 1.0]
        R_camera_part = truth.Ts_camera_part[:, :, part, :3, :3]
        joints[:, :, j] += truth.stature[:, None] * (R_camera_part @ way)
    return joints


def stem_and_side(name: str) -> tuple[str, str]:
    """A simulated joint's name, and "_l", "_r" or nothing."""
    return (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")


def sim_part(stem: str, side: str) -> int:
    """Index of the simulator's part with whose axes a joint goes: of its side, if it has sides."""
    part = CENTRE_PARTS[stem]
    own = f"{part}{side}"
    return SIM_PART_NAMES.index(own if own in SIM_PART_NAMES else part)


_SIM_NAMES: Final = [
    next(name for name in SIM_JOINT_NAMES if our_joint_name(name) == proposed)
    for proposed in PROPOSED_JOINTS
]
