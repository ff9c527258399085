"""Joints over time: what is seen again and again is known better, and what moves is followed."""

from __future__ import annotations

import numpy as np
import pytest

from topview.detect.joints import JointProposals
from topview.track.joint_filter import JointFilter, JointFilterSettings

FRAME_S = 1.0 / 30.0
START = np.array([[[0.4, -0.2, 2.0], [-0.5, 0.6, 3.5]]])  # one mode of two joints
SPEED_M_S = np.array([0.6, -0.3, 0.9])
SCALES_M = (0.02, 0.03, 0.04)


def proposals(places: np.ndarray) -> JointProposals:
    scales_m = np.broadcast_to(SCALES_M, (1, *places.shape)).copy()
    return JointProposals(places[None], scales_m, np.ones((1, 1)), np.ones(1), ("head", "neck"))


def filtered(places: np.ndarray) -> np.ndarray:
    """[F, 1, 2, 3] of as many frames."""
    joints = JointFilter(JointFilterSettings())
    updates = [joints.update(proposals(p), FRAME_S) for p in places]
    for update in updates:
        assert update.scales_m[0, 0, 0] == pytest.approx(SCALES_M)
    return np.array([update.positions_camera[0] for update in updates])


def test_noise_is_averaged() -> None:
    rng = np.random.default_rng(0)
    noise = rng.laplace(0.0, SCALES_M, (300, 1, 2, 3))
    off = np.abs(filtered(START + noise) - START)[10:].mean(axis=(0, 1, 2))
    assert (off < 0.9 * np.abs(noise)[10:].mean(axis=(0, 1, 2))).all()


def test_what_stays_and_what_moves_evenly_is_where_it_is_proposed() -> None:
    times_s = np.arange(60)[:, None, None, None] * FRAME_S
    still = np.repeat(START[None], 60, axis=0)
    assert filtered(still) == pytest.approx(still, abs=1e-12)
    moving = START + times_s * SPEED_M_S
    assert filtered(moving)[40:] == pytest.approx(moving[40:], abs=0.005)


def test_what_has_jumped_starts_anew() -> None:
    there = START + np.array([1.0, 0.0, 0.0])
    places = np.concatenate([np.repeat(START[None], 9, axis=0), there[None]])
    assert filtered(places)[-1] == pytest.approx(there, abs=1e-12)


def test_after_a_pause_what_was_before_does_not_count() -> None:
    joints = JointFilter(JointFilterSettings())
    joints.update(proposals(START), 0.0)
    moved = START + np.array([0.1, 0.0, 0.0])
    late = joints.update(proposals(moved), 5.0)
    assert late.positions_camera[0] == pytest.approx(moved, abs=0.001)
