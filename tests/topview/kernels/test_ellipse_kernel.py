from __future__ import annotations

import numpy as np
import pytest

from topview.kernels.ellipses import move_ellipses

SCALE_M, WEIGHT, PRIOR_WEIGHT = 0.05, 40.0, 1000.0


def moved(points, semi_axes, turns, expected, iterations):
    """The same in NumPy, for all turns at once."""
    cos, sin = np.cos(turns), np.sin(turns)
    Rs = np.stack([np.stack([cos, -sin], 1), np.stack([sin, cos], 1)], 1)
    found, costs = expected.copy(), np.zeros(len(turns))
    for iteration in range(iterations + 1):
        own = np.einsum("kab,knb->kna", Rs, points - found[:, None])
        size = np.sqrt(((own / semi_axes) ** 2).sum(-1))
        gradient = own / semi_axes**2 / size[..., None]
        steepness = np.linalg.norm(gradient, axis=-1)
        gaps, normals = (size - 1.0) / steepness, gradient / steepness[..., None]
        robust = 1.0 / (1.0 + (gaps / SCALE_M) ** 2)
        off = found - expected
        costs = WEIGHT * (robust * gaps**2).sum(1) + PRIOR_WEIGHT * (off**2).sum(1)
        if iteration < iterations:
            slopes = -np.einsum("kna,kab->knb", normals, Rs)
            pulled = slopes * (WEIGHT * robust**2)[..., None]
            A = np.einsum("kna,knb->kab", pulled, slopes) + PRIOR_WEIGHT * np.eye(2)
            b = (pulled * gaps[..., None]).sum(1) + PRIOR_WEIGHT * off
            found = found - np.linalg.solve(A, b[..., None])[..., 0]
    return costs, found


@pytest.mark.parametrize("iterations", [0, 1, 4])
def test_the_kernel_is_its_definition(iterations):
    rng = np.random.default_rng(iterations)
    points, semi_axes = rng.normal(0.0, 0.15, (50, 2)), np.array([0.18, 0.1])
    turns, expected = np.linspace(-3.0, 3.0, 12), rng.normal(0.0, 0.02, (12, 2))
    costs, centres = np.empty(12), np.empty((12, 2))
    weights = WEIGHT, SCALE_M, PRIOR_WEIGHT
    move_ellipses(points, semi_axes, turns, expected, *weights, iterations, costs, centres)
    true_costs, true_centres = moved(points, semi_axes, turns, expected, iterations)
    np.testing.assert_allclose(costs, true_costs, rtol=1e-9)
    np.testing.assert_allclose(centres, true_centres, atol=1e-9)
