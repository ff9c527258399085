"""Simulated scenes as a data set, and all that a `groundtruth.npz` tells."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skeleton_sequences import J, rendered_groundtruth, write_rendered
from topview.body import JOINT_NAMES, PART_NAMES
from topview.records import InputError, Recording
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track.run import TrackingResult
from topview.track.settings import TrackerSettings
from topview_lab.datasets import (
    KnowsReference,
    SimulatedScene,
    find_folder_recordings,
    make_simulated,
    read_groundtruth,
    reference_from,
)
from topview_lab.evaluate.run import Job
from topview_lab.sim import SCENES


class TestWhatTheTruthTells:
    def test_every_share_reaches_its_field(self) -> None:
        keys = ("joint_occ_person", "joint_occ_furniture", "joint_occ_self", "joint_outside")
        shares = {key: np.full((2, 1, J), 0.1 * i, np.float32) for i, key in enumerate(keys)}
        reference = reference_from(rendered_groundtruth([2.0, 3.0], **shares), "truth")
        names = ("occluded_by_person", "occluded_by_object", "occluded_by_self", "outside")
        for i, name in enumerate(names):
            assert getattr(reference, name) == pytest.approx(0.1 * i)

    def test_what_faces_away_in_view_is_hidden_by_the_own_body(self) -> None:
        """Files say that it is outside, as of all that nothing faces the camera of."""
        own, outside = np.full((2, 1, J), np.nan), np.ones((2, 1, J))
        own[:, :, 1], outside[:, :, 1] = 0.25, 0.0
        arrays = rendered_groundtruth(
            [2.0, 3.0],
            joint_occ_self=own,
            joint_outside=outside,
            person_outside=np.array([[0.0], [0.5]]),
        )
        reference = reference_from(arrays, "truth")
        assert reference.occluded_by_self is not None
        assert reference.outside is not None
        assert reference.occluded_by_self[0, 0, :3].tolist() == [1.0, 0.25, 1.0]
        assert reference.outside[0, 0, :3].tolist() == [0.0, 0.0, 0.0]
        np.testing.assert_array_equal(reference.occluded_by_self[1], own[1])
        np.testing.assert_array_equal(reference.outside[1], outside[1])

    def test_actions_and_bodies(self) -> None:
        told = {"actions": np.array([["wave"], ["box"]]), "bodies": np.array(["woman 1.62 m"])}
        reference = reference_from(rendered_groundtruth([2.0, 3.0], **told), "truth", action="x")
        assert reference.actions is not None
        assert reference.actions.tolist() == [["wave"], ["box"]]
        assert reference.bodies == ("woman 1.62 m",)

    def test_an_action_for_all_where_none_is_told(self, tmp_path: Path) -> None:
        write_rendered(tmp_path / "jumping", [2.0, 3.0])
        reference = find_folder_recordings([tmp_path])[0].reference()
        assert reference.actions is not None
        assert reference.actions.tolist() == [["jumping"], ["jumping"]]
        assert reference.bodies is None

    def test_orientations_of_our_parts(self) -> None:
        names = ["head", "hand_l", "upper_arm_l", "forearm_r", "foot_r"]
        Ts = np.tile(np.eye(4), (2, 1, len(names), 1, 1))
        Ts[:, :, 3, :3, :3] = np.diag([-1.0, 1.0, -1.0])
        told = {"part_names": np.array(names), "Ts_camera_part": Ts}
        reference = reference_from(rendered_groundtruth([2.0, 3.0], **told), "truth")
        assert reference.part_names == ("head", "left_upper_arm", "right_forearm")
        assert reference.Rs_camera_part is not None
        assert reference.Rs_camera_part.shape == (2, 1, 3, 3, 3)
        assert reference.Rs_camera_part[1, 0, 2, 0, 0] == -1.0
        assert reference.Rs_camera_part[1, 0, 1, 0, 0] == 1.0

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"joint_outside": np.zeros((2, 2, J))}, "truth: joint_outside has shape"),
            (
                {"joint_occ_self": np.full((2, 1, J), 1.5)},
                "truth: .*occluded_by_self has the share",
            ),
            (
                {"actions": np.array(["wave", "box"])},
                r"actions has shape \(2,\); it must be \(2, 1\)",
            ),
            ({"bodies": np.array(["a", "b"])}, r"bodies has shape \(2,\)"),
            ({"Ts_camera_part": np.zeros((2, 1, 3, 4, 4))}, "truth lacks part_names"),
            (
                {"Ts_camera_part": np.zeros((2, 1, 3, 4, 4)), "part_names": np.array(["head"])},
                "Ts_camera_part has shape",
            ),
        ],
    )
    def test_bad_content(self, change: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message) as error:
            reference_from(rendered_groundtruth([2.0, 3.0], **change), "truth")
        assert "\n" not in str(error.value)

    def test_rendered_recordings(self, shared: Path) -> None:
        path = shared / "bench" / "b3_stand60" / "groundtruth.npz"
        reference = read_groundtruth(path)
        assert reference.occluded_by_object is not None
        assert reference.occluded_by_self is not None
        assert reference.outside is not None
        assert reference.occluded_by_person is not None
        assert np.nanmax(reference.occluded_by_person) > 0.9


def count_frames(recording: Recording, settings: TrackerSettings) -> TrackingResult:
    """A tracker that finds nobody."""
    about = About(JOINT_NAMES, PART_NAMES)
    frames = [TrackedFrame(f.index, f.timestamp_s, f.name, about.packed([])) for f in recording]
    return TrackingResult(SkeletonSequence.from_frames(frames, about), 0.1, False)


class TestSimulated:
    def test_names_and_order(self) -> None:
        made = make_simulated(("walk", "stand"), (3, 1))
        assert [scene.name for scene in made] == ["walk_3", "walk_1", "stand_3", "stand_1"]
        assert {scene.scene for scene in make_simulated()} == set(SCENES)
        chosen = make_simulated(("walk", "stand"), (3, 1), pattern="*_1")
        assert [scene.name for scene in chosen] == ["walk_1", "stand_1"]

    def test_the_truth_comes_with_the_frames(self) -> None:
        scene = SimulatedScene("pass_by", seed=2, frames=3)
        recording = scene.open()
        assert isinstance(recording, KnowsReference)
        assert [frame.index for frame in recording] == [0, 1, 2]
        along, alone = recording.reference(), scene.reference()
        for name in ("joints_camera", "occluded_by_person", "occluded_by_self", "Rs_camera_part"):
            np.testing.assert_array_equal(getattr(along, name), getattr(alone, name))
        assert along.bodies == alone.bodies
        assert along.actions is not None
        assert along.actions.shape == (3, 2)
        assert set(along.part_names) == set(PART_NAMES)

    def test_reading_twice_tells_each_frame_once(self) -> None:
        recording = SimulatedScene("stand", seed=1, frames=2).open()
        for _ in range(2):
            list(recording)
        assert recording.reference().frame_index.tolist() == [0, 1]

    def test_they_travel_to_other_processes(self) -> None:
        scene = SimulatedScene("stand", seed=1, frames=2)
        assert pickle.loads(pickle.dumps(scene)) == scene

    def test_they_are_measured_without_rendering_twice(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        scene = SimulatedScene("pass_by", seed=1, frames=2)
        monkeypatch.setattr(SimulatedScene, "reference", lambda self: pytest.fail("rendered twice"))
        outcome = Job(scene, TrackerSettings(), count_frames)()
        assert outcome.errors is not None
        assert outcome.errors.people.person_frames == outcome.errors.people.missed == 4

    @pytest.mark.parametrize(
        ("wrong", "message"),
        [
            ({"scenes": ("dancing",)}, "scene 'dancing' is not known; it must be one of .*pass_by"),
            ({"seeds": ()}, "no seed given"),
            ({"seeds": (-1,)}, "seed is -1"),
            ({"people": 9}, "people is 9"),
            ({"frames": 0}, "frames is 0"),
            ({"pattern": "nobody*"}, "simulated: no sequence matches 'nobody\\*'"),
        ],
    )
    def test_wrong_wishes(self, wrong: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            make_simulated(**wrong)
