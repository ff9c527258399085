"""Who is known beforehand, and what is learnt of everybody."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import topview
from topview.body import OUTPUT_JOINT_NAMES as JOINT_NAMES
from topview.body.known_body import BONE_NAMES, KnownBody, KnownBone, read_bodies
from topview.detect.joints import PROPOSED_JOINTS
from topview.people.users import User
from topview.records import InputError, Person
from topview.track import Tracker, TrackerSettings
from topview.track.bone_lengths import LEAST_SIGMA_M, PROPOSED_LENGTHS, BoneLengths
from topview.track.known_people import STRANGER_M, KnownPeople, LearntBodies, nearest_statures
from topview_lab.datasets.simulated import RecordingWithTruth
from topview_lab.sim import scene_by_name
from topview_lab.sim.appearance import random_appearance
from topview_lab.training.joints.simulated import simulated_recording

CHILD, ADULT, UNKNOWN = KnownBody(1.2), KnownBody(1.8), KnownBody()


def user(person: int, height_m: float = 1.72, *, measured: bool = True) -> User:
    return User(person, np.array([0.0, 0.0, 3.0]), True, height_m, measured, np.zeros(0, np.int32))


def heights(known: KnownPeople, *users: User) -> list[float | None]:
    """As the body trackers are told them, None where they are not measured."""
    return [u.height_m if u.height_is_measured else None for u in known.told(users)]


def test_without_anything_known_nothing_changes() -> None:
    users = [user(1), user(2, measured=False)]
    assert KnownPeople().told(users) == users
    assert KnownPeople().body_of(1) is None


def test_a_stature_is_everybodys() -> None:
    known = KnownPeople(1.5)
    assert heights(known, user(1, 1.8), user(2, measured=False)) == [1.5, 1.5]


def test_whoever_is_measured_gets_the_body_of_the_nearest_stature() -> None:
    known = KnownPeople(bodies=[CHILD, ADULT])
    assert heights(known, user(1, 1.77), user(2, 1.24)) == [1.8, 1.2]
    assert known.body_of(1) is ADULT
    assert known.body_of(2) is CHILD


def test_whoever_sits_gets_what_is_left_in_the_order_of_the_file() -> None:
    known = KnownPeople(bodies=[CHILD, ADULT])
    assert heights(known, user(1, measured=False), user(2, 1.25)) == [1.8, 1.2]
    known = KnownPeople(bodies=[CHILD, ADULT])
    assert heights(known, user(3, measured=False), user(4, measured=False)) == [1.2, 1.8]


def test_a_stranger_has_no_body() -> None:
    known = KnownPeople(bodies=[CHILD])
    stranger_m = 1.2 + 1.01 * STRANGER_M
    assert heights(known, user(1, stranger_m)) == [stranger_m]
    assert known.body_of(1) is None
    assert heights(known, user(1, stranger_m), user(2, 1.21)) == [stranger_m, 1.2]


def test_a_body_stays_with_its_person_and_is_free_once_they_are_gone() -> None:
    known = KnownPeople(bodies=[CHILD])
    known.told([user(1, 1.22)])
    known.told([user(1, 1.5), user(2, 1.2)])
    assert known.body_of(1) is CHILD
    assert known.body_of(2) is None
    known.told([])
    assert heights(known, user(3, 1.19)) == [1.2]


def test_whoever_comes_back_has_the_same_body_unless_it_is_anothers_now() -> None:
    known = KnownPeople(bodies=[CHILD])
    for people in ([user(1, 1.2)], [], [user(1, measured=False)]):
        known.told(people)
    assert known.body_of(1) is CHILD
    for people in ([], [user(2, 1.2)], [user(1, 1.2), user(2, 1.2)]):
        known.told(people)
    assert known.body_of(2) is CHILD
    assert known.body_of(1) is None


def test_a_body_of_no_known_stature_leaves_what_is_measured() -> None:
    known = KnownPeople(bodies=[UNKNOWN])
    assert heights(known, user(1, 1.66)) == [1.66]
    assert known.body_of(1) is UNKNOWN


def test_the_nearest_pair_is_matched_first_whatever_the_order() -> None:
    assert nearest_statures({1: 1.70, 2: 1.75}, {0: 1.76}) == {2: 0}
    assert nearest_statures({2: 1.75, 1: 1.70}, {0: 1.76, 1: 1.60}) == {2: 0, 1: 1}


def test_the_longest_look_is_told_and_no_short_one() -> None:
    learnt = LearntBodies()
    for person, seconds in ((2, 5.0), (1, 3.0), (1, 1.5), (3, 0.5)):
        learnt.add(person, KnownBody(1.6 + 0.1 * person, seconds=seconds))
    assert [body.seconds for body in learnt.bodies()] == [3.0, 5.0]


def test_known_bones_are_those_of_the_first_frame_and_as_sure_as_they_were() -> None:
    known = {name: KnownBone(0.2 + 0.01 * k, 0.02) for k, name in enumerate(BONE_NAMES)}
    bones = BoneLengths(known)
    for stature_m in (1.2, 1.9):
        assert_allclose(bones.lengths_m(stature_m), [b.length_m for b in known.values()])
        again = bones.known(stature_m)
        assert_allclose([b.sigma_m for b in again.values()], 0.02)
    too_sure = {name: KnownBone(bone.length_m, 1e-6) for name, bone in known.items()}
    assert_allclose([b.sigma_m for b in BoneLengths(too_sure).known(1.7).values()], LEAST_SIGMA_M)


def test_the_names_of_the_bones_are_those_that_are_learnt() -> None:
    assert tuple(PROPOSED_LENGTHS) == BONE_NAMES


def test_a_saved_body_makes_the_same_model_to_the_bit(tmp_path: Path) -> None:
    bones = {name: KnownBone(0.1 + 1.0 / (3 + k), 0.01) for k, name in enumerate(BONE_NAMES)}
    topview.write_bodies([KnownBody(1.7, bones, 2.0)], tmp_path / "bodies.json")
    (read,) = read_bodies(tmp_path / "bodies.json")
    before, after = BoneLengths(bones).model(1.7), BoneLengths(read.bones).model(1.7)
    for name in ("lengths_m", "radii_m", "joints_parent", "joints_part"):
        assert_array_equal(getattr(before, name), getattr(after, name))


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"stature": 178.0}, "stature is 178.0; it must be metres"),
        ({"stature": float("nan")}, "stature is nan"),
        ({"stature": "1.78"}, "stature is '1.78'"),
        ({"stature": 1.7, "body": Path("b.json")}, "stature is 1.7 beside body 'b.json'"),
    ],
)
def test_a_stature_that_nobody_has_is_refused(settings: dict[str, object], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        TrackerSettings(**settings)  # type: ignore[arg-type]


def test_settings_say_what_was_known(tmp_path: Path) -> None:
    assert TrackerSettings(stature=1.7).as_json()["stature"] == 1.7
    path = tmp_path / "family.json"
    topview.write_bodies([CHILD], path)
    child = TrackerSettings(body=path).as_json()["bodies"]
    assert child["name"] == "family.json"
    topview.write_bodies([ADULT], path)
    assert TrackerSettings(body=path).as_json()["bodies"]["sha256"] != child["sha256"]


def test_a_file_that_cannot_be_read_ends_before_the_first_frame(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.json"):
        Tracker(TrackerSettings(body=tmp_path / "nowhere.json"))


FIRST_SECOND, LEARNING = 30, 60  # frames


def recording_of(stature_m: float, scene: str, seed: int, frames: int) -> RecordingWithTruth:
    """Of one and the same person but for the stature; the motions differ with the seed."""
    look = replace(random_appearance(np.random.default_rng(5)), stature_m=stature_m)
    return RecordingWithTruth(scene_by_name(scene, seed=seed, frames=frames, appearances=[look]))


def tracked(
    recording: RecordingWithTruth, settings: TrackerSettings | None = None
) -> tuple[Tracker, list[list[Person]]]:
    tracker = Tracker(replace(settings or TrackerSettings(), threads=1))
    return tracker, [tracker.update(frame) for frame in recording]


def mean_error_m(recording: RecordingWithTruth, people: list[list[Person]]) -> float:
    """Of all joints wherever somebody was found, from where the network has learnt them to be."""
    truth_camera = simulated_recording(recording.scene).joints_camera[:, 0]
    shared = [name for name in JOINT_NAMES if name in PROPOSED_JOINTS]
    ours = [JOINT_NAMES.index(name) for name in shared]
    theirs = [PROPOSED_JOINTS.index(name) for name in shared]
    return float(
        np.mean(
            [
                np.linalg.norm(person.joints_camera[ours] - truth[theirs], axis=-1)
                for truth, found in zip(truth_camera, people, strict=True)
                for person in found
            ]
        )
    )


def thigh_m(person: Person) -> float:
    hip, knee = (JOINT_NAMES.index(name) for name in ("left_hip", "left_knee"))
    return float(np.linalg.norm(person.joints_camera[hip] - person.joints_camera[knee]))


@pytest.mark.parametrize("longer", [0.85, 1.0, 1.15])
def test_known_bones_are_those_of_a_body_that_is_searched(longer: float, tmp_path: Path) -> None:
    """Without a joint network nothing is learnt, but what is known is used."""
    stature_m = 1.7
    thigh = KnownBone(longer * PROPOSED_LENGTHS["upper_leg"] * stature_m, LEAST_SIGMA_M)
    others = {
        name: KnownBone(share * stature_m, LEAST_SIGMA_M)
        for name, share in PROPOSED_LENGTHS.items()
    }
    topview.write_bodies(
        [KnownBody(stature_m, others | {"upper_leg": thigh})], tmp_path / "body.json"
    )
    settings = TrackerSettings(proposals="none", body=tmp_path / "body.json")
    _, found = tracked(recording_of(stature_m, "reaching", 3, 3), settings)
    lengths_m = [thigh_m(person) for people in found for person in people]
    assert len(lengths_m) >= 2
    assert_allclose(lengths_m, thigh.length_m, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("stature_m", [1.15, 1.3, 1.98])
def test_a_child_and_a_tall_person_who_sit_have_their_bones_from_the_first_frame(
    stature_m: float, tmp_path: Path
) -> None:
    """Learnt while they stood. Nobody measures the stature of somebody who sits."""
    learning, _ = tracked(recording_of(stature_m, "reaching", 3, LEARNING))
    (body,) = learning.bodies()
    assert body.stature_m == pytest.approx(stature_m, abs=0.03)
    topview.write_bodies([body], tmp_path / "body.json")

    recording = recording_of(stature_m, "sitting", 4, FIRST_SECOND)
    _, without = tracked(recording)
    _, known = tracked(recording, TrackerSettings(body=tmp_path / "body.json"))
    first = next(people for people in known if people)
    assert first[0].height_m == body.stature_m
    assert thigh_m(first[0]) == pytest.approx(body.bones["upper_leg"].length_m, abs=0.015)
    without_m = mean_error_m(recording, without)
    assert mean_error_m(recording, known) < without_m
    _, told = tracked(recording, TrackerSettings(stature=stature_m))
    assert mean_error_m(recording, told) < without_m
