"""Proposals of joints on their way to the methods that ask for them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from tiny_networks import write_network
from topview.body.parts import JOINT_NAMES
from topview.camera.pyramid import Pyramid
from topview.detect.joints import JointProposals, Windows
from topview.detect.joints.proposers import PROPOSALS, proposer_by_name
from topview.detect.joints.windows import LEAST_WINDOW_PIXELS
from topview.people.users import User
from topview.records import Camera, Frame, InputError
from topview.timing import StageClock
from topview.track import Tracker, TrackerSettings
from topview.track.body_tracker import Needs, Subject
from topview.track.evidence import Evidence
from topview.track.methods.utvr import UtvrSettings
from topview.track.pose import Pose
from topview.track.stances import STANDING, stand

CAMERA = Camera(fx=142.5, fy=142.5, cx=79.5, cy=59.5, width=160, height=120)
PLACES = {3: (10, 30), 8: (60, 80), 5: (110, 130)}
"""First and last column of each person."""


@dataclass(frozen=True, slots=True)
class Asking:
    """A method that asks for proposals, and keeps what it is given, by person."""

    needs: ClassVar[Needs] = Needs(joints=True)
    given: ClassVar[dict[int, list[JointProposals | None]]] = {}

    @property
    def name(self) -> str:
        return "asking"

    def tracker(self, subject: Subject) -> AskingTracker:
        return AskingTracker(self.given.setdefault(subject.person, []))


class NotAsking(Asking):
    needs: ClassVar[Needs] = Needs()


class AskingTracker:
    def __init__(self, given: list[JointProposals | None]) -> None:
        self.model = UtvrSettings().tracker(Subject(1, 0, 1, StageClock())).model
        self.given = given

    def update(self, evidence: Evidence) -> Pose:
        self.given.append(evidence.proposals)
        return stand(self.model, evidence.head_camera, STANDING, 0.0, evidence.up_camera)


@dataclass
class Middles:
    """Proposes that all joints are in the box's middle."""

    seen: list[Windows] = field(default_factory=list)

    def propose(self, windows: Windows) -> JointProposals:
        self.seen.append(windows)
        P, J = len(windows.is_used), len(JOINT_NAMES)
        return JointProposals(
            windows.to_camera(np.zeros((P, 1, J, 3))),
            np.full((P, 1, J, 3), 0.1),
            windows.is_used[:, None].astype(np.float64),
            windows.is_used.astype(np.float64),
            JOINT_NAMES,
        )


@dataclass
class People:
    """A finder that finds the same people in every frame, in the order that it is told; their
    heads are near the middles of their boxes."""

    pixels: dict[int, np.ndarray]
    order: list[int]
    clock: StageClock = field(default_factory=StageClock)
    floor: Any = None
    skin_detections: Any = None
    found: Any = None
    hands: tuple[()] = ()
    doubtful: tuple[()] = ()
    head_y_m: float = 0.1
    told: Any = None

    def update(self, image: Pyramid, told: Any = None) -> list[User]:
        self.told = told
        return [self.user(person, image.full.depth_m) for person in self.order]

    def user(self, person: int, depth_m: np.ndarray) -> User:
        pixels = self.pixels[person]
        depth = float(np.median(depth_m.ravel()[pixels]))
        x = (float(np.median(pixels % CAMERA.width)) - CAMERA.cx) / CAMERA.fx * depth
        return User(person, np.array([x, self.head_y_m, depth]), True, 1.7, True, pixels)


def frame_of(index: int = 0) -> Frame:
    """Three people before a wall, each at another depth."""
    depth_m = np.full((CAMERA.height, CAMERA.width), 4.0, np.float32)
    for person, (first, last) in PLACES.items():
        depth_m[20:110, first:last] = 2.0 + 0.2 * person
    return Frame(index, index / 30, depth_m, CAMERA)


def people(order: list[int], few: tuple[int, ...] = ()) -> People:
    """Of `few` hardly anything is seen."""
    depth_m = frame_of().depth_m
    pixels = {
        person: np.flatnonzero(depth_m == np.float32(2.0 + 0.2 * person)).astype(np.int32)
        for person in PLACES
    }
    for person in few:
        pixels[person] = pixels[person][: LEAST_WINDOW_PIXELS - 1]
    return People(pixels, order)


def run(finder: People, settings: TrackerSettings, proposer: Any = None) -> Tracker:
    Asking.given.clear()
    tracker = Tracker(settings, body=Asking(), finder=finder, proposer=proposer)
    tracker.update(frame_of())
    return tracker


ONE_THREAD = TrackerSettings(threads=1)


@pytest.mark.parametrize("order", [[3, 8, 5], [5, 3, 8]])
def test_everybody_gets_the_own_proposals_in_any_order(order: list[int]) -> None:
    proposer = Middles()
    tracker = run(people(order), ONE_THREAD, proposer)
    assert len(proposer.seen) == 1  # once for all
    for person, (first, last) in PLACES.items():
        (own,) = Asking.given[person]
        assert own is not None
        (x, _, z) = own.positions_camera[0, 0, 0]
        assert z == pytest.approx(2.0 + 0.2 * person)
        assert CAMERA.fx * x / z + CAMERA.cx == pytest.approx((first + last - 1) / 2)
    assert {"windows", "joints"} <= tracker.clock.seconds.keys()
    assert tracker.settings_as_json()["proposer"] == "Middles"


def test_everybody_is_looked_at_by_turns_and_in_a_mirrored_recording_the_other_way() -> None:
    """So that the network sees the same of it."""
    looked_at = []
    for way in (slice(None), slice(None, None, -1)):
        proposer = Middles()
        finder = people([3, 8, 5])
        for person, pixels in finder.pixels.items():
            is_own = np.zeros((CAMERA.height, CAMERA.width), np.bool_)
            is_own.ravel()[pixels] = True
            finder.pixels[person] = np.flatnonzero(is_own[:, way]).astype(np.int32)
        tracker = Tracker(ONE_THREAD, body=Asking(), finder=finder, proposer=proposer)
        for index in range(3):
            depth_m = np.ascontiguousarray(frame_of().depth_m[:, way])
            tracker.update(Frame(index, index / 30, depth_m, CAMERA))
        looked_at.append([windows.looked_at for windows in proposer.seen])
        first, second, third = (windows.is_mirrored for windows in proposer.seen)
        np.testing.assert_array_equal(first, ~second)
        np.testing.assert_array_equal(first, third)
        assert len(set(first.tolist())) == 2  # one of the three stands on the other side
    np.testing.assert_array_equal(*looked_at)


def test_who_is_hardly_seen_has_no_proposals() -> None:
    run(people([3, 8], few=(8,)), ONE_THREAD, Middles())
    assert Asking.given[8] == [None]
    assert Asking.given[3] != [None]


def test_a_network_that_sees_the_head_elsewhere_guides_nobody() -> None:
    finder = people([3, 8])
    finder.head_y_m = -0.7
    run(finder, ONE_THREAD, Middles())
    assert Asking.given == {3: [None], 8: [None]}


def test_without_proposals_nothing_is_cut_out() -> None:
    tracker = run(people([3, 8]), TrackerSettings(threads=1, proposals="none"))
    assert Asking.given == {3: [None], 8: [None]}
    assert not {"windows", "joints"} & tracker.clock.seconds.keys()


def test_who_does_not_ask_costs_nothing() -> None:
    proposer = Middles()
    tracker = Tracker(ONE_THREAD, body=NotAsking(), finder=people([3]), proposer=proposer)
    tracker.update(frame_of())
    assert not proposer.seen
    assert Asking.given[3][-1] is None
    assert not {"windows", "joints"} & tracker.clock.seconds.keys()


@pytest.mark.parametrize("method", [Asking, NotAsking])
def test_the_finder_alone_can_be_told(method: type) -> None:
    Asking.given.clear()
    settings = TrackerSettings(threads=1, proposals="finder")
    finder, proposer = people([3, 8]), Middles()
    tracker = Tracker(settings, body=method(), finder=finder, proposer=proposer)
    for index in range(2):
        tracker.update(frame_of(index))
    assert len(proposer.seen) == 2
    assert finder.told.has_network
    assert set(finder.told.heads) == {3, 8}
    assert Asking.given == {3: [None, None], 8: [None, None]}


def test_the_settings_say_that_the_finder_is_told() -> None:
    kept = TrackerSettings(method="utvr", proposals="finder").as_json()
    assert kept["proposals"] == "finder"
    assert kept["weights"]


def test_the_network_s_proposals_come_with_a_given_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One of random weights sees the head anywhere.
    monkeypatch.setattr("topview.people.told_head.ELSEWHERE_M", np.inf)
    weights = write_network(tmp_path / "own.onnx")
    tracker = run(people([3, 8]), TrackerSettings(threads=1, weights=weights))
    kept = json.loads(json.dumps(tracker.settings_as_json()))
    assert kept["proposals"] == "network"
    assert kept["weights"]["name"] == "own.onnx"
    assert str(tmp_path) not in json.dumps(kept)
    (own,) = Asking.given[3]
    assert own is not None
    assert own.weights.shape == (1, 2)


def test_what_a_method_does_not_ask_for_is_not_told() -> None:
    assert TrackerSettings(method="btvr", seed=2, proposals="none").as_json() == {
        "method": "btvr",
        "detector": "auto",
        "seed": 2,
    }
    assert TrackerSettings(proposals="forest").as_json()["proposals"] == "forest"


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        (
            {"proposals": "wood"},
            "proposals is 'wood'; it must be one of network, forest, finder, none",
        ),
        ({"weights": Path("w"), "proposals": "none"}, "weights is 'w' with proposals none; "),
        ({"weights": Path("w"), "proposals": "forest"}, "weights is 'w' with proposals forest; "),
    ],
)
def test_proposals_that_make_no_sense_are_one_line(wrong: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=f"^{what}.*$"):
        TrackerSettings(**wrong)


def test_weights_that_nothing_reads_are_refused() -> None:
    with pytest.raises(InputError, match=r"^weights is 'w'; method btvr asks no network; .*$"):
        Tracker(TrackerSettings(method="btvr", weights=Path("w")))


def test_all_that_proposes_can_be_made(tmp_path: Path) -> None:
    write_network(tmp_path / "w.onnx")
    made = {name: proposer_by_name(name) for name in ("forest", "none")}
    assert made.pop("none") is None
    assert list(map(type, made.values())).count(type(None)) == 0
    for name in set(PROPOSALS) - {"forest", "none"}:
        assert proposer_by_name(name, tmp_path / "w.onnx") is not None


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("changes", [{"format": "none"}, {"nan_on_people": True}])
def test_the_command_line_says_in_one_line_what_is_wrong_with_weights(
    topview: Any,
    wave_folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    changes: dict[str, Any],
) -> None:
    monkeypatch.setattr(UtvrSettings, "needs", Needs(joints=True))
    path = write_network(tmp_path / "bad.onnx", **changes)
    ended = topview(
        "track", wave_folder, "--out", tmp_path / "out", "--method", "utvr", "--weights", path
    )
    assert ended.status == 2
    (told,) = ended.complaints
    assert str(path) in told
    assert "--proposals none" in told


def test_the_network_is_asked_unless_told_otherwise() -> None:
    """By the methods that ask for joints; `joints` cannot do without."""
    assert TrackerSettings().proposals == "network"
    for proposals in ("none", "finder"):
        with pytest.raises(
            InputError, match=f"proposals is {proposals}; method joints needs proposed joints"
        ):
            Tracker(TrackerSettings(method="joints", proposals=proposals))
