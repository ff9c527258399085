"""Berkeley MHAD, on a tiny folder in its published layout."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tiny_berkeley_mhad import (
    R_WORLD_TO_CAMERA,
    SHIFT_MM,
    write_calibration,
    write_sequence,
)
from topview.body import JOINT_NAMES
from topview.io import open_recording
from topview.records import InputError
from topview.track.settings import TrackerSettings
from topview_lab.datasets import find_berkeley_mhad
from topview_lab.evaluate.run import run_evaluation


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "BerkeleyMHAD"
    write_sequence(root, "s01_a04_r01", [0, 1, 2, 3])
    write_sequence(root, "s02_a01_r05", [0, 1, 3])
    write_calibration(root)
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
    assert recording.frame_count == 4
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
    assert sequence.open().frame_count == 4
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
        (f"{CALIBRATION}/RwTw_k01.txt", lambda t: t.replace("-1.0", "1e300"), "no rotation"),
        (f"{CALIBRATION}/RwTw_k01.txt", lambda t: t.replace("3000.0", "1e300"), "a shift of up to"),
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
