"""People found by their heads: who is due, who is nobody, who kept the id, who waited."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.records import InputError
from topview_lab.metrics.heads import HEAD_GATE_M, PeopleFound, TrueHeads, measure_heads

F = 60
TWO = np.broadcast_to(np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0]]), (F, 2, 3))


def measured(found, to_be_seen=None, outside=None, heads=TWO, ids=None) -> PeopleFound:
    to_be_seen = np.ones(heads.shape[:2]) if to_be_seen is None else to_be_seen
    outside = np.zeros(heads.shape[:2]) if outside is None else outside
    present = np.ones(heads.shape[:2], bool)
    ids = np.tile(np.arange(1, found.shape[1] + 1), (F, 1)) if ids is None else ids
    truth = TrueHeads(heads, to_be_seen, outside, present)
    return measure_heads(truth, found, ids, np.arange(F) / 30)


@given(order=st.permutations([0, 1]), error_m=st.floats(0.0, 0.9 * HEAD_GATE_M))
def test_whoever_is_near_is_found_whatever_the_ids(order, error_m):
    result = measured(TWO[:, order] + [0.0, error_m, 0.0])
    assert (result.false, result.exchanges, result.recall) == (0, 0, 1.0)
    for person in result.people:
        assert (person.frames, person.wait_s) == (F, 0.0)
        np.testing.assert_allclose(person.errors_m, error_m, atol=1e-9)


def test_whoever_matches_nobody_is_false_even_beside_somebody():
    """Two tracks on one person: one of them is nobody."""
    found = np.concatenate([TWO, TWO[:, :1] + [0.0, 0.0, 0.2]], axis=1)
    assert measured(found).false == F
    lonely = measured(TWO[:, :1])
    assert (lonely.people[1].wait_s, lonely.recall) == (np.inf, 0.5)


def test_who_cannot_be_seen_counts_neither_as_missed_nor_as_false():
    to_be_seen = np.ones((F, 2))
    to_be_seen[10:20, 1] = 0.2
    for found in (np.array(TWO), np.where(to_be_seen[..., None] < 0.3, np.nan, TWO)):
        result = measured(found, to_be_seen)
        assert [person.frames for person in result.people] == [F, F - 10]
        assert (result.recall, result.false) == (1.0, 0)


def test_whoever_is_not_in_the_room_is_matched_by_nobody():
    heads = np.array(TWO)
    heads[30:, 1] = np.nan
    result = measured(np.array(TWO), heads=heads)
    assert (result.due, result.false) == (F + 30, F - 30)


def test_the_wait_is_from_when_half_is_to_be_seen():
    to_be_seen, found = np.ones((F, 2)), np.array(TWO)
    to_be_seen[:6, 1] = 0.4
    found[:12, 1] = np.nan
    waits_s = [person.wait_s for person in measured(found, to_be_seen).people]
    assert waits_s == [0.0, pytest.approx(6 / 30)]


def test_an_exchange_of_ids_is_two_swaps():
    ids = np.tile([1, 2], (F, 1))
    ids[15:] = [2, 1]
    result = measured(np.array(TWO), ids=ids)
    assert [(p.swaps, p.fragments) for p in result.people] == [(1, 0), (1, 0)]


def test_a_fresh_id_is_a_fragment_unless_somebody_was_outside_for_long():
    ids = np.tile([1, 2], (F, 1))
    ids[50:, 1] = 3
    for frames_outside, fragments in ((0, 1), (20, 1), (40, 0)):
        outside, to_be_seen, found = np.zeros((F, 2)), np.ones((F, 2)), np.array(TWO)
        gone = np.s_[50 - frames_outside : 50, 1]
        outside[gone], to_be_seen[gone], found[gone] = 1.0, 0.0, np.nan
        result = measured(found, to_be_seen, outside, ids=ids)
        assert (result.people[1].swaps, result.people[1].fragments) == (0, fragments)


def test_an_id_is_kept_over_hiding_or_it_is_not():
    to_be_seen, found = np.ones((F, 2)), np.array(TWO)
    to_be_seen[10:20, 1], found[10:20, 1] = 0.0, np.nan
    kept = measured(found, to_be_seen).people[1]
    assert (kept.returns, kept.kept) == (1, 1)
    ids = np.tile([1, 2], (F, 1))
    ids[20:, 1] = 3
    lost = measured(found, to_be_seen, ids=ids).people[1]
    assert (lost.returns, lost.kept, lost.fragments) == (1, 0, 1)


def test_shares_and_shapes_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match=r"to_be_seen holds 1\.5; a share must be 0 to 1"):
        measured(np.array(TWO), np.full((F, 2), 1.5))
    with pytest.raises(InputError, match=r"outside is \(60, 1\); it must be \(60, 2\)"):
        measured(np.array(TWO), outside=np.zeros((F, 1)))
