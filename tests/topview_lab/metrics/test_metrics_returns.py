"""Who was hidden entirely and comes back, by heads that are told."""

from __future__ import annotations

import numpy as np
import pytest

from topview_lab.metrics.heads import TrueHeads
from topview_lab.metrics.returns import Return, score_return, summarise_returns

F, FPS = 10, 10.0
HIDDEN = slice(3, 6)
TIMES_S = np.arange(F) / FPS


def truth_of(to_be_seen: list[float] | None = None) -> TrueHeads:
    """Two people; the first is hidden from frame 3 to 5, and half to be seen from frame 7 on."""
    shares = np.ones((F, 2))
    shares[:, 0] = [1, 1, 1, 0.02, 0, 0.1, 0.2, 0.6, 1, 1] if to_be_seen is None else to_be_seen
    heads = np.tile([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0]], (F, 1, 1))
    return TrueHeads(heads, shares, np.zeros((F, 2)), np.ones((F, 2), np.bool_))


def score(first_ids: list[int], second_id: int = 2, truth: TrueHeads | None = None) -> Return:
    """Of the first person, found under these ids, 0 where not found."""
    truth = truth or truth_of()
    ids = np.stack([np.array(first_ids), np.full(F, second_id)], axis=1)
    found = np.where((ids > 0)[..., None], truth.heads_camera, np.nan)
    return score_return(truth, found, ids, TIMES_S, 0)


def test_who_is_found_again_under_the_same_id_has_kept_it():
    result = score([0, 1, 1, 0, 0, 0, 0, 0, 1, 1])
    assert result.kept
    assert result.hidden_s == pytest.approx(0.3)
    assert result.wait_s == pytest.approx(0.1)  # half to be seen in frame 7, found in frame 8


def test_who_is_found_early_has_not_waited_and_who_is_told_while_hidden_is_no_matter():
    result = score([1, 1, 1, 1, 7, 7, 1, 1, 1, 1])
    assert (result.wait_s, result.kept) == (0.0, True)


@pytest.mark.parametrize(
    "ids",
    [
        [1, 1, 1, 0, 0, 0, 0, 3, 3, 3],  # a fresh one
        [1, 1, 1, 0, 0, 0, 0, 3, 1, 1],  # mended later
        [0, 0, 0, 0, 0, 0, 0, 1, 1, 1],  # never found before
        [1, 1, 3, 0, 0, 0, 0, 1, 1, 1],  # another one just before
    ],
)
def test_another_id_before_or_after_is_not_the_same(ids):
    assert not score(ids).kept


def test_who_is_never_found_again_waits_for_ever():
    result = score([1, 1, 1, 0, 0, 0, 0, 0, 0, 0])
    assert not result.kept
    assert result.wait_s == np.inf


def test_the_longest_time_hidden_counts():
    truth = truth_of([0, 1, 0, 0, 0, 1, 1, 0, 1, 1])
    result = score([0, 1, 0, 0, 0, 1, 1, 0, 5, 5], truth=truth)
    assert result.hidden_s == pytest.approx(0.3)
    assert not result.kept


def test_returns_are_summed():
    summary = summarise_returns([Return(2.0, 0.1, True), Return(3.0, np.inf, False)])
    assert (summary.count, summary.hidden_s, summary.kept, summary.found) == (2, 2.5, 0.5, 0.5)
    assert (summary.wait_median_s, summary.wait_95_s) == (0.1, np.inf)
