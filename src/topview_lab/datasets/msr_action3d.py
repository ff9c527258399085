"""MSR Action3D: 20 actions, 10 subjects, 2 or 3 repetitions, with skeletons of 20 joints.

W. Li, Z. Zhang and Z. Liu, "Action recognition based on a bag of 3D points", CVPR Workshop on
Human Communicative Behavior Analysis 2010. The depth lies in `a01_s01_e01_sdepth.bin`, skeletons in
either or both of the published variants, in the folder itself or in folders in it:

- `a01_s01_e01_skeleton3D.txt`: x, y, z in metres, y up, and a confidence, a line each joint;
- `a01_s01_e01_skeleton.txt`: column, row, depth in the depth images' unit, and a confidence.

The skeletons are a tracker's, not truth. Decided by us, as the publication does not say: the camera
(`topview.io.readers.msr_action3d`); the unit, as that which agrees best with the skeleton; whether
x is mirrored, by which way more joints lie on the person; left and right, as if facing the camera.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.camera.projection import project
from topview.files import naming, read_text
from topview.io.readers.depth import METRES_PER_MILLIMETRE
from topview.io.readers.msr_action3d import UNITS_MM, MsrAction3dRecording
from topview.records import Camera, InputError
from topview_lab.datasets.base import select_by_name
from topview_lab.datasets.joints import facing_sides
from topview_lab.metrics import ReferenceSequence

MSR_DEPTH_FILE: Final = re.compile(r"a(\d+)_s(\d+)_e(\d+)_sdepth\.bin")
SKELETONS: Final = ("_skeleton3D.txt", "_skeleton.txt")
"""The better one first."""
MOST_NUMBER: Final = 1e5
"""In a skeleton: metres, pixels, or steps of depth of 16 bits (ours)."""
MSR_JOINTS: Final = (
    "left_shoulder", "right_shoulder", "neck", "torso", "left_hip", "right_hip", "pelvis",
    "left_elbow", "right_elbow", "", "", "left_hand", "right_hand", "left_knee", "right_knee",
    "left_ankle", "right_ankle", "", "", "head",
)  # fmt: skip
"""Ours in the order of the files, "" for wrists and feet."""


@dataclass(frozen=True, slots=True)
class MsrAction3dSequence:
    """One sequence: action, subject, repetition; its depth and its skeleton file."""

    name: str
    depth: Path
    skeleton: Path

    def open(self) -> MsrAction3dRecording:
        recording = MsrAction3dRecording(self.depth)
        rows = read_skeleton(self.skeleton)
        units = recording.depth_units
        if self.skeleton.name.endswith(SKELETONS[0]):
            target_m = np.nanmedian(rows[:, MSR_JOINTS.index("torso"), 2])
            unit_m = _nearest_unit(target_m / np.median(units[units > 0]))
            return MsrAction3dRecording(self.depth, unit_m)
        return recording

    def reference(self) -> ReferenceSequence:
        """The skeletons, without the frames in which it was lost."""
        recording, rows = self.open(), read_skeleton(self.skeleton)
        if len(rows) != recording.frame_count:
            raise InputError(
                f"{self.skeleton}: has {len(rows)} frames, its depth {recording.frame_count}; "
                "they must be the same frames"
            )
        if self.skeleton.name.endswith(SKELETONS[0]):
            joints_camera = _placed(rows, recording)
        else:
            joints_camera = _unprojected(rows, recording)
        columns = [k for k, name in enumerate(MSR_JOINTS) if name]
        joints_camera = joints_camera[:, columns]
        names = facing_sides([MSR_JOINTS[k] for k in columns], joints_camera)
        known = np.isfinite(joints_camera).all(-1).any(-1)
        return ReferenceSequence(
            frame_index=np.flatnonzero(known),
            person_ids=np.array([1]),
            joint_names=names,
            joints_camera=joints_camera[known, None],
            present=np.ones((int(known.sum()), 1), bool),
            actions=np.full((int(known.sum()), 1), self.name[:3]),
            bodies=(f"subject {self.name[5:7]}",),
        )


def read_skeleton(path: Path) -> NDArray[np.float64]:
    """[F, 20, 3] the first three numbers of each line, NaN for joints that are all zero.

    Raises:
        InputError: missing, or not lines of four numbers, 20 to a frame.
    """
    right = "it must have 20 lines for each frame, of x, y, z and a confidence"
    with naming(path, right=right):
        lines = [line.split() for line in read_text(path, right=right).splitlines()]
        try:
            rows = np.array([line for line in lines if line], np.float64)
        except ValueError as error:
            raise InputError(f"is damaged ({error}); {right}") from None
        if rows.ndim != 2 or rows.shape[1] != 4 or not len(rows) or len(rows) % len(MSR_JOINTS):
            raise InputError(f"has {rows.shape[0]} lines of numbers; {right}")
        if not (np.abs(rows) <= MOST_NUMBER).all():
            raise InputError(f"has numbers that are not finite, or beyond {MOST_NUMBER:g}; {right}")
    joints = rows[:, :3].reshape(-1, len(MSR_JOINTS), 3)
    return np.where((joints != 0.0).any(-1, keepdims=True), joints, np.nan)


def _nearest_unit(ratio_m: float) -> float:
    """The unit whose ratio to this one, metres per unit, is the least."""
    units_m = METRES_PER_MILLIMETRE * np.array(UNITS_MM)
    return float(units_m[np.argmin(np.abs(np.log(units_m / ratio_m)))])


def _placed(joints: NDArray[np.float64], recording: MsrAction3dRecording) -> NDArray[np.float64]:
    """[F, 20, 3] in the camera frame, of joints in metres with y up."""
    ways = [joints * (sign, -1.0, 1.0) for sign in (1.0, -1.0)]
    on_person = [_share_on_person(way, recording) for way in ways]
    return ways[int(np.argmax(on_person))]


def _share_on_person(joints_camera: NDArray[np.float64], recording: MsrAction3dRecording) -> float:
    """Of the known joints, how many lie on a pixel with a reading."""
    frame, joint = np.nonzero(np.isfinite(joints_camera).all(-1))
    u, v = np.rint(project(joints_camera[frame, joint], recording.camera)).astype(int).T
    inside = (u >= 0) & (u < recording.camera.width) & (v >= 0) & (v < recording.camera.height)
    hits = recording.depth_units[frame[inside], v[inside], u[inside]] > 0
    return hits.sum() / max(len(frame), 1)


def _unprojected(rows: NDArray[np.float64], recording: MsrAction3dRecording) -> NDArray[np.float64]:
    """[F, 20, 3] in the camera frame, of columns, rows and depths in the images' unit."""
    camera: Camera = recording.camera
    u, v, z = rows[..., 0], rows[..., 1], recording.metres_per_unit * rows[..., 2]
    return np.stack([(u - camera.cx) * z / camera.fx, (v - camera.cy) * z / camera.fy, z], -1)


def find_msr_action3d(root: Path, pattern: str = "*") -> list[MsrAction3dSequence]:
    """The sequences whose names match `pattern`, by action, subject and repetition.

    Raises:
        InputError: there are no depth files, or no skeletons, or nothing matches.
    """
    depths = {
        match[0].removesuffix("_sdepth.bin"): file
        for file in _files(root, "*_sdepth.bin")
        if (match := MSR_DEPTH_FILE.fullmatch(file.name))
    }
    skeletons = {
        file.name.removesuffix(suffix): file
        for suffix in reversed(SKELETONS)
        for file in _files(root, f"*{suffix}")
    }
    missing = [
        kind
        for kind, found in (
            ("a01_s01_e01_sdepth.bin", depths),
            ("a01_s01_e01_skeleton3D.txt or ..._skeleton.txt", skeletons),
        )
        if not found
    ]
    if missing:
        raise InputError(
            f"{root} lacks {' and '.join(missing)}; it must be MSR Action3D's folder, with these "
            "in it or in folders of it"
        )
    names = sorted(depths, key=lambda name: [int(n) for n in re.findall(r"\d+", name)])
    sequences = [
        MsrAction3dSequence(name, depths[name], skeletons.get(name, _expected(depths[name])))
        for name in names
    ]
    return select_by_name(sequences, pattern, str(root))


def _files(root: Path, pattern: str) -> list[Path]:
    return sorted([*root.glob(pattern), *root.glob(f"*/{pattern}")])


def _expected(depth: Path) -> Path:
    """Where a missing skeleton would lie; reading it tells that it is not there."""
    return depth.with_name(depth.name.replace("_sdepth.bin", SKELETONS[0]))
