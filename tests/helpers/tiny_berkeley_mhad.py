"""Berkeley MHAD as a tiny folder in its published layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np

W, H = 8, 6
R_WORLD_TO_CAMERA = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
SHIFT_MM = np.array([100.0, 900.0, 3000.0])

# Node, parent, offset in cm; hands and head end in end sites.
SKELETON = (
    ("Hips", "", (0, 90, 0)), ("spine", "Hips", (0, 8, 0)), ("spine1", "spine", (0, 9, 0)),
    ("spine2", "spine1", (0, 9, 0)), ("Neck", "spine2", (0, 20, 0)), ("Head", "Neck", (0, 8, 0)),
    *(
        (side + name, parent if parent in ("spine2", "Hips") else side + parent, (sign * x, y, z))
        for side, sign in (("Right", -1), ("Left", 1))
        for name, parent, (x, y, z) in (
            ("Shoulder", "spine2", (3, 12, 0)), ("Arm", "Shoulder", (14, 2, 0)),
            ("ArmRoll", "Arm", (0, -14, 0)), ("ForeArm", "ArmRoll", (0, -14, 0)),
            ("ForeArmRoll", "ForeArm", (0, -13, 0)), ("Hand", "ForeArmRoll", (0, -13, 0)),
            ("UpLeg", "Hips", (9, 0, 0)), ("UpLegRoll", "UpLeg", (0, -20, 0)),
            ("Leg", "UpLegRoll", (0, -20, 0)), ("LegRoll", "Leg", (0, -20, 0)),
            ("Foot", "LegRoll", (0, -20, 0)), ("ToeBase", "Foot", (0, -6, 12)),
        )
    ),
)  # fmt: skip
END_SITES = {"Head": (0, 20, 0), "RightHand": (0, -18, 0), "LeftHand": (0, -18, 0)}


def bvh(frames: int) -> str:
    """Somebody who stands upright at x = frame, in cm."""

    def node(name: str) -> str:
        offset = next(offset for n, _, offset in SKELETON if n == name)
        is_root = name == "Hips"
        shift = "Xposition Yposition Zposition " if is_root else ""
        inside = "".join(node(n) for n, parent, _ in SKELETON if parent == name)
        if name in END_SITES:
            inside += f"End Site {{ OFFSET {numbers(END_SITES[name])} }} "
        return (
            f"{'ROOT' if is_root else 'JOINT'} {name} {{ "
            f"OFFSET {numbers((0, 0, 0) if is_root else offset)} "
            f"CHANNELS {6 if is_root else 3} {shift}Zrotation Xrotation Yrotation {inside}}} "
        )

    rows = "\n".join(
        " ".join(map(str, [f, 90, 0, *np.zeros(3 * len(SKELETON))])) for f in range(frames)
    )
    return f"HIERARCHY {node('Hips')} MOTION\nFrames: {frames}\nFrame Time: 0.002083\n{rows}\n"


def numbers(values: object) -> str:
    return " ".join(str(float(v)) for v in np.ravel(np.asarray(values)))


def write_sequence(root: Path, name: str, depth_frames: list[int]) -> Path:
    """Depth images of 2 m and correspondences: depth frame t goes with mocap frame 16 t."""
    s, a, r = name.split("_")
    folder = root / "Kinect" / "Kin01" / s.upper() / a.upper() / r.upper()
    folder.mkdir(parents=True)
    for index in depth_frames:
        depth = np.full((H, W), 2000 + index, ">u2")
        color = np.full((H, W, 3), index, np.uint8)
        stem = f"kin_k01_{name}"
        (folder / f"{stem}_depth_{index:05d}.pgm").write_bytes(
            f"P5\n{W} {H}\n65535\n".encode() + depth.tobytes()
        )
        (folder / f"{stem}_color_{index:05d}.ppm").write_bytes(
            f"P6\n{W} {H}\n255\n".encode() + color.tobytes()
        )
    correspondences = root / "Kinect" / "Correspondences"
    correspondences.mkdir(exist_ok=True)
    (correspondences / f"corr_moc_kin01_{name}.txt").write_text(
        "".join(f"{t:03d} {1e9 + t} {16 * t}\n" for t in range(4))
    )
    (root / "Mocap" / "SkeletalData").mkdir(parents=True, exist_ok=True)
    (root / "Mocap" / "SkeletalData" / f"skl_{name}.bvh").write_text(bvh(49))
    return folder


def write_calibration(root: Path) -> None:
    """Of Kinect 1."""
    calibration = root / "Calibration"
    calibration.mkdir()
    (calibration / "camcfg_k01.yml").write_text(
        "%YAML:1.0\nCamera_1:\n   imgWidth: 640\n   imgHeight: 480\n   K: !!opencv-matrix\n"
        "      rows: 3\n      cols: 3\n      dt: f\n"
        "      data: [ 10., 0., 4., 0., 11., 3., 0., 0., 1. ]\n"
    )
    (calibration / "RwTw_k01.txt").write_text(
        f"Rw={numbers(R_WORLD_TO_CAMERA)}\nTw={numbers(SHIFT_MM)}\n"
    )
