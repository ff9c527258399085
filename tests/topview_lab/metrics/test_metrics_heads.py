"""People found by their heads: who counts, who is nobody, who kept the id, who waited."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from topview_lab.metrics.heads import HEAD_GATE_M, PeopleFound, measure_heads

F = 30
TWO = np.broadcast_to(np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0]]), (F, 2, 3))


def measured(found, visible=None, heads=TWO) -> PeopleFound:
    visible = np.ones(heads.shape[:2]) if visible is None else visible
    is_seen = np.isfinite(found).all(-1)
    return measure_heads(heads, visible, np.arange(F) / 30, found, is_seen)


@given(order=st.permutations([0, 1]), error_m=st.floats(0.0, 0.9 * HEAD_GATE_M))
def test_whoever_is_near_is_found_whatever_the_ids(order, error_m):
    result = measured(TWO[:, order] + [0.0, error_m, 0.0])
    assert (result.false, result.swaps) == (0, 0)
    for person in result.people:
        assert (person.frames, person.wait_s) == (F, 0.0)
        np.testing.assert_allclose(person.errors_m, error_m, atol=1e-9)


def test_whoever_is_far_from_everybody_is_nobody():
    found = np.concatenate([TWO, TWO[:, :1] + [0.0, 0.0, 1.0]], axis=1)
    assert measured(found).false == F
    assert measured(TWO[:, :1]).people[1].wait_s == np.inf


def test_who_is_hidden_counts_neither_as_missed_nor_as_false():
    visible = np.ones((F, 2))
    visible[10:20, 1] = 0.2
    found = np.array(TWO)
    result = measured(found, visible)
    assert [person.frames for person in result.people] == [F, F - 10]
    assert [len(person.errors_m) for person in result.people] == [F, F - 10]
    assert result.false == 0


def test_the_wait_is_from_when_enough_is_visible():
    visible, found = np.ones((F, 2)), np.array(TWO)
    visible[:6, 1] = 0.3
    found[:12, 1] = np.nan
    assert [person.wait_s for person in measured(found, visible).people] == [0.0, 6 / 30]


def test_an_exchange_of_ids_is_seen_by_both():
    found = np.array(TWO)
    found[15:] = found[15:, ::-1]
    assert measured(found).swaps == 2


def test_an_id_is_kept_over_hiding_or_it_is_not():
    visible = np.ones((F, 2))
    visible[10:20, 1] = 0.0
    found = np.full((F, 3, 3), np.nan)
    found[:, :2] = TWO
    kept = measured(found, visible).people[1]
    assert (kept.returns, kept.kept) == (1, 1)
    found[20:, 2], found[10:, 1] = TWO[20:, 1], np.nan
    lost = measured(found, visible).people[1]
    assert (lost.returns, lost.kept) == (1, 0)
    assert measured(found, visible).swaps == 1
