"""Fig. 3.2: a cylinder's shell fills the fewest cells when looked at along its axis."""

from __future__ import annotations

import numpy as np
import pytest

from topview_lab.reproduce.shells import (
    LENGTH_M,
    SHELLS,
    SPACING_M,
    VIEW_TILTS_DEG,
    Shell,
    minima,
    ratios,
)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.mark.parametrize("shell", SHELLS, ids=lambda shell: shell.name)
def test_the_ratio_has_one_minimum_and_it_is_the_top_view(shell, rng):
    found = minima(ratios(shell, rng))
    assert len(found) == 1
    assert abs(VIEW_TILTS_DEG[found[0]]) <= 3.0


@pytest.mark.parametrize("shell", SHELLS, ids=lambda shell: shell.name)
def test_points_lie_on_the_shell(shell, rng):
    x, y, z = shell.points(rng).T
    a, b = shell.radii_m
    assert np.all((y >= 0) & (y <= LENGTH_M))
    assert np.hypot(x / a, z / b) == pytest.approx(
        np.ones(len(x)), abs=5 * shell.noise_m / b + 1e-9
    )


def test_an_object_hides_as_many_points_as_the_name_says(rng):
    whole = len(Shell("", (0.2, 0.1), np.pi).points(rng))
    for hidden, share in (((0.6, 0.5), 0.3), ((0.8, 0.75), 0.6)):
        rest = len(Shell("", (0.2, 0.1), np.pi, hidden).points(np.random.default_rng(0)))
        assert 1 - rest / whole == pytest.approx(share, abs=0.04)


def test_points_are_as_dense_as_the_cells(rng):
    a, b = 0.12, 0.12
    points = Shell("", (a, b)).points(rng)
    area = 2 * np.pi * a * LENGTH_M
    assert area / len(points) == pytest.approx(SPACING_M**2, rel=0.02)


def test_two_valleys_count_as_two_minima():
    ratio = np.ones(len(VIEW_TILTS_DEG))
    ratio[[10, 40]] = 0.2, 0.1
    assert minima(ratio) == [40, 10]


def test_ripples_do_not_count_as_minima():
    ratio = np.abs(VIEW_TILTS_DEG) / 90 + 0.02 * np.sin(VIEW_TILTS_DEG)
    assert len(minima(ratio)) == 1
