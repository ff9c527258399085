"""Heads by depth, by colour, by both: the same people, with what the recording allows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from topview.camera.pyramid import Pyramid
from topview.detect.detectors import DetectorName
from topview.people.finder import PeopleFinder, PeopleSettings
from topview.people.users import User
from topview.records import Frame, InputError
from topview_lab.sim import SimulatedRecording, scene_by_name
from topview_lab.sim.bodies import SIM_JOINT_NAMES

FRAMES = 8


@pytest.fixture(scope="module")
def recording() -> SimulatedRecording:
    return SimulatedRecording(scene_by_name("two_users", seed=5, frames=FRAMES))


@pytest.fixture(scope="module")
def filmed(recording: SimulatedRecording) -> list[Frame]:
    return list(recording)


@pytest.fixture(scope="module")
def true_heads(recording: SimulatedRecording) -> NDArray[np.float64]:
    """[2, 3] in the last frame."""
    return recording.simulate(FRAMES - 1).truth.joints[:, SIM_JOINT_NAMES.index("head")]


def last_users(frames: list[Frame], detector: DetectorName) -> list[User]:
    finder = PeopleFinder(PeopleSettings(detector=detector))
    users: list[User] = []
    for frame in frames:
        users = finder.update(Pyramid(frame))
    return users


# By faces alone one of the two is not believed: no head is known beside which to look for one.
@pytest.mark.parametrize(("detector", "found"), [("auto", 2), ("depth", 2), ("skin", 1)])
def test_each_finds_people_who_face_the_camera(
    filmed: list[Frame], true_heads: NDArray[np.float64], detector: DetectorName, found: int
) -> None:
    users = last_users(filmed, detector)
    assert len(users) >= found
    for user in users:
        assert user.head_is_seen
        assert np.linalg.norm(true_heads - user.head_camera, axis=1).min() < 0.06
        assert (user.face_share is None) == (detector == "depth")


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda color: None,
        lambda color: np.repeat(color.mean(2, keepdims=True), 3, 2).astype(np.uint8),
        lambda color: (color // 16).astype(np.uint8),
        lambda color: np.full_like(color, 255),
    ],
    ids=["no colour", "grey", "underexposed", "overexposed"],
)
def test_without_usable_colour_auto_is_as_good_as_depth(filmed: list[Frame], spoilt) -> None:
    frames = [replace(frame, color=spoilt(frame.color)) for frame in filmed]
    by_all, by_depth = last_users(frames, "auto"), last_users(frames, "depth")
    for user, other in zip(by_all, by_depth, strict=True):
        assert user.id == other.id
        assert np.array_equal(user.head_camera, other.head_camera)
        assert np.array_equal(user.pixels, other.pixels)
        assert user.face_share is None


def test_a_lamp_that_is_switched_on_loses_nobody(filmed: list[Frame]) -> None:
    dark = [replace(f, color=(0.35 * f.color.astype(float)).astype(np.uint8))
            for f in filmed if f.color is not None]  # fmt: skip
    frames = [*dark[: FRAMES // 2], *filmed[FRAMES // 2 :]]
    assert [user.id for user in last_users(frames, "auto")] == [
        user.id for user in last_users(filmed, "depth")
    ]


@pytest.mark.parametrize("detector", ["skin", "cascade"])
def test_who_asks_for_colour_alone_must_have_it(
    filmed: list[Frame], detector: DetectorName
) -> None:
    with pytest.raises(InputError, match=f"{detector}.*no colour"):
        last_users([replace(filmed[0], color=None)], detector)
