"""Recordings tracked from the end: frames keep their order, and people are known again."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.records import Camera, Frame, Person
from topview.skeletons import About, TrackedFrame
from topview.track import TrackerSettings, backwards
from topview.track.backwards import ALIKE_M, LEAD_S, TOLD_S, partners, tracked_backwards

ABOUT = About(OUTPUT_JOINT_NAMES, PART_NAMES)
CAMERA = Camera(fx=60.0, fy=60.0, cx=15.5, cy=11.5, width=32, height=24)
FRAME_S = 0.25


def people(**places_m: float) -> np.ndarray:
    """People `p1`, `p2` ... so far to the right."""
    packed = np.zeros(len(places_m), ABOUT.person_type)
    for row, (name, x_m) in zip(packed, places_m.items(), strict=True):
        row["id"] = int(name[1:])
        row["joints_camera"] = [x_m, 0.0, 3.0]
    return packed


def frames(*told: np.ndarray) -> list[TrackedFrame]:
    return [TrackedFrame(f, f * FRAME_S, str(f), own) for f, own in enumerate(told)]


def images(count: int) -> list[Frame]:
    depth_m = np.zeros((24, 32), np.float32)
    return [Frame(f, 5.0 + f * FRAME_S, depth_m, CAMERA) for f in range(count)]


class Counting:
    """A tracker that has one person, whose height tells how many frames it has seen."""

    made: list[Counting]

    def __init__(self, settings: TrackerSettings) -> None:
        self.times_s: list[float] = []
        self.settings = settings
        Counting.made.append(self)

    def update(self, frame: Frame) -> list[Person]:
        self.times_s.append(frame.timestamp_s)
        row = people(p1=0.0)[0]
        row["height_m"] = len(self.times_s)
        return [SimpleNamespace(**{name: row[name] for name in row.dtype.names})]  # type: ignore[list-item]


@pytest.fixture
def counting(monkeypatch):
    Counting.made = []
    monkeypatch.setattr(backwards, "Tracker", Counting)
    return Counting


def test_time_runs_backwards_and_frames_keep_their_order(counting):
    settings = TrackerSettings(seed=7)
    told = list(tracked_backwards(images(20), settings, ABOUT))
    assert [own.index for own in told] == list(range(20))
    assert [own.timestamp_s for own in told] == [own.timestamp_s for own in images(20)]
    assert [own.people["height_m"][0] for own in told] == list(range(20, 0, -1))
    (tracker,) = counting.made
    assert tracker.settings is settings
    np.testing.assert_allclose(tracker.times_s, FRAME_S * np.arange(20))


def test_a_long_recording_is_held_some_at_a_time_each_after_a_lead(counting):
    count = int(3 * TOLD_S / FRAME_S)
    given, most_held, told = 0, 0, []

    def counted():
        nonlocal given
        for frame in images(count):
            given += 1
            yield frame

    for own in tracked_backwards(counted(), TrackerSettings(), ABOUT):
        told.append(own)
        most_held = max(most_held, given - len(told))
    assert [own.index for own in told] == list(range(count))
    assert most_held <= (TOLD_S + LEAD_S) / FRAME_S
    numbers = [int(own.people["id"][0]) for own in told]
    assert sorted(set(numbers)) == list(range(1, len(counting.made) + 1))
    seen_before = [int(own.people["height_m"][0]) for own in told]
    ends = np.flatnonzero(np.diff(numbers))
    assert len(ends) > 1
    assert all(seen_before[k] > LEAD_S / FRAME_S for k in ends)


def test_nothing_gives_nothing(counting):
    assert list(tracked_backwards([], TrackerSettings(), ABOUT)) == []


def test_who_is_alike_is_the_same():
    forward = frames(people(p1=0.0, p2=1.0), people(p1=0.1, p2=1.0))
    found = partners(forward, [people(p9=1.05, p8=0.0), people(p8=0.1)])
    assert [{i: int(own["id"]) for i, own in each.items()} for each in found] == [
        {1: 8, 2: 9},
        {1: 8},
    ]


def test_whoever_was_missed_gets_the_number_that_is_nearest_in_time():
    here, nobody = people(p8=0.0), people()
    forward = frames(people(p1=0.0), nobody, nobody, nobody, people(p2=0.0))
    found = partners(forward, [here] * 5)
    assert [[*each] for each in found] == [[1], [1], [1], [2], [2]]


def test_whoever_is_only_told_of_backwards_is_nobody():
    assert partners(frames(people(), people()), [people(p8=0.0)] * 2) == [{}, {}]


def test_whoever_is_alike_in_few_frames_is_another():
    apart = people(p8=2.0 * ALIKE_M)
    forward = frames(*[people(p1=0.0)] * 4)
    assert [len(own) for own in partners(forward, [people(p8=0.0), apart, apart, apart])] == [
        *(1, 0, 0, 0)
    ]


def test_whoever_is_elsewhere_for_a_while_stays_the_same():
    apart = people(p8=2.0 * ALIKE_M)
    found = partners(frames(*[people(p1=0.0)] * 3), [people(p8=0.0), apart, people(p8=0.0)])
    assert [[*own] for own in found] == [[1], [1], [1]]


def test_nobody_is_taken_for_two_people_in_one_frame():
    """Elsewhere than the own number, at the place of another, it is that one there."""
    forward = frames(*[people(p1=0.0, p2=1.0)] * 3)
    here = people(p8=0.0)
    found = partners(forward, [here, here, people(p8=1.0)])
    assert [[*own] for own in found] == [[1], [1], [2]]
