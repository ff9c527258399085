"""A method, a detector or a finder of one's own is given to the tracker; those that have a name can
all be made; and the output says which it was."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, get_args

import numpy as np
import pytest

from rendered_bodies import UP, subject
from topview.body.model import HEAD_CENTRE, BodyModel
from topview.body.parts import JOINT_NAMES
from topview.body.proportions import ANATOMICAL
from topview.camera.pyramid import Pyramid
from topview.detect.detectors import DETECTORS, DetectorName, head_detector
from topview.detect.heads import NO_HINTS, HeadCandidate
from topview.io.writers import read_skeletons_npz, write_skeletons_npz
from topview.people.told import NOTHING_TOLD, Told
from topview.people.users import User
from topview.records import InputError
from topview.timing import StageClock
from topview.track import Tracker, TrackerSettings, track_recording
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods import METHODS, method_by_name
from topview.track.methods.btvr.arms import ArmSettings
from topview.track.methods.btvr.torso import TorsoSettings
from topview.track.methods.btvr.torso_shape import NARROW
from topview.track.methods.topview import TopviewSettings
from topview.track.methods.utvr import UtvrSettings
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand
from topview.track.tracker import KEPT_S
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.bodies import SIM_JOINT_NAMES as TRUE_JOINT_NAMES

FRAMES = 3
ONE, TWO = "stand", "two_users"


def recording_of(scene: str) -> SimulatedRecording:
    return SimulatedRecording(scene_by_name(scene, seed=5, frames=FRAMES))


def true_heads(recording: SimulatedRecording, index: int) -> np.ndarray:
    """[people, 3] metres."""
    return recording.simulate(index).truth.joints[:, TRUE_JOINT_NAMES.index("head")]


@dataclass(frozen=True, slots=True)
class Upright:
    """A whole method: everybody stands upright below the head."""

    stature_m: float = 1.7

    needs: ClassVar[Needs] = Needs(unowned_mask=True)

    @property
    def name(self) -> str:
        return "upright"

    def tracker(self, subject: Subject) -> UprightTracker:
        return UprightTracker(self)


class UprightTracker:
    def __init__(self, settings: Upright) -> None:
        self.model = BodyModel.of(settings.stature_m, ANATOMICAL)
        self.evidence: list[Evidence] = []

    def update(self, evidence: Evidence) -> Pose:
        self.evidence.append(evidence)
        return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)


class KnownHeads:
    """A detector that is told where the heads are."""

    needs_color = False
    colors = None

    def __init__(self, recording: SimulatedRecording) -> None:
        self.recording = recording

    def detect(
        self, cloud: Any, up_camera: np.ndarray, hints: object = NO_HINTS
    ) -> list[HeadCandidate]:
        heads = true_heads(self.recording, cloud.frame.index)
        return [HeadCandidate(head, 0.99) for head in heads]


class EverythingIsSomebody:
    """A finder that takes all pixels for those of one person, whose head is known."""

    floor = skin_detections = found = None
    hands = doubtful = ()

    def __init__(self) -> None:
        self.clock = StageClock()
        self.tracked: list[int] = []

    def update(self, image: Pyramid, told: Told = NOTHING_TOLD) -> list[User]:
        self.tracked.append(len(told.people))
        pixels = np.flatnonzero(image.frame.depth_m).astype(np.int32)
        return [User(7, np.array([0.1, -0.6, 2.5]), True, 1.8, True, pixels)]


def test_a_method_that_has_no_name_in_the_table_tracks():
    recording = recording_of(TWO)
    tracker = Tracker(TrackerSettings(threads=1), body=Upright(stature_m=1.6))
    people = [tracker.update(frame) for frame in recording][-1]
    assert len(people) == 2
    for person in people:
        head = person.joints_camera[JOINT_NAMES.index("head")]
        assert np.linalg.norm(true_heads(recording, FRAMES - 1) - head, axis=1).min() < 0.1
        assert person.height_m == 1.6
        to_neck = person.joints_camera[JOINT_NAMES.index("neck")] - head
        assert np.linalg.norm(to_neck) == pytest.approx(HEAD_CENTRE * 1.6 * ANATOMICAL.head)
        assert to_neck @ -UP > 0.95 * np.linalg.norm(to_neck)


def test_a_method_gets_what_it_needs_and_nothing_else(monkeypatch: pytest.MonkeyPatch):
    made: list[UprightTracker] = []
    monkeypatch.setattr(Upright, "tracker", lambda s, _: made.append(UprightTracker(s)) or made[-1])
    tracker = Tracker(TrackerSettings(threads=1), body=Upright())
    for frame in recording_of(TWO):
        tracker.update(frame)
    nearest, farthest = (one.evidence[-1] for one in made)
    assert [len(e.nearer_bodies) for e in (nearest, farthest)] == [0, 1]
    for evidence in (nearest, farthest):
        assert evidence.unowned_mask is not None
        assert not (evidence.unowned_mask & evidence.user_mask).any()
        assert evidence.hidden_share == 0.0  # not asked for


def test_a_detector_of_one_s_own_finds_the_people():
    recording = recording_of(TWO)
    tracker = Tracker(TrackerSettings(threads=1), body=Upright(), detector=KnownHeads(recording))
    people = [tracker.update(frame) for frame in recording][-1]
    heads = [person.joints_camera[JOINT_NAMES.index("head")] for person in people]
    assert len(heads) == 2
    for head in true_heads(recording, FRAMES - 1):
        assert np.linalg.norm(np.array(heads) - head, axis=1).min() < 0.1
    assert tracker.settings_as_json()["detector"] == "KnownHeads"


def test_a_finder_of_one_s_own_takes_the_place_of_the_project_s():
    finder = EverythingIsSomebody()
    tracker = Tracker(TrackerSettings(threads=1), body=Upright(), finder=finder)
    for frame in recording_of(ONE):
        (person,) = tracker.update(frame)
        assert person.id == 7
        np.testing.assert_allclose(
            person.joints_camera[JOINT_NAMES.index("head")], [0.1, -0.6, 2.5], atol=1e-9
        )
    assert finder.tracked == [0, 1, 1]  # it is told of the bodies of the frame before
    assert tracker.settings_as_json()["finder"] == "EverythingIsSomebody"


@pytest.mark.parametrize("name", METHODS)
def test_every_method_of_the_table_can_be_made(name: str):
    method = method_by_name(name)
    assert method.name == name
    assert json.loads(json.dumps(asdict(method))) is not None
    tracker = method.tracker(subject())
    assert 1.0 < tracker.model.stature_m < 2.2
    assert METHODS[name][1]


@pytest.mark.parametrize("name", DETECTORS)
def test_every_detector_of_the_table_can_be_made(name: str):
    detector = head_detector(name, StageClock())
    assert detector.needs_color == (name in ("skin", "cascade"))
    assert (detector.colors is None) == (name == "depth" or name == "cascade")


def test_the_names_that_the_command_line_takes_are_those_of_the_table():
    assert set(get_args(DetectorName)) == set(DETECTORS)


def test_the_output_tells_the_method_and_all_its_settings(tmp_path: Path):
    method = UtvrSettings(hypotheses=30, factors=("reproj", "discr"), n_best=3)
    tracker = Tracker(TrackerSettings(seed=4, threads=1), body=method)
    result = track_recording(recording_of(ONE), tracker=tracker)
    write_skeletons_npz(result.skeletons, tmp_path / "skeletons.npz")
    kept = read_skeletons_npz(tmp_path / "skeletons.npz").settings
    assert kept["method"] == "utvr"
    assert kept["seed"] == 4
    assert kept["body"] == json.loads(json.dumps(asdict(method)))
    assert kept["body"]["n_best"] == 3
    assert "threads" not in kept


@pytest.mark.parametrize(
    ("make", "wrong"),
    [
        (UtvrSettings, {"hypotheses": 0}),
        (UtvrSettings, {"rounds": 11}),
        (UtvrSettings, {"tolerance_m": -0.01}),
        (UtvrSettings, {"clothing_m": float("nan")}),
        (UtvrSettings, {"n_best": 121}),
        (UtvrSettings, {"neck": (0.07, 0.3)}),
        (UtvrSettings, {"neck": 0.07}),
        (UtvrSettings, {"torso_turn_rad": 0.0}),
        (UtvrSettings, {"factors": ()}),
        (UtvrSettings, {"factors": ("reproj", "beauty")}),
        (TorsoSettings, {"views": 0}),
        (TorsoSettings, {"tolerance_m": 1.5}),
        (TorsoSettings, {"clothing_m": 0.5}),
        (partial(replace, NARROW), {"half_width": 0.0}),
        (ArmSettings, {"samples": 0}),
        (ArmSettings, {"rounds": 0}),
        (TopviewSettings, {"statures_m": ()}),
        (TopviewSettings, {"statures_m": (1.7, 170.0)}),
    ],
)
def test_a_setting_out_of_range_is_one_line_that_names_it(make: Any, wrong: dict[str, Any]):
    (name,) = wrong
    with pytest.raises(InputError, match=rf"^{name} is .*; it must .*$") as told:
        make(**wrong)
    assert "\n" not in str(told.value)


class LosesSomebody(EverythingIsSomebody):
    """The same, who cannot be told of in the second frame."""

    def update(self, image: Pyramid, told: Told = NOTHING_TOLD) -> list[User]:
        users = super().update(image, told)
        return [] if len(self.tracked) == 2 else users


@pytest.mark.parametrize(("gone_s", "is_kept"), [(0.1, True), (KEPT_S + 0.1, False)])
def test_whoever_cannot_be_told_of_for_a_moment_keeps_the_body(gone_s: float, is_kept: bool):
    """Another tracker of the body is made only for who was away for long."""
    made: list[Subject] = []

    class Counting(Upright):
        def tracker(self, subject: Subject) -> UprightTracker:
            made.append(subject)
            return super().tracker(subject)

    first, second, third = recording_of(ONE)
    tracker = Tracker(TrackerSettings(threads=1), body=Counting(), finder=LosesSomebody())
    frames = (first, second, replace(third, timestamp_s=first.timestamp_s + gone_s))
    there = [len(tracker.update(frame)) for frame in frames]
    assert there == [1, 0, 1]
    assert [subject.person for subject in made] == [7] * (1 if is_kept else 2)
