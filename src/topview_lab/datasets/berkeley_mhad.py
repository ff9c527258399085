"""Berkeley MHAD: 12 subjects, 11 actions, 5 repetitions, Kinect 1, with motion capture.

F. Ofli, R. Chaudhry, G. Kurillo, R. Vidal and R. Bajcsy, "Berkeley MHAD: a comprehensive
multimodal human action database", WACV 2013. The published layout:

    Kinect/Kin01/S01/A04/R01/kin_k01_s01_a04_r01_depth_00000.pgm, ..._color_00000.ppm
    Kinect/Correspondences/corr_moc_kin01_s01_a04_r01.txt
    Calibration/camcfg_k01.yml, Calibration/RwTw_k01.txt
    Mocap/SkeletalData/skl_s01_a04_r01.bvh

As in the authors' own example, the skeleton's unit is centimetres, y points up, and row t of the
correspondences is depth frame t, its third number the frame of the motion capture, from 0.
Decided by us: the head is the middle of the skeleton's head joint and its end site, as a hand is of
the wrist and its end site; the spine's third joint is our torso joint.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.files import naming, read_text
from topview.io.readers.berkeley_mhad import BerkeleyMhadRecording, read_world_pose
from topview.records import InputError
from topview_lab.datasets.base import lacking, select_by_name
from topview_lab.datasets.bvh import END_SITE, read_bvh
from topview_lab.metrics import ReferenceSequence

METRES_PER_UNIT: Final = 0.01
# Our joint and the joints of the skeleton whose middle it is.
MHAD_JOINTS: Final[dict[str, tuple[str, ...]]] = {
    "head": ("Head", "Head" + END_SITE),
    "neck": ("Neck",),
    "torso": ("spine1",),
    "pelvis": ("Hips",),
    **{
        f"{side.lower()}_{ours}": tuple(side + theirs for theirs in names)
        for side in ("Left", "Right")
        for ours, names in {
            "shoulder": ("Arm",),
            "elbow": ("ForeArm",),
            "hand": ("Hand", "Hand" + END_SITE),
            "hip": ("UpLeg",),
            "knee": ("Leg",),
            "ankle": ("Foot",),
        }.items()
    },
}
MHAD_ACTION_NAMES: Final = (
    "jumping_in_place", "jumping_jacks", "bending", "punching", "waving_two_hands",
    "waving_one_hand", "clapping", "throwing", "sit_down_stand_up", "sit_down", "stand_up",
)  # fmt: skip
"""A01 to A11."""


@dataclass(frozen=True, slots=True)
class BerkeleyMhadSequence:
    """One sequence: subject, action, repetition.

    Attributes:
        root: folder that holds `Kinect`, `Calibration` and `Mocap`.
        name: such as `s01_a04_r01`.
    """

    root: Path
    name: str

    def open(self) -> BerkeleyMhadRecording:
        """The frames that have a correspondence."""
        subject, action, repetition = self.name.upper().split("_")
        folder = self.root / "Kinect/Kin01" / subject / action / repetition
        return BerkeleyMhadRecording(folder, len(self._mocap_frames()))

    def _mocap_frames(self) -> NDArray[np.int64]:
        return read_correspondences(
            self.root / "Kinect/Correspondences" / f"corr_moc_kin01_{self.name}.txt"
        )

    def reference(self) -> ReferenceSequence:
        """The skeleton of the motion capture at the depth frames, told in the Kinect's frame."""
        frame_index = np.array(self.open().indices)
        mocap_frames = self._mocap_frames()[frame_index]
        path = self.root / "Mocap/SkeletalData" / f"skl_{self.name}.bvh"
        motion = read_bvh(path)
        if mocap_frames.max() >= len(motion):
            raise InputError(
                f"{path}: has {len(motion)} frames; it must have frame {mocap_frames.max()}, "
                f"as corr_moc_kin01_{self.name}.txt says"
            )
        positions = {name.lower(): p for name, p in motion.positions(mocap_frames).items()}
        lacks = [names[0] for names in MHAD_JOINTS.values() if names[0].lower() not in positions]
        if lacks:
            raise InputError(
                f"{path}: has no joints {', '.join(lacks)} (it has "
                f"{', '.join(node.name for node in motion.nodes)}); it must have them all"
            )
        joints_world = METRES_PER_UNIT * np.stack(
            [
                np.mean([positions[n.lower()] for n in names if n.lower() in positions], axis=0)
                for names in MHAD_JOINTS.values()
            ],
            axis=1,
        )
        T = read_world_pose(self.root / "Calibration/RwTw_k01.txt")
        F, action = len(mocap_frames), int(self.name[5:7])
        return ReferenceSequence(
            frame_index=frame_index,
            person_ids=np.array([1]),
            joint_names=tuple(MHAD_JOINTS),
            joints_camera=(joints_world @ T[:3, :3].T + T[:3, 3])[:, None],
            present=np.ones((F, 1), bool),
            actions=np.full(
                (F, 1), MHAD_ACTION_NAMES[action - 1] if action <= len(MHAD_ACTION_NAMES) else ""
            ),
            bodies=(f"subject {self.name[1:3]}",),
        )


def read_correspondences(path: Path) -> NDArray[np.int64]:
    """[F] the frame of the motion capture for each depth frame, from 0.

    Raises:
        InputError: missing, or not rows of three numbers.
    """
    right = "it must have rows of three numbers, the last the frame of the motion capture"
    with naming(path, right=right):
        lines = read_text(path, right=right).splitlines()
        try:
            rows = [line.split() for line in lines if line.strip()]
            frames = np.array([float(row[2]) for row in rows])
        except (ValueError, IndexError) as error:
            raise InputError(f"is damaged ({error}); {right}") from None
        if not len(frames) or not np.isfinite(frames).all() or (frames < 0.0).any():
            raise InputError(f"has no frames, or negative ones; {right}")
        return frames.astype(np.int64)


def find_berkeley_mhad(root: Path, pattern: str = "*") -> list[BerkeleyMhadSequence]:
    """The sequences of Kinect 1 whose names match `pattern`, by subject, action and repetition.

    Raises:
        InputError: the folder is not Berkeley MHAD's, naming all that it lacks, or nothing matches.
    """
    folders = sorted((root / "Kinect/Kin01").glob("S*/A*/R*"))
    names = ["_".join(folder.parts[-3:]).lower() for folder in folders if folder.is_dir()]
    names = [name for name in names if re.fullmatch(r"s\d\d_a\d\d_r\d\d", name)]
    missing = lacking(
        root,
        {
            "Calibration/camcfg_k01.yml": "Calibration/camcfg_k01.yml",
            "Calibration/RwTw_k01.txt": "Calibration/RwTw_k01.txt",
            "Kinect/Correspondences": "Kinect/Correspondences/corr_moc_kin01_s*_a*_r*.txt",
            "Mocap/SkeletalData": "Mocap/SkeletalData/skl_s*_a*_r*.bvh",
        },
    )
    if not names:
        missing.insert(0, "Kinect/Kin01/S01/A01/R01")
    if missing:
        raise InputError(
            f"{root} lacks {', '.join(missing)}; it must be Berkeley MHAD's folder, with Kinect, "
            "Calibration and Mocap in it"
        )
    sequences = [BerkeleyMhadSequence(root, name) for name in names]
    return select_by_name(sequences, pattern, str(root))
