"""Means that forget, and turns: the same whatever steps the time is cut into."""

from __future__ import annotations

from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.filter.over_time import Turns, share_after
from topview.filter.particles import time_key

STEPS_S = st.lists(st.floats(0.0, 2.0), min_size=1, max_size=40)


@given(STEPS_S, st.floats(0.05, 10.0))
def test_what_is_forgotten_depends_on_the_time_alone(steps_s: list[float], memory_s: float) -> None:
    left = np.prod([1.0 - share_after(step_s, memory_s) for step_s in steps_s])
    assert left == pytest.approx(1.0 - share_after(sum(steps_s), memory_s), abs=1e-9)


def test_no_time_and_a_clock_that_runs_backwards_teach_nothing() -> None:
    assert share_after(0.0, 0.5) == share_after(-1.0, 0.5) == 0.0
    assert share_after(1e6, 0.5) == 1.0


@given(STEPS_S, st.floats(0.02, 1.0))
def test_turns_come_as_often_however_frames_come(steps_s: list[float], every_s: float) -> None:
    turns, times_s = Turns(every_s), [0.0, *accumulate(steps_s)]
    due = [turns.due(time_s) for time_s in times_s]
    assert due[0] == 1
    assert sum(due) == pytest.approx(1.0 + times_s[-1] / every_s, abs=1.0)


def test_a_turn_for_each_frame_comes_in_each_though_timestamps_are_rounded() -> None:
    turns = Turns(1 / 30)
    assert {turns.due(round(k / 30, 3)) for k in range(300)} == {1}


def test_a_clock_that_runs_backwards_makes_no_turn_due() -> None:
    turns = Turns(0.1)
    assert [turns.due(time_s) for time_s in (5.0, 1.0, 1.0, 1.1)] == [1, 0, 0, 1]


def test_a_moment_is_its_whole_microseconds() -> None:
    assert time_key(1 / 3) == 333333
    assert time_key(0.1 + 0.2) == time_key(0.3)
    assert time_key(-1.0) != time_key(1.0)
    assert 0 <= time_key(-1.0) < 2**63
