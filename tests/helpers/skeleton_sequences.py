"""Small skeleton sequences, recordings and a tracker that the tests of the evaluation share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from topview.body import JOINT_NAMES, PART_NAMES
from topview.records import Recording
from topview.skeletons import SkeletonSequence, columns_as_slots
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.metrics import ReferenceSequence

J, B = len(JOINT_NAMES), len(PART_NAMES)
STATURE_M = 1.6
WIDTH, HEIGHT = 8, 6


def standing(x_m: float = 0.0, z_m: float = 2.5) -> NDArray[np.float64]:
    """[J, 3] someone who stands at x, z with the limbs straight down: all part axes are +y."""
    positions = {
        "head": (0.0, -0.65),
        "neck": (0.0, -0.5),
        "torso": (0.0, -0.2),
        "pelvis": (0.0, 0.1),
        **{f"{s}_shoulder": (x, -0.45) for s, x in (("left", 0.18), ("right", -0.18))},
        **{f"{s}_elbow": (x, -0.15) for s, x in (("left", 0.18), ("right", -0.18))},
        **{f"{s}_hand": (x, 0.15) for s, x in (("left", 0.18), ("right", -0.18))},
        **{f"{s}_hip": (x, 0.1) for s, x in (("left", 0.09), ("right", -0.09))},
        **{f"{s}_knee": (x, 0.5) for s, x in (("left", 0.09), ("right", -0.09))},
        **{f"{s}_ankle": (x, 0.9) for s, x in (("left", 0.09), ("right", -0.09))},
    }
    return np.array([(x_m + positions[j][0], positions[j][1], z_m) for j in JOINT_NAMES])


def people_standing(frames: int, *x_m: float) -> NDArray[np.float64]:
    """[F, P, J, 3] people who stand still at the given places."""
    return np.tile(np.stack([standing(x) for x in x_m]), (frames, 1, 1, 1))


def reference_of(joints_camera: NDArray[np.float64], **other: Any) -> ReferenceSequence:
    """All present wherever their joints are finite."""
    F, R = joints_camera.shape[:2]
    present = np.isfinite(joints_camera).all((2, 3))
    fields: dict[str, Any] = {
        "frame_index": np.arange(F),
        "person_ids": np.arange(1, R + 1),
        "joint_names": JOINT_NAMES,
        "joints_camera": joints_camera.copy(),
        "present": present,
    }
    return ReferenceSequence(**(fields | other))


def predicted_of(
    joints_camera: NDArray[np.float64],
    Rs_camera_part: NDArray[np.float64] | None = None,
    **other: Any,
) -> SkeletonSequence:
    """[F, P, J, 3] joints, everybody in a slot of their own; with parts that are not rotated,
    unless [F, P, B, 3, 3] rotations are given. `person_ids` and `heights_m` are [P]."""
    F, P = joints_camera.shape[:2]
    Ts = np.tile(np.eye(4), (F, P, B, 1, 1))
    if Rs_camera_part is not None:
        Ts[..., :3, :3] = Rs_camera_part
    frame_index = other.pop("frame_index", np.arange(F))
    slots: dict[str, Any] = columns_as_slots(
        other.pop("person_ids", np.arange(1, P + 1)),
        np.asarray(np.isfinite(joints_camera).all(-1).any(-1)),
        frame_index,
        other.pop("heights_m", np.full(P, STATURE_M)),
    )
    fields: dict[str, Any] = {
        "frame_index": frame_index,
        "timestamps_s": np.arange(F) / 30.0,
        "joint_names": JOINT_NAMES,
        "joints_camera": joints_camera.copy(),
        "joint_state": np.ones((F, P, J), np.uint8),
        "joint_confidence": np.ones((F, P, J), np.float32),
        "part_names": PART_NAMES,
        "Ts_camera_part": Ts,
    }
    return SkeletonSequence(**(fields | slots | other))


def track_distance(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """A tracker that sees one person, at the image's largest depth."""
    frames = list(recording)
    joints = np.stack([standing(z_m=float(frame.depth_m.max()))[None] for frame in frames])
    indices = np.array([frame.index for frame in frames])
    return TrackingResult(predicted_of(joints, frame_index=indices), 0.5, False)


def write_folder_recording(folder: Path, depths_m: list[float]) -> Path:
    """Depth images that show one distance each."""
    (folder / "depth").mkdir(parents=True)
    for i, depth_m in enumerate(depths_m):
        image = np.full((HEIGHT, WIDTH), round(depth_m * 1000.0), np.uint16)
        assert cv2.imwrite(str(folder / "depth" / f"{i:06d}.png"), image)
    camera = {"fx": 10.0, "fy": 10.0, "cx": 4.0, "cy": 3.0, "width": WIDTH, "height": HEIGHT}
    (folder / "camera.json").write_text(json.dumps(camera | {"depth_scale": 0.001}))
    return folder


def rendered_names() -> list[str]:
    """Our joints as the rendered recordings name them."""
    return [f"{name.split('_', 1)[1]}_{name[0]}" if "_" in name else name for name in JOINT_NAMES]


def rendered_groundtruth(depths_m: list[float], **other: Any) -> dict[str, Any]:
    """Arrays of a `groundtruth.npz` in the rendered layout: one person at these distances."""
    joints = np.stack([standing(z_m=z)[None] for z in depths_m]).astype(np.float32)
    F = len(depths_m)
    arrays: dict[str, Any] = {
        "names": np.array(rendered_names()),
        "joints": joints,
        "present": np.ones((F, 1), bool),
        "stature": np.array([1.7], np.float32),
        "joint_occ_person": np.zeros((F, 1, J), np.float32),
    }
    return arrays | other


def write_rendered(folder: Path, depths_m: list[float], **other: Any) -> Path:
    """A folder recording with truth in the rendered layout."""
    write_folder_recording(folder, depths_m)
    np.savez(folder / "groundtruth.npz", **rendered_groundtruth(depths_m, **other))
    return folder
