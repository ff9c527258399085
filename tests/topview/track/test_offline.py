"""A recording looked at both ways: quiet where all is known, told by before and after where not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from moving_bodies import pose
from topview.body import OUTPUT_JOINT_NAMES as JOINT_NAMES
from topview.body import PART_NAMES
from topview.body.parts import (
    LEFT_FOREARM,
    LEFT_UPPER_ARM,
    LEFT_UPPER_LEG,
    LOWER_TORSO,
    UPPER_TORSO,
)
from topview.geometry.rotations import rotations_from_angles
from topview.records import Camera, Frame, JointState, Person, Recording
from topview.skeletons import About, SkeletonSequence, TrackedFrame
from topview.track.offline import AWAY_S, CHUNK_S, LAG_S, looked_at_both_ways
from topview.track.run import track_recording
from topview.track.tracker import Tracker

ABOUT = About(JOINT_NAMES, PART_NAMES)
FRAME_S = 1.0 / 30.0
HAND = JOINT_NAMES.index("left_hand")
ELBOW = JOINT_NAMES.index("left_elbow")
LEGS = [
    index
    for index, name in enumerate(JOINT_NAMES)
    if name.rpartition("_")[2] in ("hip", "knee", "ankle", "foot")
]
KNOWN_M2, HIDDEN_M2 = 1e-4, 0.04


def swinging(count: int, x_m: float = 0.0, frame_s: float = FRAME_S) -> list[TrackedFrame]:
    """Somebody who walks aside and raises the left arm, 20 degrees a second, always in sight."""
    frames = []
    for f in range(count):
        angles = np.zeros((len(PART_NAMES), 3))
        angles[LEFT_UPPER_ARM] = (0.35 * f * frame_s, 0.0, 0.2)
        angles[LEFT_FOREARM] = (0.5, 0.0, 0.0)
        joints, Ts = pose(angles, place=(x_m + 0.5 * f * frame_s, -0.6, 3.0))
        people = np.zeros(1, ABOUT.person_type)
        people["id"], people["height_m"] = 1, 1.8
        people["joints_camera"], people["Ts_camera_part"] = joints, Ts
        people["joint_state"], people["joint_confidence"] = 1, 0.9
        people["joint_covariance_m2"] = KNOWN_M2 * np.eye(3)
        frames.append(TrackedFrame(f, f * frame_s, str(f), people))
    return frames


def both_ways(frames: Iterable[TrackedFrame]) -> Iterator[TrackedFrame]:
    return looked_at_both_ways(frames, {"proposals": "network"})


def joints_of(frames: list[TrackedFrame]) -> np.ndarray:
    return np.stack([frame.people["joints_camera"][0] for frame in frames])


def changed(frame: TrackedFrame, **values: np.ndarray) -> TrackedFrame:
    people = frame.people.copy()
    for name, value in values.items():
        people[name][0] = value
    return replace(frame, people=people)


def hidden_from(frames: list[TrackedFrame], first: int, last: int) -> list[TrackedFrame]:
    """In these frames the body is taken for that of the first of them, and little is known."""
    held = frames[first].people[0]
    wrong = {
        "joints_camera": held["joints_camera"],
        "Ts_camera_part": held["Ts_camera_part"],
        "joint_covariance_m2": HIDDEN_M2 * np.eye(3),
    }
    return [
        changed(frame, **wrong) if first <= f < last else frame for f, frame in enumerate(frames)
    ]


def test_what_is_known_stays():
    frames = swinging(40)
    apart = joints_of(list(both_ways(frames))) - joints_of(frames)
    assert np.linalg.norm(apart, axis=-1).max() < 0.01


def test_what_was_hidden_is_told_by_before_and_after():
    """A second in which the body was thought to stand still, between motion that is known."""
    true = swinging(90)
    seen = hidden_from(true, 30, 60)
    both = joints_of(list(both_ways(seen)))
    off_before = np.linalg.norm(joints_of(seen) - joints_of(true), axis=-1)[30:60]
    off_after = np.linalg.norm(both - joints_of(true), axis=-1)[30:60]
    assert off_after[:, HAND].mean() < 0.5 * off_before[:, HAND].mean()
    assert off_after.mean() < 0.5 * off_before.mean()


def as_told_backwards(frames: list[TrackedFrame]) -> list[TrackedFrame]:
    """The same people, who have other numbers there."""
    return [changed(frame, id=np.array(5)) for frame in frames]


def test_what_was_hidden_is_told_by_who_saw_it_backwards():
    """Who knew the other way is told as he saw it, and what he was unsure of as the first did."""
    true = swinging(90)
    forward = hidden_from(true, 30, 70)
    backward = as_told_backwards(hidden_from(true, 50, 90))
    both = joints_of(list(looked_at_both_ways(forward, {"proposals": "network"}, backward)))
    alone = joints_of(list(both_ways(forward)))
    off_alone, off_both = (
        np.linalg.norm(own - joints_of(true), axis=-1)[30:50].mean() for own in (alone, both)
    )
    assert off_both < 0.5 * off_alone
    assert np.linalg.norm(both - joints_of(true), axis=-1)[70:].max() < 0.02


def test_whoever_was_missed_is_told_as_tracked_backwards():
    true = swinging(40)
    missed = [
        replace(frame, people=frame.people[:0]) if f < 15 else frame for f, frame in enumerate(true)
    ]
    both = list(looked_at_both_ways(missed, {}, as_told_backwards(true)))
    assert [frame.people["id"].tolist() for frame in both] == [[1]] * 40
    np.testing.assert_allclose(joints_of(both), joints_of(true), atol=0.01)


def test_who_faces_apart_is_as_the_surer_says():
    """Between a body and the same turned round lies none."""
    true = swinging(30)
    turned = []
    for frame in true:
        Ts = frame.people["Ts_camera_part"][0].copy()
        Ts[:3, :3, :3] @= rotations_from_angles(np.array([0.0, np.pi, 0.0]))
        turned.append(
            changed(frame, Ts_camera_part=Ts, joint_covariance_m2=9.0 * KNOWN_M2 * np.eye(3))
        )
    for forward, backward in ((true, turned), (turned, true)):
        both = list(looked_at_both_ways(forward, {}, as_told_backwards(backward)))
        faces = np.stack([own.people["Ts_camera_part"][0, UPPER_TORSO, :3, 2] for own in both])
        expected = np.stack([own.people["Ts_camera_part"][0, UPPER_TORSO, :3, 2] for own in true])
        np.testing.assert_allclose(faces, expected, atol=0.02)


def test_frames_that_were_not_read_again_are_as_tracked_forward():
    frames = hidden_from(swinging(30), 10, 20)
    alone = joints_of(list(both_ways(frames)))
    with_some = list(
        looked_at_both_ways(frames, {"proposals": "network"}, as_told_backwards(frames[::3]))
    )
    np.testing.assert_allclose(joints_of(with_some), alone, atol=1e-9)


def test_bones_keep_their_lengths_and_parts_stay_rotations():
    rng = np.random.default_rng(2)
    frames = hidden_from(swinging(60), 20, 45)
    frames = [
        changed(
            frame,
            joint_covariance_m2=rng.uniform(1e-4, 0.05, (len(JOINT_NAMES), 1, 1)) * np.eye(3),
        )
        for frame in frames
    ]
    both = list(both_ways(frames))
    bones = [joints_of(own)[:, HAND] - joints_of(own)[:, ELBOW] for own in (frames, both)]
    np.testing.assert_allclose(*(np.linalg.norm(bone, axis=-1) for bone in bones), rtol=1e-9)
    Rs = np.stack([frame.people["Ts_camera_part"][0, :, :3, :3] for frame in both])
    np.testing.assert_allclose(
        Rs @ np.swapaxes(Rs, -1, -2), np.broadcast_to(np.eye(3), Rs.shape), atol=1e-9
    )
    assert (np.linalg.det(Rs) > 0.0).all()
    ends = np.stack([frame.people["Ts_camera_part"][0, LEFT_FOREARM, :3, 3] for frame in both])
    np.testing.assert_allclose(ends, joints_of(both)[:, ELBOW], atol=1e-9)


def test_how_a_pelvis_is_turned_does_not_turn_the_legs():
    frames = hidden_from(swinging(40), 10, 30)
    turned = []
    for f, frame in enumerate(frames):
        Ts = frame.people["Ts_camera_part"][0].copy()
        Ts[LOWER_TORSO, :3, :3] @= rotations_from_angles(np.array([0.0, 0.5 * np.sin(f), 0.1]))
        turned.append(changed(frame, Ts_camera_part=Ts))
    legs, of_turned = (
        np.stack([own.people["Ts_camera_part"][0, LEFT_UPPER_LEG:, :3, 1] for own in both_ways(of)])
        for of in (frames, turned)
    )
    np.testing.assert_allclose(of_turned, legs, atol=1e-9)


def test_where_nothing_was_proposed_doubt_counts_for_less():
    frames = hidden_from(swinging(60), 20, 40)
    proposed, alone = (
        joints_of(list(looked_at_both_ways(frames, {"proposals": word})))
        for word in ("network", "none")
    )
    off_proposed, off_alone = (
        np.linalg.norm(own - joints_of(frames), axis=-1)[20:40] for own in (proposed, alone)
    )
    assert (off_alone.mean(0) < off_proposed.mean(0)).all()


def test_who_and_states_and_times_are_left():
    frames = hidden_from(swinging(20), 5, 15)
    for before, after in zip(frames, both_ways(frames), strict=True):
        for name in ("id", "height_m", "joint_state"):
            np.testing.assert_array_equal(after.people[name], before.people[name])
        assert (after.index, after.timestamp_s, after.name) == (
            before.index,
            before.timestamp_s,
            before.name,
        )


def test_joints_are_about_as_sure_as_the_surer_way():
    true = swinging(90)
    forward, backward = hidden_from(true, 30, 50), as_told_backwards(hidden_from(true, 60, 80))
    both = list(looked_at_both_ways(forward, {}, backward))
    variances_m2 = np.stack([own.people["joint_covariance_m2"][0, HAND, 0, 0] for own in both])
    assert (variances_m2[:30] < KNOWN_M2).all()
    assert (variances_m2 < 0.1 * HIDDEN_M2).all()


def test_what_both_ways_have_in_two_places_may_be_in_either():
    """Standing still, 10 cm apart, and alike sure: the covariance reaches from one to the other,
    and nowhere else."""
    one = hidden_from(swinging(20), 0, 20)
    aside = hidden_from(swinging(20, x_m=0.1), 0, 20)
    both = list(looked_at_both_ways(one, {}, as_told_backwards(aside)))
    for frame in both:
        covariance_m2 = frame.people["joint_covariance_m2"][0, HAND]
        spread_m2 = 0.05**2
        np.testing.assert_allclose(covariance_m2[0, 0] - covariance_m2[1, 1], spread_m2, rtol=1e-4)
        np.testing.assert_allclose(covariance_m2[0, 1], 0.0, atol=1e-8)
        assert frame.people["joint_confidence"][0, HAND] < 0.9


def test_where_either_way_tells_nothing_joints_are_as_sure_as_forward():
    frames = swinging(10)
    flat = [
        changed(frame, joint_covariance_m2=np.zeros((len(JOINT_NAMES), 3, 3))) for frame in frames
    ]
    for forward, backward in ((frames, flat), (flat, frames)):
        both = list(looked_at_both_ways(forward, {}, as_told_backwards(backward)))
        for before, after in zip(forward, both, strict=True):
            for name in ("joint_covariance_m2", "joint_confidence"):
                np.testing.assert_array_equal(after.people[name], before.people[name])


def test_of_joints_behind_another_smoothing_leaves_less():
    seen = hidden_from(swinging(20), 0, 20)
    behind = [
        changed(frame, joint_state=np.full(len(JOINT_NAMES), int(JointState.OCCLUDED_BY_PERSON)))
        for frame in seen
    ]
    of_seen, of_behind = (
        list(both_ways(frames))[10].people["joint_covariance_m2"][0, HAND, 0, 0]
        for frames in (seen, behind)
    )
    assert of_behind < of_seen < HIDDEN_M2


def test_parts_that_are_not_tracked_stay_absent():
    frames = []
    for frame in swinging(10):
        Ts, joints = frame.people["Ts_camera_part"][0], frame.people["joints_camera"][0]
        joints[LEGS] = np.nan
        Ts[LEFT_UPPER_LEG:] = np.nan
        frame.people["joint_covariance_m2"][0][LEGS] = np.nan
        frames.append(frame)
    for before, after in zip(frames, both_ways(frames), strict=True):
        for name in ("joints_camera", "Ts_camera_part", "joint_covariance_m2"):
            np.testing.assert_array_equal(
                np.isnan(after.people[name]), np.isnan(before.people[name])
            )


@pytest.mark.parametrize("why", ["a pause", "a leap"])
def test_nobody_is_smoothed_over_a_pause_or_a_leap(why):
    """What comes after changes nothing of what was before."""
    frames = swinging(30)
    later = swinging(30, x_m=3.0 if why == "a leap" else 0.5)
    wait_s = 1.0 + (AWAY_S + 0.1 if why == "a pause" else 0.0)
    later = [
        replace(own, index=own.index + 30, timestamp_s=own.timestamp_s + wait_s) for own in later
    ]
    alone = joints_of(list(both_ways(frames)))
    np.testing.assert_array_equal(joints_of(list(both_ways(frames + later)))[:30], alone)


def test_so_many_seconds_are_held_and_no_seam_shows():
    """A long recording is worked on a piece at a time; a piece knows enough of its neighbours."""
    frame_s = 0.1
    frames = hidden_from(swinging(450, x_m=-8.0, frame_s=frame_s), 195, 212)
    given = 0

    def counted():
        nonlocal given
        for frame in frames:
            given += 1
            yield frame

    most_held, out = 0, []
    for frame in both_ways(counted()):
        out.append(frame)
        most_held = max(most_held, given - len(out))
    assert most_held <= (CHUNK_S + 2 * LAG_S) / frame_s
    assert [frame.index for frame in out] == [frame.index for frame in frames]
    steps_m = np.linalg.norm(np.diff(joints_of(out)[:, HAND], n=2, axis=0), axis=-1)
    assert steps_m.max() < 0.02


def test_nothing_gives_nothing():
    assert list(both_ways([])) == []


class Told:
    """A tracker that tells what is given to it."""

    def __init__(self, frames: list[TrackedFrame]) -> None:
        self.told = SkeletonSequence.from_frames(frames, ABOUT)
        self.finder = SimpleNamespace(floor=None)

    def update(self, frame: Frame) -> list[Person]:
        return self.told.people_in(frame.index)

    def settings_as_json(self) -> dict[str, Any]:
        return {"method": "told"}


def test_a_recording_is_told_so_and_on_frame_is_told_before():
    frames = hidden_from(swinging(20), 5, 15)
    camera = Camera(fx=60.0, fy=60.0, cx=15.5, cy=11.5, width=32, height=24)
    images = [
        Frame(own.index, own.timestamp_s, np.zeros((24, 32), np.float32), camera) for own in frames
    ]
    shown: list[np.ndarray] = []
    result = track_recording(
        cast(Recording, Images(images, camera)),
        on_frame=lambda _, people: shown.append(people[0].joints_camera),
        tracker=cast(Tracker, Told(frames)),
        offline=True,
    )
    assert result.skeletons.settings == {"recording": "images", "method": "told", "offline": True}
    np.testing.assert_array_equal(shown, joints_of(frames))
    expected = joints_of(list(looked_at_both_ways(frames, {})))
    np.testing.assert_array_equal(result.skeletons.joints_camera[:, 0], expected)


class Images(list[Frame]):
    """Frames as a recording."""

    def __init__(self, frames: list[Frame], camera: Camera) -> None:
        super().__init__(frames)
        self.name, self.camera, self.problems = "images", camera, []
