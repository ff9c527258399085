"""Where the torso of somebody simulated truly is, in one frame, and what the frame shows of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from topview.camera.pyramid import DepthView
from topview.geometry.rotations import unit
from topview.score.utvr import Observed
from topview_lab.sim import GroundTruth, SimulatedRecording

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class TrueTorso:
    """A torso in one frame; where it truly points, and what is seen.

    Attributes:
        R_camera_torso: [3, 3].
        head_camera: [3] the head's centre, metres.
        stature_m: of the person.
        observed: the scene, and what is seen of the person.
        up_camera: [3].
        hidden_share: of the person's area, by others.
    """

    R_camera_torso: Array
    head_camera: Array
    stature_m: float
    observed: Observed
    up_camera: Array
    hidden_share: float

    @classmethod
    def of(cls, recording: SimulatedRecording, truth: GroundTruth, frame: int) -> Self:
        """Of the first person."""
        simulated = recording.simulate(frame)
        camera = recording.camera
        depth_m = simulated.depth_mm.astype(np.float32) / np.float32(1000.0)
        view = DepthView(depth_m, camera.fx, camera.fy, camera.cx, camera.cy)
        joints = dict(zip(truth.names, truth.joints[frame, 0].astype(np.float64), strict=True))
        return cls(
            _rotation(joints),
            joints["head"],
            float(truth.stature[0]),
            Observed.of(view, (simulated.mask == 1) & (depth_m > 0)),
            recording.scene.mount.T_camera_room()[:3, 2],
            float(truth.person_occ_person[frame, 0]),
        )


def _rotation(joints: dict[str, Array]) -> Array:
    """[3, 3] R_camera_torso, from shoulders and hips."""
    y = unit(joints["pelvis"] - 0.5 * (joints["shoulder_l"] + joints["shoulder_r"]))
    across = joints["shoulder_r"] - joints["shoulder_l"]
    x = unit(across - y * (across @ y))
    return np.stack([x, y, np.cross(x, y)], axis=1)
