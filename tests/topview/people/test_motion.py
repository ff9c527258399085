"""The motion of a head: a Kalman filter's laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topview.people.motion import MEASURED_M, PAUSE_S, VELOCITY_MEMORY_S, Motion

seeds = st.integers(0, 10_000)
steps_s = st.floats(0.0, PAUSE_S)


def walked(seed: int, steps: int = 6) -> Motion:
    """After some random steps, each with a measurement."""
    rng = np.random.default_rng(seed)
    motion = Motion.starting_at(rng.normal(size=3))
    for _ in range(steps):
        motion = motion.predicted(rng.uniform(0.0, 0.4))
        motion = motion.updated(motion.position_camera + 0.1 * rng.normal(size=3))
    return motion


def is_positive(motion: Motion) -> bool:
    pp, pv, vv = motion.covariance
    return pp > 0.0 and vv > 0.0 and pp * vv > pv**2


@settings(max_examples=50)
@given(seed=seeds, step_s=st.floats(-1.0, 10.0), steps=st.integers(1, 200))
def test_the_covariance_stays_positive(seed: int, step_s: float, steps: int) -> None:
    motion = walked(seed)
    assert is_positive(motion)
    for _ in range(steps):
        motion = motion.updated(motion.position_camera)
    assert is_positive(motion)
    assert is_positive(motion.predicted(step_s))


@given(seed=seeds, step_s=steps_s, share=st.floats(0.0, 1.0))
def test_two_predictions_are_one_over_the_whole_time(
    seed: int, step_s: float, share: float
) -> None:
    motion = walked(seed)
    once = motion.predicted(step_s)
    twice = motion.predicted(share * step_s).predicted((1.0 - share) * step_s)
    np.testing.assert_allclose(twice.position_camera, once.position_camera, atol=1e-9)
    np.testing.assert_allclose(twice.velocity, once.velocity, atol=1e-9)
    # The noise of the acceleration is that of a velocity that does not fade.
    assert twice.sigma_m == pytest.approx(once.sigma_m, rel=0.15)


@given(seed=seeds, step_s=steps_s)
def test_a_prediction_is_less_sure_and_no_farther_than_the_velocity_lasts(
    seed: int, step_s: float
) -> None:
    motion = walked(seed)
    ahead = motion.predicted(step_s)
    assert ahead.sigma_m >= motion.sigma_m - 1e-12 or motion.covariance[1] < 0.0
    way_m = float(np.linalg.norm(ahead.position_camera - motion.position_camera))
    assert way_m <= VELOCITY_MEMORY_S * float(np.linalg.norm(motion.velocity)) + 1e-9
    assert np.linalg.norm(ahead.velocity) <= np.linalg.norm(motion.velocity) + 1e-9


@given(seed=seeds, step_s=st.floats(0.01, PAUSE_S))
def test_a_measurement_draws_the_motion_to_it_and_makes_it_surer(seed: int, step_s: float) -> None:
    before = walked(seed).predicted(step_s)
    offset = np.random.default_rng(seed).normal(size=3)
    after = before.updated(before.position_camera + offset)
    drawn = after.position_camera - before.position_camera
    share = float(drawn @ offset / (offset @ offset))
    np.testing.assert_allclose(drawn, share * offset, atol=1e-9)
    assert 0.0 < share < 1.0
    assert float((after.velocity - before.velocity) @ offset) * before.covariance[1] >= 0.0
    assert after.sigma_m < min(before.sigma_m, MEASURED_M)
    assert after.covariance[2] <= before.covariance[2]


@given(seed=seeds, step_s=steps_s)
def test_the_density_is_one_in_all_and_highest_where_the_head_is_expected(
    seed: int, step_s: float
) -> None:
    motion = walked(seed).predicted(step_s)
    away = np.random.default_rng(seed).normal(size=3)
    away /= np.linalg.norm(away)
    radii_m, shell_m = np.linspace(
        0.0, 8.0 * np.hypot(motion.sigma_m, MEASURED_M), 400, retstep=True
    )
    density = np.exp([motion.log_density(motion.position_camera + r * away) for r in radii_m])
    assert float((4.0 * np.pi * radii_m**2 * density).sum() * shell_m) == pytest.approx(
        1.0, abs=1e-3
    )
    assert (np.diff(density) < 0.0).all()


def test_a_pause_counts_for_no_more_than_its_beginning() -> None:
    motion = walked(3)
    for ahead in (motion.predicted(60.0), motion.predicted(PAUSE_S)):
        np.testing.assert_array_equal(
            ahead.position_camera, motion.predicted(PAUSE_S).position_camera
        )
    np.testing.assert_array_equal(motion.predicted(-1.0).position_camera, motion.position_camera)
