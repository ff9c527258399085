"""Laws of sampling, importance and resampling."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from topview.filter.particles import generator, importance_weights, n_best, systematic_resample

scores = arrays(np.float64, st.integers(1, 40), elements=st.floats(1e-3, 1e3))
shares = arrays(np.float64, st.integers(1, 40), elements=st.floats(0.0, 1.0)).filter(
    lambda w: w.sum() > 1e-3
)


@given(scores)
def test_weights_sum_to_one_and_fall_with_the_score(f):
    w = importance_weights(f)
    assert w.sum() == pytest.approx(1.0)
    assert_allclose(w * f, w[0] * f[0])


@pytest.mark.parametrize("f", [[np.inf, np.inf], [0.0, 0.0, 0.0]])
def test_weights_without_any_difference_are_even(f):
    assert_allclose(importance_weights(np.array(f)), 1.0 / len(f))


def test_hypotheses_without_evidence_weigh_nothing():
    assert_array_equal(importance_weights(np.array([2.0, np.inf, 2.0])), [0.5, 0.0, 0.5])


@given(shares, st.integers(1, 200), st.integers(0, 2**32))
def test_every_parent_is_drawn_as_often_as_its_weight_says(w, count, seed):
    w = w / w.sum()
    parents = systematic_resample(w, count, np.random.default_rng(seed))
    assert len(parents) == count
    times = np.bincount(parents, minlength=len(w))
    assert (np.abs(times - count * w) < 1.0 + 1e-9).all()


@pytest.mark.parametrize("count", [1, 3])
def test_over_many_draws_every_parent_has_its_share(count):
    """Also one whose weight is too little to be drawn every time."""
    w = np.array([0.05, 0.25, 0.7])
    drawn = [systematic_resample(w, count, np.random.default_rng(seed)) for seed in range(2000)]
    assert_allclose(np.bincount(np.ravel(drawn)) / (2000 * count), w, atol=0.03)


@given(arrays(np.float64, st.integers(0, 30), elements=st.sampled_from([0.5, 1.0, 2.0, np.inf])),
       st.integers(0, 40))  # fmt: skip
def test_n_best_are_the_lowest_and_ties_keep_their_order(f, count):
    best = n_best(f, count)
    in_order = sorted(range(len(f)), key=lambda index: (f[index], index))
    assert_array_equal(best, in_order[:count])


counters = st.tuples(st.integers(0, 100), st.integers(0, 10), st.integers(0, 2**40))


@given(st.integers(0, 2**63 - 1), counters)
def test_the_same_counters_give_the_same_numbers(seed, at):
    first, again = generator(seed, *at), generator(seed, *at)
    assert_array_equal(first.standard_normal(8), again.standard_normal(8))


def test_other_counters_give_other_numbers():
    seeds_and_counters = [(s, p, k, f) for s in (0, 1) for p in (1, 2) for k in (0, 1, 2)
                          for f in (0, 1, 7)]  # fmt: skip
    drawn = np.array([generator(*at).random(64) for at in seeds_and_counters])
    assert len(np.unique(drawn)) == drawn.size
