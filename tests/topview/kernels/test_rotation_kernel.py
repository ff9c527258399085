"""Hypotheses turned from their parents, against the definition."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from topview.geometry.rotations import rotations_from_angles
from topview.kernels.rotations import turn_parents


def test_hypotheses_are_their_parents_turned_in_their_own_frames():
    rng = np.random.default_rng(2)
    Rs = rotations_from_angles(rng.uniform(-3.0, 3.0, (5, 3)))
    parents, angles_rad = rng.integers(0, 5, 40), rng.uniform(-3.0, 3.0, (40, 3))
    turned = np.empty((40, 3, 3))
    turn_parents(Rs, parents, angles_rad, turned)
    assert_allclose(turned, Rs[parents] @ rotations_from_angles(angles_rad), atol=1e-12)
