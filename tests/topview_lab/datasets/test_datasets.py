from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from skeleton_sequences import (
    J,
    rendered_groundtruth,
    rendered_names,
    standing,
    write_rendered,
)
from topview.body import JOINT_NAMES, OUTPUT_JOINT_NAMES
from topview.records import InputError
from topview_lab.datasets import find_folder_recordings, find_utd_mhad, read_groundtruth
from topview_lab.datasets.joints import KINECT_V1_JOINTS, RENDERED_JOINTS, select_joints


class TestJoints:
    @pytest.mark.parametrize(
        ("names", "count"),
        [(KINECT_V1_JOINTS, 20), (RENDERED_JOINTS, 21), (OUTPUT_JOINT_NAMES, 20)],
    )
    def test_every_layout_has_all_our_joints(self, names: Any, count: int) -> None:
        names = list(names)
        joints, columns = select_joints(names, "file")
        assert len(names) == count
        assert set(joints) == set(OUTPUT_JOINT_NAMES)
        assert len(columns) == len(OUTPUT_JOINT_NAMES)

    def test_sides_stay_on_their_side(self) -> None:
        names = ["hand_r", "wrist_r", "hand_l", "left_hip", "shoulder_center"]
        joints, columns = select_joints(names, "file")
        assert joints == ("right_hand", "right_wrist", "left_hand", "left_hip", "neck")
        assert columns.tolist() == [0, 1, 2, 3, 4]

    @pytest.mark.parametrize(
        ("names", "message"),
        [
            (["head", "nose"], "file: unknown joint names nose; .*shoulder_center.*left_elbow"),
            (["hand_l", "left_hand"], "each joint must be named once"),
            (["head_top"], "give no joint"),
        ],
    )
    def test_bad_names(self, names: list[str], message: str) -> None:
        with pytest.raises(InputError, match=message):
            select_joints(names, "file")


def groundtruth(path: Path, **arrays: Any) -> Path:
    np.savez(path / "groundtruth.npz", **arrays)
    return path / "groundtruth.npz"


class TestGroundtruth:
    def test_rendered_layout(self, tmp_path: Path) -> None:
        hidden = np.zeros((2, 1, J), np.float32)
        hidden[1, 0, 3] = 0.5
        arrays = rendered_groundtruth([2.0, 3.0], joint_occ_person=hidden, ids=np.array([7]))
        reference = read_groundtruth(groundtruth(tmp_path, **arrays))
        assert reference.joint_names == JOINT_NAMES
        assert reference.person_ids.tolist() == [7]
        assert reference.joints_camera[1, 0] == pytest.approx(standing(z_m=3.0), abs=1e-6)
        assert reference.occluded_by_person is not None
        assert reference.occluded_by_person[1, 0, 3] == 0.5
        assert reference.statures_m == pytest.approx([1.7])

    def test_composite_layout_has_the_other_axis_order(self, tmp_path: Path) -> None:
        joints = np.zeros((2, 3, 20, 3), np.float32)
        joints[1, 2, 11] = (1.0, 2.0, 3.0)  # person 2, frame 2, right hand
        not_behind = np.ones((2, 3, 20), bool)
        not_behind[1, 2, 11] = False
        path = groundtruth(
            tmp_path,
            joint_names=np.array(list(KINECT_V1_JOINTS)),
            joints=joints,
            joint_not_behind_other=not_behind,
        )
        reference = read_groundtruth(path)
        hand = reference.joint_names.index("right_hand")
        assert reference.joints_camera[2, 1, hand].tolist() == [1.0, 2.0, 3.0]
        assert reference.present.all()
        assert reference.occluded_by_person is not None
        assert np.argwhere(reference.occluded_by_person).tolist() == [[2, 1, hand]]

    def test_a_board_is_no_person(self, tmp_path: Path) -> None:
        path = groundtruth(
            tmp_path,
            joint_names=np.array(list(KINECT_V1_JOINTS)),
            joints=np.zeros((1, 3, 20, 3)),
            joint_not_behind_other=np.zeros((1, 3, 20), bool),
        )
        assert read_groundtruth(path).occluded_by_person is None

    def test_people_who_are_absent_may_be_nan(self, tmp_path: Path) -> None:
        arrays = rendered_groundtruth([2.0, 3.0])
        arrays["joints"][1] = np.nan
        arrays["present"][1] = False
        assert read_groundtruth(groundtruth(tmp_path, **arrays)).present.tolist() == [
            [True],
            [False],
        ]

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"present": None}, "lacks present; it has .*; it must have|lacks present; it has"),
            ({"joints": None}, "lacks joints"),
            ({"names": None}, "has the keys .*; it must have names, joints"),
            ({"joints": np.zeros((2, J, 3))}, r"joints is float64 \(2, 16, 3\); it must be"),
            ({"joints": np.zeros((2, 1, J + 1, 3))}, "the last two 16"),
            ({"present": np.ones((5, 1), bool)}, r"present has shape \(5, 1\); .* \(2, 1\)"),
            ({"joint_occ_person": np.zeros((1, 1, J))}, "joint_occ_person has shape"),
            ({"names": np.array([*rendered_names()[:-1], "tail"])}, "unknown joint names tail"),
            (
                {"joints": np.full((2, 1, J, 3), np.nan)},
                "for head of person 1 in frame 0; .* must be finite",
            ),
        ],
    )
    def test_bad_content(self, tmp_path: Path, change: dict[str, Any], message: str) -> None:
        arrays = rendered_groundtruth([2.0, 3.0], **change)
        path = groundtruth(tmp_path, **{k: a for k, a in arrays.items() if a is not None})
        with pytest.raises(InputError, match=message) as error:
            read_groundtruth(path)
        assert str(path) in str(error.value)
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize("content", [b"", b"not an archive", b"PK\x03\x04 cut off"])
    def test_damaged_file(self, tmp_path: Path, content: bytes) -> None:
        path = tmp_path / "groundtruth.npz"
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"groundtruth\.npz: is truncated or damaged") as error:
            read_groundtruth(path)
        assert "\n" not in str(error.value)

    def test_truncated_file(self, tmp_path: Path) -> None:
        path = groundtruth(tmp_path, **rendered_groundtruth([2.0] * 50))
        whole = path.read_bytes()
        for size in range(0, len(whole), len(whole) // 40):
            path.write_bytes(whole[:size])
            with pytest.raises(InputError, match="is truncated or damaged"):
                read_groundtruth(path)

    def test_missing_file(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="No such file"):
            read_groundtruth(tmp_path / "groundtruth.npz")


class TestFolders:
    def test_one_recording_or_a_folder_of_them(self, tmp_path: Path) -> None:
        for name in ("b", "a", "c"):
            write_rendered(tmp_path / "set" / name, [2.0])
        (tmp_path / "set" / "no_truth").mkdir()
        found = find_folder_recordings([tmp_path / "set" / "c", tmp_path / "set"])
        assert [recording.name for recording in found] == ["c", "a", "b", "c"]
        found = find_folder_recordings([tmp_path / "set"], "a, [c-d]")
        assert [recording.name for recording in found] == ["a", "c"]
        assert found[0].open().frame_count == 1
        assert len(found[0].reference().frame_index) == 1

    def test_nothing_there(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="is not a folder"):
            find_folder_recordings([tmp_path / "missing"])
        with pytest.raises(InputError, match=r"no groundtruth\.npz in it"):
            find_folder_recordings([tmp_path])
        write_rendered(tmp_path / "a", [2.0])
        with pytest.raises(InputError, match=r"no sequence matches 'x\*'; there are 1, a to a"):
            find_folder_recordings([tmp_path], "x*")


class TestUtdMhad:
    @pytest.fixture
    def root(self, tmp_path: Path) -> Path:
        """Three sequences of four frames, in which the person moves 10 cm a frame."""
        (tmp_path / "Depth").mkdir()
        (tmp_path / "Skeleton").mkdir()
        skeleton = np.zeros((20, 3, 4))
        skeleton[:, 0] = np.arange(4) * 0.1
        skeleton[:, 1] = 0.5
        skeleton[:, 2] = 2.0
        for name in ("a10_s1_t1", "a2_s1_t1", "a2_s1_t2"):
            depth = np.full((240, 320, 4), 2000, np.uint16)
            savemat(tmp_path / "Depth" / f"{name}_depth.mat", {"d_depth": depth})
            savemat(tmp_path / "Skeleton" / f"{name}_skeleton.mat", {"d_skel": skeleton})
        return tmp_path

    def test_sequences_come_in_the_order_of_their_numbers(self, root: Path) -> None:
        names = [recording.name for recording in find_utd_mhad(root)]
        assert names == ["a2_s1_t1", "a2_s1_t2", "a10_s1_t1"]

    def test_patterns(self, root: Path) -> None:
        names = [recording.name for recording in find_utd_mhad(root, "a10_*,a*_s1_t2")]
        assert names == ["a2_s1_t2", "a10_s1_t1"]
        with pytest.raises(InputError, match="no sequence matches 'a9'; there are 3, a2_s1_t1 to"):
            find_utd_mhad(root, "a9")

    def test_frames_before_the_first_sample_have_no_reference(self, root: Path) -> None:
        recording = find_utd_mhad(root)[0]
        assert recording.open().frame_count == 4
        reference = recording.reference()
        assert set(reference.joint_names) == set(OUTPUT_JOINT_NAMES)
        assert reference.frame_index.tolist() == [2, 3]
        assert reference.actions is not None
        assert reference.actions.tolist() == [["a2"], ["a2"]]
        assert reference.bodies == ("subject 1",)
        # Depth frame t goes with sample t - 1.5, mirrored, y down.
        assert reference.joints_camera[0, 0, 0] == pytest.approx((-0.05, -0.5, 2.0))

    def test_another_folder(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="lacks the folder Depth and Skeleton; UTD-MHAD has"):
            find_utd_mhad(tmp_path)
        (tmp_path / "Depth").mkdir()
        (tmp_path / "Skeleton").mkdir()
        with pytest.raises(InputError, match="no file is named"):
            find_utd_mhad(tmp_path)


class TestRealData:
    def test_rendered_recordings(self, shared: Path) -> None:
        recordings = find_folder_recordings([shared / "bench"])
        assert len(recordings) == 11
        for recording in recordings:
            reference = recording.reference()
            assert set(reference.joint_names) == set(OUTPUT_JOINT_NAMES)
            assert recording.open().frame_count == len(reference.frame_index)

    def test_composites(self, shared: Path) -> None:
        recordings = find_folder_recordings([shared / "recordings" / "composites"])
        people = {r.name: len(r.reference().person_ids) for r in recordings}
        assert people == {"box_sweep": 1, "cross_behind": 2, "side_by_side_partial": 2}

    def test_utd_mhad(self, shared: Path) -> None:
        recordings = find_utd_mhad(shared / "recordings" / "utd_mhad")
        assert len(recordings) == 216
        reference = recordings[0].reference()
        left, right = (reference.joint_names.index(f"{s}_shoulder") for s in ("left", "right"))
        # Facing the camera, the person's left is at the image's right.
        x = reference.joints_camera[:, 0, :, 0]
        assert (x[:, left] > x[:, right]).all()
