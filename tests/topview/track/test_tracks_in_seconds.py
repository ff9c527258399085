"""Tracks follow the clock, not the count of frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from rates import at_rate
from topview.records import Frame, Person
from topview.track import Tracker, TrackerSettings
from topview_lab.sim import SimulatedRecording, scene_by_name

FRAMES = 60
NUMBERINGS = {
    "every fifth, from 1": range(1, 5 * FRAMES, 5),
    "every third, from 7": range(7, 7 + 3 * FRAMES, 3),
    "as it comes": np.cumsum(np.random.default_rng(0).integers(1, 50, FRAMES)).tolist(),
    "great ones": range(10**9 - FRAMES, 10**9),
}


def frames_of(scene: str, frames: int | None = None) -> list[Frame]:
    return list(SimulatedRecording(scene_by_name(scene, frames=frames)))


@pytest.fixture(scope="module")
def two_users() -> list[Frame]:
    return frames_of("two_users", FRAMES)


def tracked(frames: Sequence[Frame]) -> dict[float, dict[int, Person]]:
    """People by id, by timestamp."""
    tracker = Tracker(TrackerSettings(threads=1))
    return {
        frame.timestamp_s: {person.id: person for person in tracker.update(frame)}
        for frame in frames
    }


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "frames"), [("two_users", FRAMES), ("walk", None)])
def test_every_second_frame_gives_the_same_skeletons(scene, frames):
    """At most 1.5 cm (median) and 6 cm (95 %) apart, and the same identities;
    `scripts/measure_half_rate.py` measures whole scenes."""
    recording = frames_of(scene, frames)
    full, half = tracked(recording), tracked(at_rate(recording, 15))
    apart_cm = []
    for time_s, people in half.items():
        assert people.keys() == full[time_s].keys()
        for person_id, person in people.items():
            other = full[time_s][person_id]
            apart = np.linalg.norm(person.joints_camera - other.joints_camera, axis=1)
            apart_cm.append(100 * apart)
    assert np.median(apart_cm) < 1.5
    assert np.quantile(apart_cm, 0.95) < 6.0


@pytest.mark.slow
@pytest.mark.parametrize("numbering", NUMBERINGS)
def test_the_numbers_of_frames_do_not_matter(two_users, numbering):
    """Bit for bit, at the same times."""
    usual = tracked(two_users)
    numbers = NUMBERINGS[numbering]
    now = tracked([replace(frame, index=n) for frame, n in zip(two_users, numbers, strict=True)])
    assert any(usual.values())
    assert usual.keys() == now.keys()
    for time_s, people in usual.items():
        assert people.keys() == now[time_s].keys()
        for person_id, person in people.items():
            other = now[time_s][person_id]
            assert person.height_m == other.height_m
            for name in ("joints_camera", "joint_state", "joint_confidence", "Ts_camera_part"):
                np.testing.assert_array_equal(getattr(person, name), getattr(other, name))
