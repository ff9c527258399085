"""Berkeley MHAD, on a tiny folder in its published layout."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from topview.body import JOINT_NAMES
from topview.evaluate.datasets import find_berkeley_mhad
from topview.evaluate.run import run_evaluation
from topview.io import open_recording
from topview.records import InputError
from topview.track.settings import TrackerSettings

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


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "BerkeleyMHAD"
    write_sequence(root, "s01_a04_r01", [0, 1, 2, 3])
    write_sequence(root, "s02_a01_r05", [0, 1, 3])
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
    return root


def test_sequences(root: Path) -> None:
    assert [s.name for s in find_berkeley_mhad(root)] == ["s01_a04_r01", "s02_a01_r05"]
    assert [s.name for s in find_berkeley_mhad(root, "s02_*")] == ["s02_a01_r05"]
    with pytest.raises(InputError, match="no sequence matches 's12"):
        find_berkeley_mhad(root, "s12_*")


def test_frames(root: Path) -> None:
    recording = find_berkeley_mhad(root)[0].open()
    frames = list(recording)
    assert [frame.index for frame in frames] == [0, 1, 2, 3]
    assert len(recording) == 4
    camera = recording.camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (10.0, 11.0, 4.0, 3.0)
    assert frames[2].depth_m[0, 0] == pytest.approx(2.002)
    assert frames[2].color is not None
    assert frames[2].color[0, 0].tolist() == [2, 2, 2]
    assert frames[3].timestamp_s == pytest.approx(0.1)
    assert recording.problems == []


def test_a_sequence_can_be_opened_by_its_folder(root: Path) -> None:
    recording = open_recording(root / "Kinect" / "Kin01" / "S01" / "A04" / "R01")
    assert recording.name == "s01_a04_r01"
    assert len(list(recording)) == 4


def test_the_skeleton_in_the_frame_of_the_kinect(root: Path) -> None:
    reference = find_berkeley_mhad(root)[0].reference()
    assert set(reference.joint_names) == set(JOINT_NAMES)
    at = dict(zip(reference.joint_names, reference.joints_camera[2, 0], strict=True))

    def expected(x_cm: float, y_cm: float, z_cm: float) -> np.ndarray:
        # At depth frame 2, motion capture frame 32, the person stands at x = 32 cm.
        world_mm = 10.0 * np.array([32.0 + x_cm, y_cm, z_cm])
        return (R_WORLD_TO_CAMERA @ world_mm + SHIFT_MM) / 1000.0

    assert at["pelvis"] == pytest.approx(expected(0, 90, 0))
    assert at["torso"] == pytest.approx(expected(0, 107, 0))
    assert at["neck"] == pytest.approx(expected(0, 136, 0))
    assert at["head"] == pytest.approx(expected(0, 154, 0))
    assert at["left_shoulder"] == pytest.approx(expected(17, 130, 0))
    assert at["left_elbow"] == pytest.approx(expected(17, 102, 0))
    assert at["left_hand"] == pytest.approx(expected(17, 67, 0))
    assert at["right_hip"] == pytest.approx(expected(-9, 90, 0))
    assert at["right_ankle"] == pytest.approx(expected(-9, 10, 0))
    assert reference.actions is not None
    assert reference.actions[0, 0] == "punching"
    assert reference.bodies == ("subject 01",)


def test_gaps_in_the_frames_are_no_error(root: Path) -> None:
    sequence = find_berkeley_mhad(root)[1]
    assert [frame.index for frame in sequence.open()] == [0, 1, 3]
    reference = sequence.reference()
    assert reference.frame_index.tolist() == [0, 1, 3]
    x = reference.joints_camera[:, 0, reference.joint_names.index("pelvis"), 2]
    assert x == pytest.approx(3.0 - np.array([0, 0.16, 0.48]))


def test_frames_without_a_correspondence_are_left_out(root: Path) -> None:
    folder = root / "Kinect" / "Kin01" / "S01" / "A04" / "R01"
    for kind in ("depth_{}.pgm", "color_{}.ppm"):
        file = "kin_k01_s01_a04_r01_" + kind
        shutil.copy(folder / file.format("00003"), folder / file.format("00004"))
    sequence = find_berkeley_mhad(root)[0]
    assert len(sequence.open()) == 4
    assert len(sequence.reference().frame_index) == 4


def test_all_that_is_missing_is_named_at_once(root: Path) -> None:
    shutil.rmtree(root / "Calibration")
    shutil.rmtree(root / "Mocap")
    with pytest.raises(InputError) as error:
        find_berkeley_mhad(root)
    for kind in ("Calibration/camcfg_k01.yml", "Calibration/RwTw_k01.txt", "Mocap/SkeletalData"):
        assert kind in str(error.value)
    assert "Correspondences" not in str(error.value)
    assert "\n" not in str(error.value)


def test_an_empty_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"lacks Kinect/Kin01/S01/A01/R01, Calibration/camcfg"):
        find_berkeley_mhad(tmp_path)


CALIBRATION, CORR = "Calibration", "Kinect/Correspondences/corr_moc_kin01_s01_a04_r01.txt"
BVH = "Mocap/SkeletalData/skl_s01_a04_r01.bvh"


@pytest.mark.parametrize(
    ("file", "damage", "message"),
    [
        (CORR, lambda t: "", "has no frames"),
        (CORR, lambda t: "0 1\n", "is damaged"),
        (CORR, lambda t: t.replace(" 48", " 480"), "has 49 frames; it must have frame 480"),
        (BVH, lambda t: t[:400], "BVH file"),
        (BVH, lambda t: t.replace("LeftForeArm", "Flipper"), "has no joints LeftForeArm"),
        (f"{CALIBRATION}/RwTw_k01.txt", lambda t: "Rw=1 2 3", "has 3 numbers"),
        (f"{CALIBRATION}/RwTw_k01.txt", lambda t: t.replace("-1.0", "-1.2"), "no rotation"),
        (f"{CALIBRATION}/RwTw_k01.txt", lambda t: t.replace("-1.0", "one"), "is damaged"),
        (f"{CALIBRATION}/camcfg_k01.yml", lambda t: "%YAML:1.0\nA: 1\n", "has no camera matrix"),
        (f"{CALIBRATION}/camcfg_k01.yml", lambda t: t.replace("10.,", ""), "damaged camera"),
    ],
)
def test_damaged_files_are_named(
    root: Path, file: str, damage: Callable[[str], str], message: str
) -> None:
    path = root / file
    path.write_text(damage(path.read_text()))
    sequence = find_berkeley_mhad(root)[0]
    with pytest.raises(InputError, match=message) as error:
        sequence.reference()
    assert path.name in str(error.value)
    assert "\n" not in str(error.value)


def test_a_damaged_image_loses_one_frame(root: Path) -> None:
    folder = root / "Kinect" / "Kin01" / "S01" / "A04" / "R01"
    (folder / "kin_k01_s01_a04_r01_depth_00001.pgm").write_bytes(b"P5 8 6 65535 short")
    (folder / "kin_k01_s01_a04_r01_color_00002.ppm").write_bytes(b"P5 8 6 255 short")
    recording = find_berkeley_mhad(root)[0].open()
    frames = list(recording)
    assert [frame.index for frame in frames] == [0, 2, 3]
    assert frames[1].color is None
    assert len(recording.problems) == 2


def test_a_sequence_that_cannot_be_read_does_not_lose_the_others(root: Path) -> None:
    (root / BVH).write_text("no motion")
    run = run_evaluation(find_berkeley_mhad(root), TrackerSettings(), workers=1)
    assert [s.name for s in run.evaluation.sequences] == ["s02_a01_r05"]
    assert len(run.problems) == 1
    assert run.problems[0].startswith("s01_a04_r01: ")
