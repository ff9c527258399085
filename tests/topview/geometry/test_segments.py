"""Distances of points to segments."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from topview.geometry.segments import square_distances

POINTS = np.array([[0.5, 2.0, 0.0], [-3.0, 4.0, 0.0], [1.0, 0.0, 0.0]])
STARTS, ENDS = np.zeros((2, 3)), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def test_nearest_to_the_middle_or_to_an_end() -> None:
    """Of a segment along x, and of one without length."""
    off_m = np.sqrt(square_distances(POINTS, STARTS, ENDS))
    assert_allclose(off_m[:, 0], [2.0, 5.0, 0.0], atol=1e-12)
    assert_allclose(off_m[:, 1], np.linalg.norm(POINTS, axis=1))


def test_no_point_of_a_segment_is_nearer() -> None:
    rng = np.random.default_rng(0)
    points, starts, ends = rng.normal(size=(3, 20, 3))
    shares = np.linspace(0.0, 1.0, 501)[:, None, None]
    sampled = starts + shares * (ends - starts)
    least = ((points[:, None, None] - sampled) ** 2).sum(-1).min(axis=1)
    found = square_distances(points, starts, ends)
    assert (found <= least + 1e-12).all()
    assert_allclose(found, least, atol=1e-4)
