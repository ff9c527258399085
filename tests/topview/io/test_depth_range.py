"""From where to where readings lie, and when that tells of a wrong unit."""

from __future__ import annotations

import numpy as np
import pytest

from topview.io import DepthRange


def ramp(low_m: float, high_m: float) -> np.ndarray:
    """[100, 100] metres, half of it without a reading."""
    depth_m = np.zeros((100, 100), np.float32)
    depth_m[:, ::2] = np.linspace(low_m, high_m, 5000).reshape(100, 50)
    return depth_m


def seen(*images: np.ndarray) -> DepthRange:
    depths = DepthRange()
    for image in images:
        depths.add(image)
    return depths


@pytest.mark.parametrize("scale", [1.0, 0.001, 10.0])
def test_quantiles_are_those_of_the_readings(scale):
    depths = seen(ramp(1.0 * scale, 5.0 * scale))
    for share in (0.01, 0.5, 0.99):
        assert depths.quantile_m(share) == pytest.approx((1.0 + 4.0 * share) * scale, rel=0.01)
    assert depths.valid_share == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("scale", [0.001, 0.05, 15.0])
def test_where_nobody_can_be_the_range_and_what_is_right_are_told(scale):
    problem = seen(ramp(1.0 * scale, 5.0 * scale)).problem
    assert problem.startswith(f"readings lie from {1.04 * scale:.2g} to {4.96 * scale:.2g} m;")
    assert "must be seen at 0.3 to 10 m" in problem
    assert "depth_scale" in problem


def test_a_room_is_no_problem_and_nothing_at_all_is_one():
    assert seen(ramp(1.0, 5.0), ramp(1.0, 90.0)).problem == ""
    assert seen(np.zeros((9, 9), np.float32)).problem.startswith("no pixel has a reading; people")
    assert np.isnan(seen(np.zeros((9, 9), np.float32)).quantile_m(0.5))
