"""Who is found, and when, does not depend on how often frames come, nor on their numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import topview
from rates import FPS, after_pause, at_rate, renumbered
from topview.camera.pyramid import Pyramid
from topview.people.finder import PeopleFinder
from topview.people.users import User
from topview.records import Frame
from topview_lab.sim import SimulatedRecording, scene_by_name

PAUSE_S = 10.0
AGAIN_S = 0.5
SOON_S = 0.3


@cache
def filmed(scene: str, frames: int, seed: int = 0) -> tuple[Frame, ...]:
    return tuple(SimulatedRecording(scene_by_name(scene, seed=seed, frames=frames)))


def found_in(frames: list[Frame]) -> list[list[User]]:
    finder = PeopleFinder()
    return [finder.update(Pyramid(frame)) for frame in frames]


def first_seen_s(frames: list[Frame]) -> dict[int, float]:
    """When each user was found, by the id."""
    first: dict[int, float] = {}
    for frame, users in zip(frames, found_in(frames), strict=True):
        for user in users:
            first.setdefault(user.id, frame.timestamp_s)
    return first


def check_found_in_time(
    frames: list[Frame], fps: int, others: list[Frame] | None = None, late: int = 0
) -> None:
    """`others` are the same at another rate; else frames are left out, or shown several times. From
    the first frame on that could show it, somebody may be found so many frames late."""
    shown = others or at_rate(frames, fps)
    usual, now = first_seen_s(frames), first_seen_s(shown)
    assert usual.keys() == now.keys()
    for number, time_s in usual.items():
        due_s = next(frame.timestamp_s for frame in shown if frame.timestamp_s > time_s - 1e-6)
        latest_s = max(time_s + SOON_S, due_s + late / fps + 1e-6)
        assert time_s - SOON_S <= now[number] <= latest_s, number


@pytest.mark.slow
@pytest.mark.parametrize("fps", [5, 15, 60, 120])
def test_who_enters_is_found_as_soon_at_any_rate_of_frames(fps: int) -> None:
    check_found_in_time(list(filmed("enter_and_leave", 90)), fps)


@pytest.mark.slow
@pytest.mark.parametrize("fps", [5, 15, 60])
def test_who_enters_is_found_as_soon_in_a_scene_that_is_rendered_at_any_rate(fps: int) -> None:
    frames = list(filmed("enter_and_leave", 90))
    scene = scene_by_name("enter_and_leave", frames=3 * fps)
    check_found_in_time(frames, fps, list(SimulatedRecording(replace(scene, fps=fps))))


@pytest.mark.slow
@pytest.mark.parametrize("fps", [5, 15, 60, 120])
def test_who_passes_by_is_found_as_soon_at_any_rate_of_frames(shared: Path, fps: int) -> None:
    """A new head is confirmed once it was seen twice, and moved or was clearly a person's: of one
    who is half in the picture at first, that takes up to three frames."""
    frames = list(topview.open(shared / "bench" / "b1_pass_by"))[:90]
    check_found_in_time(frames, fps, late=3)


@pytest.mark.parametrize(("first", "step"), [(1, 5), (7, 3), (0, 0)])
def test_the_numbers_of_frames_do_not_matter(first: int, step: int) -> None:
    frames = list(filmed("hug", 45, seed=11))
    usual, now = found_in(frames), found_in(renumbered(frames, first, step))
    for users, others in zip(usual, now, strict=True):
        assert [user.id for user in users] == [user.id for user in others]
        for user, other in zip(users, others, strict=True):
            np.testing.assert_array_equal(user.head_camera, other.head_camera)
            np.testing.assert_array_equal(user.pixels, other.pixels)
            assert (user.height_m, user.face_share) == (other.height_m, other.face_share)


@pytest.mark.parametrize("left_out", [0, 10])
@pytest.mark.parametrize("fps", [5, 30])
def test_after_a_pause_everybody_is_found_again(fps: int, left_out: int) -> None:
    """They stand where they were, or went on for a third of a second."""
    frames = list(filmed("two_users", 60))
    before = frames[:31]
    after = after_pause(frames[30 + left_out :], PAUSE_S)
    found = found_in([*at_rate(before, fps), *at_rate(after, fps)])[len(at_rate(before, fps)) :]
    known = {user.id for user in found_in(at_rate(before, fps))[-1]}
    soon = round(AGAIN_S * fps)
    for users in found[soon : soon + 3]:
        assert {user.id for user in users} == known
        assert all(user.head_is_seen for user in users)


@pytest.mark.parametrize("fps", [5, 30])
def test_who_is_hidden_when_a_pause_ends_is_who_he_was(fps: int) -> None:
    """For 0.3 s after it something is held before the camera."""
    frames = list(filmed("two_users", 60))
    before, after = frames[:30], after_pause(frames[30:], PAUSE_S)
    after[:9] = [replace(frame, depth_m=np.full_like(frame.depth_m, 0.8)) for frame in after[:9]]
    found = found_in([*at_rate(before, fps), *at_rate(after, fps)])[len(before) * fps // FPS :]
    soon = round((0.3 + AGAIN_S) * fps)
    assert not any(user.head_is_seen for user in found[0])
    assert all(user.head_is_seen for user in found[soon])
    assert {user.id for user in found[soon]} == {1, 2}


@pytest.mark.parametrize("times_s", [(0.0,) * 6, (0.0, 0.1, 0.05, 0.05, -0.1, 0.0)])
def test_a_clock_that_stands_still_or_runs_backwards_loses_nobody(
    times_s: tuple[float, ...],
) -> None:
    frames = filmed("two_users", 6)
    stamped = [
        replace(frame, timestamp_s=time_s) for frame, time_s in zip(frames, times_s, strict=True)
    ]
    assert [len(users) for users in found_in(stamped)] == [2] * len(frames)
