"""Skeletons from files: any system's names, missing things, and what is refused."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skeleton_sequences import (
    people_standing,
    predicted_of,
    reference_of,
    standing,
    write_rendered,
)
from topview.body import JOINT_NAMES, OUTPUT_JOINT_NAMES, PART_NAMES
from topview.io import write_skeletons_npz
from topview.records import InputError, JointState
from topview.skeletons import SkeletonSequence
from topview_lab.cli.evaluate import evaluate
from topview_lab.datasets import find_folder_recordings
from topview_lab.evaluate.part_frames import rotations_from_joints, statures_from_joints
from topview_lab.evaluate.predictions import PredictedJob, Predictions, read_predictions
from topview_lab.evaluate.skeleton_files import read_arrays
from topview_lab.evaluate.vocabulary import canonical, find_joints
from topview_lab.metrics import evaluate_sequence, summarise
from topview_lab.sim import GroundTruth, scene_by_name, simulate_truth

MEDIAPIPE = (
    "nose", "left_eye_inner", "left_eye", "left_eye_outer", "right_eye_inner", "right_eye",
    "right_eye_outer", "left_ear", "right_ear", "mouth_left", "mouth_right", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_pinky",
    "right_pinky", "left_index", "right_index", "left_thumb", "right_thumb", "left_hip",
    "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle", "left_heel",
    "right_heel", "left_foot_index", "right_foot_index",
)  # fmt: skip
OPENPOSE = (
    "Nose", "Neck", "RShoulder", "RElbow", "RWrist", "LShoulder", "LElbow", "LWrist", "MidHip",
    "RHip", "RKnee", "RAnkle", "LHip", "LKnee", "LAnkle", "REye", "LEye", "REar", "LEar",
    "LBigToe", "LSmallToe", "LHeel", "RBigToe", "RSmallToe", "RHeel",
)  # fmt: skip
KINECT_V2 = (
    "SpineBase", "SpineMid", "Neck", "Head", "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft",
    "ShoulderRight", "ElbowRight", "WristRight", "HandRight", "HipLeft", "KneeLeft", "AnkleLeft",
    "FootLeft", "HipRight", "KneeRight", "AnkleRight", "FootRight", "SpineShoulder", "HandTipLeft",
    "ThumbLeft", "HandTipRight", "ThumbRight",
)  # fmt: skip
AZURE = (
    "PELVIS", "SPINE_NAVEL", "SPINE_CHEST", "NECK", "CLAVICLE_LEFT", "SHOULDER_LEFT", "ELBOW_LEFT",
    "WRIST_LEFT", "HAND_LEFT", "HANDTIP_LEFT", "THUMB_LEFT", "CLAVICLE_RIGHT", "SHOULDER_RIGHT",
    "ELBOW_RIGHT", "WRIST_RIGHT", "HAND_RIGHT", "HANDTIP_RIGHT", "THUMB_RIGHT", "HIP_LEFT",
    "KNEE_LEFT", "ANKLE_LEFT", "FOOT_LEFT", "HIP_RIGHT", "KNEE_RIGHT", "ANKLE_RIGHT", "FOOT_RIGHT",
    "HEAD", "NOSE", "EYE_LEFT", "EAR_LEFT", "EYE_RIGHT", "EAR_RIGHT",
)  # fmt: skip
SMPL = (
    "Pelvis", "L_Hip", "R_Hip", "Spine1", "L_Knee", "R_Knee", "Spine2", "L_Ankle", "R_Ankle",
    "Spine3", "L_Foot", "R_Foot", "Neck", "L_Collar", "R_Collar", "Head", "L_Shoulder",
    "R_Shoulder", "L_Elbow", "R_Elbow", "L_Wrist", "R_Wrist", "L_Hand", "R_Hand",
)  # fmt: skip
KINECT_V1 = ("ShoulderCenter", "HipCenter", "Spine", "Head", "HandLeft", "shoulder_right")
COCO = (
    "nose", "left_eye", "right_eye", "left_ear", "right_ear",
    *(f"{side}_{joint}" for side in ("left", "right")
      for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")),
)  # fmt: skip


class TestNames:
    @pytest.mark.parametrize(
        ("names", "lacks"),
        [
            (OUTPUT_JOINT_NAMES, ()),
            (JOINT_NAMES, ("wrist", "foot")),
            (KINECT_V2, ()),
            (AZURE, ()),
            (SMPL, ()),
            (MEDIAPIPE, ("torso", "foot")),
            (OPENPOSE, ("torso", "foot")),
            (COCO, ("torso", "foot")),
        ],
    )
    def test_known_systems(self, names: tuple[str, ...], lacks: tuple[str, ...]) -> None:
        known = {name for name in OUTPUT_JOINT_NAMES if not name.endswith(lacks)}
        assert set(find_joints(names, "file")) == known

    def test_the_best_choice_comes_first(self) -> None:
        found = find_joints(KINECT_V2, "file")
        assert [KINECT_V2[k] for k in found["left_hand"]] == ["HandLeft"]
        assert [KINECT_V2[k] for k in found["neck"]] == ["Neck"]
        found = find_joints(MEDIAPIPE, "file")
        assert [MEDIAPIPE[k] for k in found["left_hand"]] == ["left_wrist"]
        assert [MEDIAPIPE[k] for k in found["neck"]] == ["left_shoulder", "right_shoulder"]
        assert [MEDIAPIPE[k] for k in found["head"]] == ["left_ear", "right_ear"]
        found = find_joints(KINECT_V1, "file")
        assert list(found) == ["head", "neck", "torso", "pelvis", "left_hand", "right_shoulder"]

    @pytest.mark.parametrize(
        "names",
        [
            (
                "LShoulder",
                "left_shoulder",
                "SHOULDER_LEFT",
                "ShoulderLeft",
                "l-shoulder",
                "shoulder.L",
            )
        ],
    )
    def test_spelling_does_not_matter(self, names: tuple[str, ...]) -> None:
        assert {canonical(name) for name in names} == {"left shoulder"}

    def test_unknown_names_are_refused_with_both_sets(self) -> None:
        with pytest.raises(InputError) as error:
            find_joints(["head", "tail", "left_paw"], "dog.npz")
        message = str(error.value)
        assert message.startswith(
            "dog.npz: unknown joint names tail, left_paw; map them with --map"
        )
        assert "theirs are head, tail, left_paw; ours are head, neck, torso" in message
        assert "\n" not in message

    def test_a_map_helps(self) -> None:
        found = find_joints(["skull", "tail", "b1"], "dog.npz", {"skull": "head", "b1": "pelvis"})
        assert found == {"head": (0,), "pelvis": (2,)}

    @pytest.mark.parametrize(
        ("names", "more", "message"),
        [
            (["head"], {"skull": "head"}, "the map names skull; give theirs=ours"),
            (["head"], {"head": "skull"}, "the map names skull; give theirs=ours"),
            (["head", "Head"], {}, "named twice"),
            (["nose", "left_eye"][1:], {}, "none of its joints is one of ours"),
        ],
    )
    def test_what_cannot_be_mapped(
        self, names: list[str], more: dict[str, str], message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            find_joints(names, "file", more)


@pytest.fixture(scope="module")
def truth() -> GroundTruth:
    return simulate_truth(scene_by_name("all_actions", seed=5, frames=60))


class TestPartFrames:
    def test_they_are_right_handed_rotations_along_the_bones(self) -> None:
        Rs = rotations_from_joints(JOINT_NAMES, standing())
        np.testing.assert_allclose(
            Rs @ np.swapaxes(Rs, -1, -2), np.tile(np.eye(3), (11, 1, 1)), atol=1e-12
        )
        np.testing.assert_allclose(np.linalg.det(Rs), 1.0)
        np.testing.assert_allclose(Rs[:, :, 1], [(0, 1, 0)] * 11, atol=1e-12)
        # Facing the camera: the person's right is the image's left.
        np.testing.assert_allclose(Rs[:, :, 0], [(-1, 0, 0)] * 11, atol=1e-12)

    @given(st.integers(0, 1000))
    def test_turning_the_body_turns_its_frames(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
        joints = standing() + rng.normal(0.0, 0.05, (16, 3))
        turned = rotations_from_joints(JOINT_NAMES, joints @ turn.T)
        np.testing.assert_allclose(
            turned, turn @ rotations_from_joints(JOINT_NAMES, joints), atol=1e-8
        )

    def test_hinges_tell_the_turn_of_bent_limbs(self) -> None:
        joints = standing()
        at = JOINT_NAMES.index
        # Both forearms to the front (to the camera), both lower legs to the back.
        for side in ("left", "right"):
            joints[at(f"{side}_hand")] = joints[at(f"{side}_elbow")] + (0, 0, -0.3)
            joints[at(f"{side}_ankle")] = joints[at(f"{side}_knee")] + (0, 0, 0.4)
        Rs = rotations_from_joints(JOINT_NAMES, joints)
        np.testing.assert_allclose(Rs[:, :, 0], [(-1, 0, 0)] * 11, atol=1e-12)
        forearm, shin = (PART_NAMES.index(n) for n in ("left_forearm", "right_lower_leg"))
        np.testing.assert_allclose(Rs[forearm, :, 1], (0, 0, -1), atol=1e-12)
        np.testing.assert_allclose(Rs[shin, :, 1], (0, 0, 1), atol=1e-12)

    def test_they_agree_with_the_simulators(self, truth: GroundTruth) -> None:
        names = [_ours(name) for name in truth.names]
        keep = [k for k, name in enumerate(names) if name in JOINT_NAMES]
        told = rotations_from_joints(
            [names[k] for k in keep], truth.joints[:, 0, keep].astype(np.float64)
        )
        for part in ("upper_torso", "lower_torso", "left_upper_leg", "right_lower_leg"):
            theirs = truth.part_names.tolist().index(
                part if "torso" in part else f"{part.split('_', 1)[1]}_{part[0]}"
            )
            true = truth.Ts_camera_part[:, 0, theirs, :3, :3]
            relative = np.swapaxes(true, -1, -2) @ told[:, PART_NAMES.index(part)]
            degrees = np.degrees(Rotation.from_matrix(relative).magnitude())
            assert np.median(degrees) < 12.0, part

    def test_statures(self, truth: GroundTruth) -> None:
        names = [_ours(name) for name in truth.names]
        joints = np.array(truth.joints, np.float64)
        joints[:20] = np.nan
        statures_m = statures_from_joints(names, joints)
        assert statures_m == pytest.approx(truth.stature, rel=0.06)
        assert np.isnan(statures_from_joints(["head", "neck"], joints[:, :, :2])).all()
        assert statures_from_joints(JOINT_NAMES, np.zeros((3, 0, 16, 3))).shape == (0,)

    def test_missing_joints_leave_their_parts_out(self) -> None:
        joints = standing()
        joints[JOINT_NAMES.index("left_hand")] = np.nan
        joints[JOINT_NAMES.index("torso")] = np.nan
        is_told = np.isfinite(rotations_from_joints(JOINT_NAMES, joints)).all((1, 2))
        assert [PART_NAMES[b] for b in np.flatnonzero(~is_told)] == ["left_forearm"]


def _ours(name: str) -> str:
    return {"l": "left_", "r": "right_"}[name[-1]] + name[:-2] if name[-2] == "_" else name


def write(path: Path, joints: NDArray[np.float64], **more: Any) -> Path:
    arrays = {"joint_names": np.array(JOINT_NAMES), "joints_camera": joints} | more
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    return path


class TestReading:
    @pytest.fixture
    def reference(self) -> Any:
        return reference_of(people_standing(4, -0.5, 0.7))

    def measured(self, predicted: SkeletonSequence, reference: Any) -> Any:
        return summarise(evaluate_sequence(predicted, reference))

    def test_joints_alone_are_enough(self, tmp_path: Path, reference: Any) -> None:
        joints = people_standing(4, -0.47, 0.73)
        summary = self.measured(
            read_predictions(write(tmp_path / "a.npz", joints), reference), reference
        )
        assert summary.joints_cm["all"]["all"].raw.mean == pytest.approx(3.0)
        assert summary.joints_cm["all"]["all"].offset_out.mean == pytest.approx(0.0, abs=1e-6)
        assert summary.recall == summary.precision == 1.0

    def test_one_person_may_have_no_axis_of_people(self, tmp_path: Path) -> None:
        reference = reference_of(people_standing(4, 0.1))
        path = write(tmp_path / "a.npz", people_standing(4, 0.1)[:, 0])
        assert self.measured(read_predictions(path, reference), reference).recall == 1.0

    def test_missing_joints_people_and_frames_are_missed(
        self, tmp_path: Path, reference: Any
    ) -> None:
        joints = people_standing(3, -0.5, 0.7)
        joints[0, 0, 2] = np.nan
        joints[0, 0, 3] = 0.0  # as some systems tell it
        joints[1, 1] = np.nan
        path = write(tmp_path / "a.npz", joints, frame_index=np.array([3, 1, 0]))
        predicted = read_predictions(path, reference)
        assert predicted.frame_index.tolist() == [0, 1, 2, 3]
        assert predicted.present.tolist() == [[True] * 2, [True, False], [False] * 2, [True] * 2]
        assert np.isnan(predicted.joints_camera[3, 0, 2:4]).all()
        assert (predicted.joint_state[3, 0, 2:4] == JointState.ABSENT).all()
        people = self.measured(predicted, reference).people
        assert people.person_frames == 8
        assert people.missed == 3
        assert people.false_person_frames == 0

    def test_nobody_at_all(self, tmp_path: Path, reference: Any) -> None:
        path = write(tmp_path / "a.npz", np.zeros((4, 0, 16, 3)))
        people = self.measured(read_predictions(path, reference), reference).people
        assert people.missed == people.person_frames == 8

    def test_our_own_files_come_back(self, tmp_path: Path, reference: Any) -> None:
        rng = np.random.default_rng(0)
        joints = people_standing(4, -0.5, 0.7)
        Ts = np.tile(np.eye(4), (4, 2, 11, 1, 1))
        turns = Rotation.from_quat(rng.normal(size=(88, 4))).as_matrix()
        Ts[..., :3, :3] = turns.reshape(4, 2, 11, 3, 3)
        joints[0, 1] = np.nan
        own = predicted_of(
            joints,
            Ts[..., :3, :3],
            person_ids=np.array([4, 9]),
            joint_state=np.where(
                np.isfinite(joints[..., 0]), rng.integers(1, 6, (4, 2, 16)), 0
            ).astype(np.uint8),
            joint_confidence=rng.uniform(0, 1, (4, 2, 16)).astype(np.float32),
            heights_m=np.array([1.7, 1.8]),
        )
        write_skeletons_npz(own, tmp_path / "skeletons.npz")
        predicted = read_predictions(tmp_path / "skeletons.npz", reference)
        for name in ("joints_camera", "joint_state", "joint_confidence", "heights_m", "person_ids",
                     "people_ids", "first_frame", "last_frame"):  # fmt: skip
            np.testing.assert_array_equal(getattr(predicted, name), getattr(own, name))
        np.testing.assert_array_equal(predicted.Ts_camera_part[..., :3, :3], Ts[..., :3, :3])

    def test_of_a_long_file_only_the_frames_of_the_reference_are_kept(self, tmp_path) -> None:
        joints = people_standing(5000, -0.5, 0.7)
        joints[..., 0] += np.arange(5000)[:, None, None] / 1000.0
        own = predicted_of(joints, person_ids=np.array([4, 9]))
        write_skeletons_npz(own, tmp_path / "skeletons.npz")
        wanted = np.array([7, 999, 1000, 4999])
        reference = reference_of(joints[wanted], frame_index=wanted)
        arrays = read_arrays(tmp_path / "skeletons.npz", wanted)
        assert arrays["Ts_camera_part"].shape[:2] == (4, 2)
        np.testing.assert_array_equal(arrays["frame_index"], wanted)
        predicted = read_predictions(tmp_path / "skeletons.npz", reference)
        np.testing.assert_array_equal(predicted.joints_camera, joints[wanted])

    @pytest.mark.parametrize(
        ("ids", "message"),
        [
            ([[1, 1]] * 4, "person_ids has 1 twice in frame 0; each person must be there once"),
            ([3, 3], "person_ids has 3 twice; each person must be told once"),
            ([1, 2, 3], r"person_ids is int64 \(3,\); it must be whole numbers, \(2,\) of columns"),
        ],
    )
    def test_the_same_person_twice_is_refused(self, tmp_path, reference, ids, message) -> None:
        path = write(tmp_path / "a.npz", people_standing(4, 0.0, 1.0), person_ids=np.array(ids))
        with pytest.raises(InputError, match=message):
            read_predictions(path, reference)

    def test_others_may_count_people_from_0(self, tmp_path, reference) -> None:
        joints = people_standing(4, -0.5, 0.7)
        path = write(tmp_path / "a.npz", joints, person_ids=np.array([0, 1]))
        assert read_predictions(path, reference).present.all()

    def test_a_file_of_a_later_version_is_refused_in_one_line(self, tmp_path, reference) -> None:
        path = write(tmp_path / "a.npz", people_standing(4, 0.0), format_version=np.array(4))
        with pytest.raises(
            InputError, match=r"a\.npz: format_version is 4, which a later"
        ) as error:
            read_predictions(path, reference)
        assert "\n" not in str(error.value)

    def test_other_systems_joints(self, tmp_path: Path) -> None:
        reference = reference_of(people_standing(2, 0.0))
        at = dict(zip(JOINT_NAMES, standing(), strict=True))
        at |= {f"{side}_wrist": at[f"{side}_hand"] for side in ("left", "right")}
        found = find_joints(MEDIAPIPE, "")
        joints = np.zeros((2, 33, 3))
        for joint, columns in found.items():
            if len(columns) == 1:
                joints[:, columns[0]] = at[joint]
        joints[:, 7:9] = at["head"] + np.array([[0.08, 0, 0], [-0.08, 0, 0]])
        path = write(tmp_path / "a.npz", joints, joint_names=np.array(MEDIAPIPE))
        predicted = read_predictions(path, reference)
        assert predicted.joints_camera[0, 0, 0] == pytest.approx(at["head"])
        assert "torso" not in predicted.joint_names
        assert self.measured(predicted, reference).recall == 1.0

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"joint_names": None}, "has no joint_names"),
            ({"joints_camera": np.zeros((4, 2, 15, 3))}, "frames x people x 16"),
            ({"joints_camera": people_standing(3, 0.0)}, "has 3 frames, the reference 4"),
            ({"joints_camera": 1000 * people_standing(4, 0.0)}, "reaches 2500; it must be metres"),
            ({"frame_index": np.array([0, 1, 1, 2])}, "names a frame twice"),
            ({"frame_index": np.array([0, 1])}, "it must be 4 frame numbers"),
            ({"frame_index": np.array([10, 11, 12, 13])}, "frames 10 to 13, the reference 0"),
            ({"joint_confidence": np.zeros((4, 2))}, "joint_confidence is float64"),
            (
                {"Ts_camera_part": np.zeros((4, 2, 4, 4)), "part_names": np.array(["head"])},
                "Ts_camera_part is float64",
            ),
            ({"joint_names": np.array(["x"] * 16)}, "unknown joint names x, x"),
        ],
    )  # fmt: skip
    def test_refused_in_one_line(
        self, tmp_path: Path, reference: Any, change: dict[str, Any], message: str
    ) -> None:
        path, change = tmp_path / "a.npz", dict(change)
        write(path, change.pop("joints_camera", people_standing(4, -0.5, 0.7)), **change)
        with pytest.raises(InputError, match=message) as error:
            read_predictions(path, reference)
        assert str(error.value).count(str(path)) == 1
        assert "\n" not in str(error.value)

    def test_a_file_that_the_system_does_not_give(self, tmp_path: Path, reference: Any) -> None:
        with pytest.raises(InputError, match=r"gone\.npz: cannot be read \(No such file"):
            read_predictions(tmp_path / "gone.npz", reference)

    @pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut off"])
    def test_damaged_files(self, tmp_path: Path, reference: Any, content: bytes) -> None:
        (tmp_path / "a.npz").write_bytes(content)
        with pytest.raises(InputError, match=r"a\.npz: is truncated or damaged"):
            read_predictions(tmp_path / "a.npz", reference)


class TestCommand:
    @pytest.fixture
    def recordings(self, tmp_path: Path) -> Path:
        for name in ("a", "b"):
            write_rendered(tmp_path / "set" / name, [2.0, 2.5])
        return tmp_path / "set"

    def call(self, *arguments: str | Path) -> int:
        return evaluate(
            [str(a) for a in arguments],
            exit_on_error=False,
            print_error=False,
            result_action="return_value",
        )

    def test_files_beside_or_in_folders(
        self, recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        joints = np.stack([standing(z_m=z)[None] for z in (2.0, 2.5)])
        theirs = tmp_path / "theirs"
        (theirs / "b").mkdir(parents=True)
        write(theirs / "a.npz", joints)
        write(theirs / "b" / "skeletons.npz", joints)
        assert self.call("folder", recordings, "--predictions", theirs) == 0
        out = " ".join(capsys.readouterr().out.split())
        assert f"skeletons of {theirs}: 2 of 2 recordings" in out

    def test_a_missing_file_does_not_lose_the_others(
        self, recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        joints = np.stack([standing(z_m=z)[None] for z in (2.0, 2.5)])
        (tmp_path / "theirs").mkdir()
        names = np.array(["skull", *JOINT_NAMES[1:]])
        write(tmp_path / "theirs" / "b.npz", joints, joint_names=names)
        arguments = ("--predictions", tmp_path / "theirs", "--map", "skull=head")
        assert self.call("folder", recordings, *arguments) == 2
        captured = capsys.readouterr()
        assert "a: " in captured.err
        assert "there must be a.npz or a/skeletons.npz" in captured.err
        assert "1 of 2 recordings" in " ".join(captured.out.split())

    def test_one_file_is_for_one_recording(self, recordings: Path, tmp_path: Path) -> None:
        joints = np.stack([standing(z_m=z)[None] for z in (2.0, 2.5)])
        file = write(tmp_path / "a.npz", joints)
        with pytest.raises(InputError, match="is one file for 2 recordings"):
            self.call("folder", recordings, "--predictions", file)
        assert self.call("folder", recordings / "a", "--predictions", file) == 0

    @pytest.mark.parametrize("text", ["head", "=head", "a=b=c"])
    def test_a_wrong_map(self, recordings: Path, tmp_path: Path, text: str) -> None:
        arguments = ("--predictions", tmp_path, "--map", text)
        with pytest.raises(InputError, match=r"--map is .*; it must be theirs=ours"):
            self.call("folder", recordings, *arguments)

    def test_no_such_folder(self, recordings: Path, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="nowhere: no such file or folder"):
            self.call("folder", recordings, "--predictions", tmp_path / "nowhere")

    def test_jobs_travel_to_other_processes(self, recordings: Path, tmp_path: Path) -> None:
        job = PredictedJob(find_folder_recordings([recordings])[0], Predictions(tmp_path))
        assert pickle.loads(pickle.dumps(job)) == job

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (("simulated", "--seeds", "1,x"), "--seeds is '1,x'"),
            (("simulated", "nowhere"), "scene 'nowhere' is not known"),
            (("mhad", "nowhere"), "nowhere lacks Kinect"),
            (("itop", "nowhere", "--split", "x"), "split is 'x'"),
            (("msr-action3d", "nowhere"), "nowhere lacks a01_s01"),
        ],
    )
    def test_wrong_wishes(self, arguments: tuple[str, ...], message: str) -> None:
        with pytest.raises(InputError, match=message):
            self.call(*arguments)


class TestValuesThatCannotBe:
    """Each of them was measured with before, with warnings of NumPy's."""

    @pytest.mark.parametrize(
        ("key", "value", "complaint"),
        [
            ("joint_confidence", 1e300, r"joint_confidence has 1e\+300; it must be 0 to 1"),
            ("joint_confidence", -0.5, "joint_confidence has -0.5; it must be 0 to 1"),
            ("joint_confidence", np.inf, "joint_confidence has inf; it must be 0 to 1"),
            ("Ts_camera_part", 1e300, r"Ts_camera_part has 1e\+300 in a rotation"),
            ("Ts_camera_part", np.inf, "Ts_camera_part has inf in a rotation"),
            ("joint_names", np.array(False), r"joint_names has shape \(\); it must be a list"),
            ("part_names", np.array("head"), r"part_names has shape \(\); it must be a list"),
            ("joint_state", np.zeros((2, 1, 3), np.uint8), "joint_state is uint8"),
        ],
    )
    def test_they_are_refused_in_one_line(self, tmp_path, key, value, complaint):
        joints = people_standing(2, 0.0)
        write_skeletons_npz(predicted_of(joints), tmp_path / "whole.npz")
        with np.load(tmp_path / "whole.npz") as whole:
            arrays = dict(whole)
        if isinstance(value, float):
            arrays[key] = arrays[key].astype(np.float64)
            arrays[key][0, 0, 0, ...] = value
        else:
            arrays[key] = value
        np.savez(tmp_path / "a.npz", allow_pickle=False, **arrays)
        with pytest.raises(InputError, match=complaint):
            read_predictions(tmp_path / "a.npz", reference_of(joints))

    def test_a_confidence_may_be_unknown_or_pass_one_by_rounding(self, tmp_path):
        joints = people_standing(2, 0.0)
        write_skeletons_npz(predicted_of(joints), tmp_path / "whole.npz")
        with np.load(tmp_path / "whole.npz") as whole:
            arrays = dict(whole)
        arrays["joint_confidence"][0, 0, :2] = 1.001, np.nan
        np.savez(tmp_path / "a.npz", allow_pickle=False, **arrays)
        read = read_predictions(tmp_path / "a.npz", reference_of(joints)).joint_confidence
        assert read[0, 0, 0] == 1.0
        assert np.isnan(read[0, 0, 1])


class TestTimes:
    """Of the frames, where a file tells them."""

    REFERENCE = reference_of(people_standing(5, 0.0))

    def read(self, tmp_path: Path, frames: list[int], **times: Any) -> NDArray[np.float64]:
        arrays = {
            "joint_names": np.array(JOINT_NAMES),
            "joints_camera": people_standing(len(frames), 0.0),
            "frame_index": np.array(frames),
        }
        np.savez(tmp_path / "told.npz", **arrays, **times)
        return read_predictions(tmp_path / "told.npz", self.REFERENCE).timestamps_s

    def test_they_are_those_of_the_file(self, tmp_path: Path) -> None:
        times_s = np.array([0.0, 0.1, 0.15, 0.3, 0.4])
        told = self.read(tmp_path, [0, 1, 2, 3, 4], timestamps_s=times_s)
        assert told.tolist() == times_s.tolist()

    def test_missing_frames_lie_between(self, tmp_path: Path) -> None:
        told = self.read(tmp_path, [4, 0, 1], timestamps_s=np.array([0.4, 0.0, 0.1]))
        assert told == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])

    def test_they_may_be_missing(self, tmp_path: Path) -> None:
        assert self.read(tmp_path, [0, 1, 2, 3, 4]).tolist() == [0.0] * 5

    @pytest.mark.parametrize(
        "times_s", [[0.0, 0.2, 0.1], [0.0, np.nan, 0.2], [0.0, 0.1], ["a", "b", "c"]]
    )
    def test_wrong_ones_are_one_line(self, tmp_path: Path, times_s: list[Any]) -> None:
        with pytest.raises(InputError, match=r"told\.npz: timestamps_s "):
            self.read(tmp_path, [0, 1, 2], timestamps_s=np.array(times_s))
