"""The background is learnt; people who stand still are not, and changes of light are noticed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from detect_scenes import CAMERA, SHIRT_RGB, Disc, frame_of, view_of
from topview.detect.background import (
    BackgroundMixtures,
    LightChangeDetector,
    StillBackground,
    depth_levels,
)
from topview.records import SENSOR_NOISE, Camera, DepthNoise, SensorName

PERSON: Disc = (80.0, 60.0, 20.0, 2.0, SHIRT_RGB)
FAR_PERSON: Disc = (80.0, 60.0, 20.0, 2.85, SHIRT_RGB)
NOBODY = np.zeros((120, 160), np.bool_)
ANYBODY = ~NOBODY


def is_person(disc: Disc) -> np.ndarray:
    rows, columns = np.mgrid[:120, :160]
    return np.hypot(columns - disc[0], rows - disc[1]) <= disc[2]


def learnt(frames: int = 40, camera: Camera = CAMERA) -> BackgroundMixtures:
    room = BackgroundMixtures()
    for index in range(frames):
        view = view_of(frame_of(index=index, camera=camera))
        room.foreground(view)
        room.update(view, NOBODY)
    return room


def test_everything_may_be_somebody_before_anything_is_learnt() -> None:
    assert BackgroundMixtures().foreground(view_of(frame_of())).all()


@pytest.mark.parametrize("sensor", SENSOR_NOISE)
def test_levels_are_as_wide_as_the_noise_at_any_depth(sensor: str) -> None:
    noise = SENSOR_NOISE[sensor]
    depth_m = np.linspace(0.8, 8.0, 50, dtype=np.float32)[None]
    near_m, far_m = (depth_m + sign * noise.sigma_m(depth_m) for sign in (-1.0, 1.0))
    rise = depth_levels(near_m, noise) - depth_levels(far_m, noise)
    np.testing.assert_allclose(rise, 4.0, atol=1.1 if sensor == "tof" else 0.1)
    assert (np.diff(depth_levels(depth_m, noise)) < 0.0).all()
    assert depth_levels(np.zeros((1, 1), np.float32), noise) == 0.0


def test_a_noise_of_three_terms_has_levels_too() -> None:
    noise = DepthNoise(0.003, 0.004, 0.001)
    depth_m = np.arange(1.0, 6.0, 0.01).astype(np.float32)[None]
    rise = -np.diff(depth_levels(depth_m, noise)) / np.diff(depth_m)
    np.testing.assert_allclose(rise, 2.0 / noise.sigma_m(depth_m[:, 1:]), rtol=0.1)


@pytest.mark.parametrize("sensor", SENSOR_NOISE)
def test_who_steps_before_the_room_is_found(sensor: SensorName) -> None:
    camera = replace(CAMERA, sensor=sensor)
    room = learnt(camera=camera)
    for disc in (PERSON, FAR_PERSON):
        if sensor == "stereo" and disc is FAR_PERSON:
            continue  # less before the wall than four standard deviations of its noise
        found = room.foreground(view_of(frame_of([disc], index=50, camera=camera)))
        truth = is_person(disc)
        assert found[truth].mean() > 0.98
        assert found[~truth].mean() < 0.01


def test_a_person_who_stands_still_for_a_minute_does_not_melt_away() -> None:
    room, found = learnt(), NOBODY
    truth = is_person(PERSON)
    for index in range(40, 40 + 60 * 10):
        view = view_of(frame_of([PERSON], index=index, fps=10.0))
        found = room.foreground(view)
        room.update(view, truth)
    assert found[truth].mean() > 0.98
    gone = room.foreground(view_of(frame_of(index=700, fps=10.0)))
    assert gone.mean() < 0.01


def test_what_nobody_claims_becomes_part_of_the_room() -> None:
    room, found = learnt(), ~NOBODY
    for index in range(40, 40 + 20 * 10):
        view = view_of(frame_of([PERSON], index=index, fps=10.0))
        found = room.foreground(view)
        room.update(view, NOBODY)
    assert found.mean() < 0.01


def test_who_stood_there_from_the_start_leaves_the_room_behind() -> None:
    room, found = BackgroundMixtures(), ~NOBODY
    truth = is_person(PERSON)
    for index in range(20):
        view = view_of(frame_of([PERSON], index=index))
        room.foreground(view)
        room.update(view, truth)
    assert room.foreground(view_of(frame_of([PERSON], index=20)))[truth].mean() > 0.98
    for index in range(20, 120):
        view = view_of(frame_of(index=index))
        found = room.foreground(view)
        room.update(view, NOBODY)
    assert found.mean() < 0.01


def test_a_change_of_light_is_background_and_learnt_soon() -> None:
    room = learnt()
    truth = is_person(PERSON)
    noticed = []
    for index in range(40, 80):
        view = view_of(frame_of([PERSON], index=index, gain=1.5))
        found = room.foreground(view)
        noticed.append(room.light_changed)
        room.update(view, truth)
        assert found[truth].mean() > 0.98
        assert found[~truth].mean() < 0.01
    assert noticed[0]
    assert not any(noticed[30:])


def test_colour_decides_where_there_is_no_reading() -> None:
    room = learnt()
    frame = frame_of([PERSON], index=50)
    depth_m = frame.depth_m.copy()
    depth_m[:, 80:] = 0.0
    blind = type(frame)(50, frame.timestamp_s, depth_m, frame.camera, frame.color)
    found = room.foreground(view_of(blind))
    truth = is_person(PERSON)
    assert found[truth].mean() > 0.95
    assert found[~truth].mean() < 0.02


def test_another_image_size_starts_anew() -> None:
    room = learnt()
    camera = type(frame_of().camera)(262.5, 262.5, 39.5, 29.5, 80, 60)
    assert room.foreground(view_of(frame_of(camera=camera))).all()


@pytest.mark.parametrize("fps", [30.0, 10.0])
def test_a_change_of_light_is_detected_by_the_background_colour_alone(fps: float) -> None:
    detector, truth = LightChangeDetector(), is_person(PERSON)
    noticed = []
    for index in range(120):
        gain = 1.5 if index >= 60 else 1.0
        detector.update(view_of(frame_of([PERSON], index=index, fps=fps, gain=gain)), truth)
        noticed.append(detector.light_changed)
    assert not any(noticed[:60])
    assert any(noticed[60 : 60 + int(0.3 * fps)])
    assert not any(noticed[90:])


def test_a_person_who_walks_by_is_no_change_of_light() -> None:
    detector = LightChangeDetector()
    for index in range(80):
        walker: Disc = (3.0 * index - 40.0, 60.0, 30.0, 2.0, SHIRT_RGB)
        detector.update(view_of(frame_of([walker], index=index)), NOBODY)
        assert not detector.light_changed


def test_updates_are_eight_a_second_at_any_rate_of_frames() -> None:
    for fps in (120.0, 30.0, 8.0):
        room, updates = BackgroundMixtures(), 0
        for index in range(int(4 * fps)):
            view = view_of(frame_of(index=index, fps=fps))
            updates += room.is_update_due(view)
            room.update(view, NOBODY)
        assert 30 <= updates <= 36


def test_furniture_is_room_and_who_moves_is_not() -> None:
    chair: Disc = (40.0, 80.0, 15.0, 2.5, SHIRT_RGB)
    room = StillBackground()
    for index in range(60):
        walker: Disc = (50.0 + index, 60.0, 10.0, 2.0, SHIRT_RGB)
        view = view_of(frame_of([chair, walker], index=index))
        is_seen = ~room.before(view, ANYBODY)
        room.update(view, NOBODY)
        if index > 25:  # away from where the first frame, that tells all, showed it
            assert not is_seen[is_person(walker)].any()
            assert is_seen[~is_person(walker)].mean() > 0.98


def test_what_keeps_still_becomes_room_unless_it_is_somebody() -> None:
    for mask, becomes_room in ((NOBODY, True), (is_person(PERSON), False)):
        room = StillBackground()
        room.update(view_of(frame_of()), NOBODY)
        for index in range(1, 40):
            view = view_of(frame_of([PERSON], index=index, fps=10.0))
            if index < 15:
                assert room.before(view, ANYBODY)[is_person(PERSON)].all()
            room.update(view, mask)
        still = view_of(frame_of([PERSON], index=40, fps=10.0))
        share = 1.0 - room.before(still, ANYBODY)[is_person(PERSON)].mean()
        assert share > 0.95 if becomes_room else share == 0.0
        left = room.before(view_of(frame_of(index=41, fps=10.0)), ANYBODY)
        assert left.mean() < 0.01
