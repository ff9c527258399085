"""UTD-MHAD: one person, 27 actions, with the skeletons of the Kinect SDK v1.

Chen, Jafari & Kehtarnavaz, "UTD-MHAD: a multimodal dataset for human action recognition utilizing
a depth camera and a wearable inertial sensor", ICIP 2015. The SDK's skeleton is a reference, not
truth: its bone lengths wander by 1 to 2 cm.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from topview.io.readers import open_recording, read_utd_skeleton
from topview.records import InputError, Recording
from topview_lab.datasets.base import select_by_name
from topview_lab.datasets.joints import select_joints
from topview_lab.metrics import ReferenceSequence

UTD_DEPTH_FILE: Final = re.compile(r"a(\d+)_s(\d+)_t(\d+)_depth\.mat")


@dataclass(frozen=True, slots=True)
class UtdMhadRecording:
    """One sequence: action, subject, trial.

    Attributes:
        root: folder that holds `Depth` and `Skeleton`.
        name: such as `a1_s1_t1`.
    """

    root: Path
    name: str

    def open(self) -> Recording:
        return open_recording(self.root / "Depth" / f"{self.name}_depth.mat")

    def reference(self) -> ReferenceSequence:
        """The SDK's skeleton, without the frames that it does not reach."""
        path = self.root / "Skeleton" / f"{self.name}_skeleton.mat"
        names, joints_camera = read_utd_skeleton(path)
        joint_names, columns = select_joints(names, str(path))
        joints_camera = joints_camera[:, columns]
        known = np.isfinite(joints_camera).all((1, 2))
        action, subject, _ = self.name.split("_")
        return ReferenceSequence(
            frame_index=np.flatnonzero(known),
            person_ids=np.array([1]),
            joint_names=joint_names,
            joints_camera=joints_camera[known, None],
            present=np.ones((int(known.sum()), 1), bool),
            actions=np.full((int(known.sum()), 1), action),
            bodies=(f"subject {subject[1:]}",),
        )


def find_utd_mhad(root: Path, pattern: str = "*") -> list[UtdMhadRecording]:
    """The sequences whose names match `pattern`, by action, subject and trial.

    Raises:
        InputError: the folder is not UTD-MHAD's, or nothing matches.
    """
    if missing := [name for name in ("Depth", "Skeleton") if not (root / name).is_dir()]:
        raise InputError(
            f"{root} lacks the folder {' and '.join(missing)}; UTD-MHAD has "
            "Depth/aA_sS_tT_depth.mat and Skeleton/aA_sS_tT_skeleton.mat"
        )
    found = [
        match for file in (root / "Depth").iterdir() if (match := UTD_DEPTH_FILE.match(file.name))
    ]
    if not found:
        raise InputError(
            f"{root / 'Depth'}: no file is named aA_sS_tT_depth.mat, as UTD-MHAD's are"
        )
    found.sort(key=lambda match: [int(number) for number in match.groups()])
    recordings = [UtdMhadRecording(root, match[0].removesuffix("_depth.mat")) for match in found]
    return select_by_name(recordings, pattern, str(root))
