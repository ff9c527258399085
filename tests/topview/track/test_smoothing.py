"""Smoothed bodies are quieter, stay whole, and lag no more than is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from moving_bodies import pose
from topview import InputError, Person, Tracker, TrackerSettings
from topview.body import OUTPUT_JOINT_NAMES, PART_NAMES
from topview.body.hierarchy import articulated
from topview.track.smoothing import MOST_LAG_M, MOST_LAG_RAD, Smoothing

RATE_HZ = 30.0
HAND = OUTPUT_JOINT_NAMES.index("left_hand")
ELBOW = OUTPUT_JOINT_NAMES.index("left_elbow")
FOREARM = PART_NAMES.index("left_forearm")


def person(turns: np.ndarray | None = None, place: tuple[float, ...] = (0, -0.6, 3)) -> Person:
    joints, Ts = pose(np.zeros((11, 3)) if turns is None else turns, place=place)
    states = np.ones(len(OUTPUT_JOINT_NAMES), np.uint8)
    return Person(1, 1.8, joints, states, np.ones(len(OUTPUT_JOINT_NAMES), np.float32), Ts)


def smoothed(people: list[Person], smoothing_s: float = 0.2) -> list[Person]:
    smoothing = Smoothing(smoothing_s)
    return [smoothing.update([p], f / RATE_HZ)[0] for f, p in enumerate(people)]


def test_who_stands_still_is_told_with_less_noise_and_whole_bones():
    rng = np.random.default_rng(2)
    noisy = [
        person(0.03 * rng.normal(size=(11, 3)), (*(0.01 * rng.normal(size=2) + (0, -0.6)), 3))
        for _ in range(120)
    ]
    given, told = (
        np.stack([p.joints_camera for p in people]) for people in (noisy, smoothed(noisy))
    )
    assert (told[30:].std(0).max(-1) < 0.6 * given[30:].std(0).max(-1)).all()
    Ts = np.stack([p.Ts_camera_part for p in smoothed(noisy)])
    np.testing.assert_allclose(articulated(told, Ts).joints_camera(), told, atol=1e-9)
    # The forearm still begins at the elbow, and the hand is where it was on it.
    np.testing.assert_allclose(Ts[:, FOREARM, :3, 3], told[:, ELBOW], atol=1e-9)
    on_forearm = np.linalg.solve(
        Ts[:, FOREARM], np.insert(told[:, HAND], 3, 1.0, axis=1)[..., None]
    )
    np.testing.assert_allclose(on_forearm, np.tile(on_forearm[0], (120, 1, 1)), atol=1e-9)


@pytest.mark.parametrize("speed_m_s", [0.05, 1.0, 5.0])
def test_who_walks_is_told_behind_by_less_than_is_said(speed_m_s):
    places = [(speed_m_s * f / RATE_HZ, -0.6, 3.0) for f in range(90)]
    told = smoothed([person(place=place) for place in places])[-1]
    behind_m = person(place=places[-1]).joints_camera - told.joints_camera
    memory_s = 0.2 / (1.0 + speed_m_s * 0.2 / MOST_LAG_M)
    lag_m = speed_m_s / RATE_HZ / np.expm1(1.0 / RATE_HZ / memory_s)
    np.testing.assert_allclose(behind_m, np.tile([lag_m, 0, 0], (20, 1)), atol=0.01 * lag_m)
    assert behind_m.max() < min(MOST_LAG_M, 0.2 * speed_m_s)


def test_an_arm_that_swings_lags_less_than_is_said_and_moves_nothing_else():
    turns = np.zeros((120, 11, 3))
    turns[:, PART_NAMES.index("left_upper_arm"), 0] = 2.0 * np.arange(120) / RATE_HZ
    raw = person(turns[-1])
    told = smoothed([person(turn) for turn in turns])[-1]
    arm_m = np.linalg.norm(raw.joints_camera[HAND] - raw.joints_camera[ELBOW - 1])
    behind_m = np.linalg.norm(told.joints_camera - raw.joints_camera, axis=-1)
    assert 0.02 < behind_m[HAND] < MOST_LAG_RAD * arm_m
    assert behind_m[OUTPUT_JOINT_NAMES.index("right_hand")] < 1e-9


def test_jumps_absences_and_unknown_legs_are_taken_as_they_are():
    legs = [name.endswith("leg") for name in PART_NAMES]
    half = person()
    Ts, joints = half.Ts_camera_part.copy(), half.joints_camera.copy()
    Ts[legs], joints[[n.endswith(("hip", "knee", "ankle", "foot")) for n in OUTPUT_JOINT_NAMES]] = (
        np.nan,
        np.nan,
    )
    half = replace(half, Ts_camera_part=Ts, joints_camera=joints)
    far = person(place=(1.0, -0.6, 3.0))
    turned = np.zeros((11, 3))
    turned[FOREARM, 0] = 2.0
    flipped = person(turned, (1.0, -0.6, 3.0))
    smoothing = Smoothing(1.0)
    for f, given in enumerate([half, half, person(), far, flipped]):
        (told,) = smoothing.update([given], f / RATE_HZ)
        np.testing.assert_allclose(told.joints_camera, given.joints_camera, atol=1e-9)
    assert smoothing.update([], 1.0) == []
    assert smoothing.update([half], 1.1) == [half]


def test_it_is_off_unless_asked_for():
    assert "smoothing_s" not in Tracker().settings_as_json()
    assert Tracker(TrackerSettings(smoothing_s=0.1)).settings_as_json()["smoothing_s"] == 0.1
    with pytest.raises(InputError, match=r"smoothing_s is 3\.0; it must be 0 to 2"):
        TrackerSettings(smoothing_s=3)
