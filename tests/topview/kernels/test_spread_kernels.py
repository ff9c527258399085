"""Of many places some that are far from each other: the kernels and their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from topview.kernels.spread import cheapest_apart, farthest_first

SEEDS = range(5)


def places_and_costs(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.standard_normal((60, 3)), rng.integers(0, 20, 60).astype(np.float64)


@pytest.mark.parametrize("seed", SEEDS)
def test_each_next_place_is_the_farthest_from_the_start_and_all_before(seed):
    places, _ = places_and_costs(seed)
    start, taken = places[7] + 0.1, np.empty(12, np.int64)
    farthest_first(places, start, taken)
    known = [start]
    for index in taken:
        away = np.linalg.norm(places[:, None] - np.array(known), axis=-1).min(1)
        assert away[index] == away.max()
        known.append(places[index])


def test_all_places_are_taken_if_so_many_are_asked_for():
    places, _ = places_and_costs(0)
    taken = np.empty(len(places), np.int64)
    farthest_first(places, places[0], taken)
    assert_array_equal(np.sort(taken), np.arange(len(places)))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("apart", [0.0, 1.0, 2.0])
def test_the_cheapest_places_are_apart(seed, apart):
    places, costs = places_and_costs(seed)
    expected: list[int] = []
    for index in np.argsort(costs, kind="stable"):
        away = np.linalg.norm(places[expected] - places[index], axis=1)
        if (away > apart).all() and len(expected) < 9:
            expected.append(int(index))
    chosen = np.empty(9, np.int64)
    assert_array_equal(chosen[: cheapest_apart(costs, places, apart, chosen)], expected)


def test_what_is_nowhere_far_from_the_cheapest_is_left_out():
    places, costs = places_and_costs(0)
    chosen = np.empty(9, np.int64)
    assert cheapest_apart(costs, places, 100.0, chosen) == 1
    assert chosen[0] == costs.argmin()
