"""The factors of Eq. 3.1, 5.2 and 5.7 - 5.9, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.score.definition import Counts
from topview.score.utvr import MIN_POINTS_INSIDE, UtvrTerms

EXAMPLE = Counts(n_3d=400, n_pr=80, n_dcyl=300, p_in=200, p_occl=60, p_out=40, n_coll=30)


def terms(counts: Counts) -> UtvrTerms:
    return UtvrTerms.from_counts(np.array([counts], np.int32))


def test_factors_by_hand():
    t = terms(EXAMPLE)
    assert t.reproj[0] == pytest.approx(80 / 400)  # Eq. 3.1
    assert t.align[0] == pytest.approx(300 / 400)  # Eq. 5.2
    assert t.occl[0] == pytest.approx(2 - 60 / 300)  # Eq. 5.9
    assert t.ovl[0] == pytest.approx(1 + 40 / 200)
    assert t.coll[0] == pytest.approx(1 + 30 / 300)
    assert t.score[0] == pytest.approx(0.2 * 0.75 * 1.8 * 1.2 * 1.1)  # Eq. 5.7, 5.8
    assert t.has_evidence[0]


@pytest.mark.parametrize(
    "lacking",
    [
        pytest.param(Counts(0, 0, 300, 0, 300, 0, 0), id="no points inside"),
        pytest.param(Counts(0, 0, 0, 0, 0, 0, 0), id="out of view"),
        pytest.param(Counts(400, 80, 300, 0, 0, 300, 0), id="no inliers"),
        pytest.param(Counts(MIN_POINTS_INSIDE - 1, 4, 300, 200, 0, 100, 0), id="too few points"),
    ],
)
def test_a_hypothesis_that_nothing_supports_has_no_evidence(lacking):
    assert not terms(lacking).has_evidence[0]


def test_factors_without_evidence_are_infinite_never_nan():
    t = terms(Counts(0, 0, 0, 0, 0, 0, 0))
    for factor in (t.reproj, t.align, t.ovl, t.score):
        assert factor[0] == np.inf


@given(
    st.integers(1, 500), st.integers(0, 300), st.integers(1, 300), st.integers(0, 300),
    st.integers(0, 300), st.integers(0, 300),
)  # fmt: skip
def test_factors_keep_within_their_ranges(n_3d, n_pr, p_in, p_occl, p_out, n_coll):
    pixels = p_in + p_occl + p_out
    t = terms(Counts(n_3d, min(n_pr, n_3d), pixels, p_in, p_occl, p_out, min(n_coll, pixels)))
    assert 0 <= t.reproj[0] <= 1
    assert 1 <= t.occl[0] <= 2
    assert 1 <= t.coll[0] <= 2
    assert t.ovl[0] >= 1
    assert np.isfinite(t.score[0])


@given(st.integers(1, 50))
def test_outliers_and_collisions_make_it_worse(more):
    outliers = EXAMPLE._replace(n_dcyl=300 + more, p_out=40 + more)
    assert terms(outliers).score[0] > terms(EXAMPLE).score[0]
    assert terms(EXAMPLE._replace(n_coll=30 + more)).score[0] > terms(EXAMPLE).score[0]
