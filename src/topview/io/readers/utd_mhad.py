"""UTD-MHAD: Kinect v1 sequences with the SDK's skeleton.

C. Chen, R. Jafari, N. Kehtarnavaz, "UTD-MHAD: A multimodal dataset for human action recognition
utilizing a depth camera and a wearable inertial sensor", ICIP 2015. Images and skeletons are
stored mirrored; both are flipped here, into the camera frame x right, y down, z forward.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.io.readers.depth import METRES_PER_MILLIMETRE, depth_image
from topview.io.readers.matlab import read_variable
from topview.records import Camera, Frame

# After flipping left-right; the focal length is the Kinect SDK's NUI_CAMERA_DEPTH_NOMINAL_
# FOCAL_LENGTH_IN_PIXELS for 320 x 240.
CAMERA: Final = Camera(fx=285.63, fy=285.63, cx=159.0, cy=120.0, width=320, height=240)
FPS: Final = 30.0
SKELETON_LEAD_FRAMES: Final = 1.5  # depth frame t goes with skeleton sample t - 1.5; measured
SKELETON_JOINT_NAMES: Final = (
    "head",
    "shoulder_center",
    "spine",
    "hip_center",
    *(f"left_{joint}" for joint in ("shoulder", "elbow", "wrist", "hand")),
    *(f"right_{joint}" for joint in ("shoulder", "elbow", "wrist", "hand")),
    *(f"left_{joint}" for joint in ("hip", "knee", "ankle", "foot")),
    *(f"right_{joint}" for joint in ("hip", "knee", "ankle", "foot")),
)


def recognises(path: Path) -> bool:
    return path.suffix.lower() == ".mat"


class UtdMhadRecording:
    """One `*_depth.mat`: `d_depth` [240, 320, frames] millimetres, background removed.

    Raises:
        InputError: unreadable, truncated, or not such a file.
    """

    is_flipped_back: Final = True

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self.camera = CAMERA
        self.problems: list[str] = []
        shape = (CAMERA.height, CAMERA.width, None)
        self._depth_mm = read_variable(path, "d_depth", shape, "a UTD-MHAD *_depth.mat")

    @property
    def frame_count(self) -> int:
        return self._depth_mm.shape[2]

    def __iter__(self) -> Iterator[Frame]:
        for index in range(self.frame_count):
            depth_mm = self._depth_mm[:, ::-1, index]
            depth_m = depth_image(depth_mm, METRES_PER_MILLIMETRE)
            yield Frame(index, index / FPS, depth_m, self.camera)


def read_utd_skeleton(path: Path | str) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """The SDK's joints at the times of the depth frames, from a `*_skeleton.mat`.

    Returns:
        The 20 joint names, and joints_camera [F, 20, 3] metres, F being the number of skeleton
        samples, which is the number of depth frames. Between samples the joints are interpolated
        linearly; the first frames, which lie before the first sample, are NaN.

    Raises:
        InputError: unreadable, truncated, or not such a file.
    """
    joints, axes = len(SKELETON_JOINT_NAMES), 3
    skeleton = read_variable(
        Path(path), "d_skel", (joints, axes, None), "a UTD-MHAD *_skeleton.mat"
    )
    # x is mirrored as the images are, y points up in the file.
    samples_camera = np.moveaxis(skeleton.astype(np.float64), -1, 0) * (-1.0, -1.0, 1.0)
    return SKELETON_JOINT_NAMES, _delayed(samples_camera, SKELETON_LEAD_FRAMES)


def _delayed(samples: NDArray[np.float64], delay: float) -> NDArray[np.float64]:
    """[F, ...] sampled at t - delay for t = 0..F-1, linearly; NaN outside."""
    times = np.arange(len(samples)) - delay
    before = np.floor(times).astype(int)
    share = (times - before).reshape(-1, *[1] * (samples.ndim - 1))
    inside = (times >= 0.0) & (times <= len(samples) - 1)
    first = np.clip(before, 0, len(samples) - 1)
    second = np.clip(before + 1, 0, len(samples) - 1)
    delayed = (1.0 - share) * samples[first] + share * samples[second]
    delayed[~inside] = np.nan
    return delayed
