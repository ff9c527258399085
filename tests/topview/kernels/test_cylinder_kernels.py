from __future__ import annotations

import numpy as np
import pytest

from topview.geometry.rotations import rotations_from_angles
from topview.kernels.cylinders import may_touch
from topview.score.utvr import placed_parts

RADII_M = np.array([0.08, 0.05])


def cylinder(rng):
    """R, origin and length."""
    R = rotations_from_angles(rng.uniform(-np.pi, np.pi, 3))
    return R, rng.uniform(-0.3, 0.3, 3), rng.uniform(0.1, 0.5)


@pytest.mark.parametrize("seed", range(5))
def test_cylinders_that_share_a_place_may_touch_and_far_ones_do_not(seed):
    rng = np.random.default_rng(seed)
    answers = []
    for _ in range(40):
        (R, origin, length), (R_other, origin_other, length_other) = cylinder(rng), cylinder(rng)
        turns, heights = rng.uniform(0, 2 * np.pi, 500), rng.uniform(0, length, 500)
        surface = np.stack(
            [RADII_M[0] * np.cos(turns), heights, RADII_M[1] * np.sin(turns)], axis=1
        )
        x, y, z = ((surface @ R.T + origin - origin_other) @ R_other).T
        inside = (y >= 0) & (y <= length_other)
        inside &= (x / RADII_M[0]) ** 2 + (z / RADII_M[1]) ** 2 <= 1.0
        (other,) = placed_parts(
            R_other[None], origin_other[None], np.array([length_other]), RADII_M[None]
        )
        may = may_touch(
            R.astype(np.float32), origin.astype(np.float32), np.float32(length),
            np.float32(RADII_M.max()), other,
        )  # fmt: skip
        assert may or not inside.any()
        answers.append(may)
    assert not all(answers)
