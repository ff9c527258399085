"""Beliefs over face, left and right hand (Eq. 4.8 - 4.10)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.detect.beliefs import FEATURES, THESIS_FEATURES, BeliefTables, Feature, Kind
from topview.records import InputError

features = st.dictionaries(st.sampled_from(list(FEATURES)), st.floats(-5, 5))


@given(st.lists(features, min_size=1, max_size=6), st.floats(0.0, 1.0))
def test_beliefs_sum_to_one_and_none_is_ever_lost(observations: list, elapsed_s: float) -> None:
    tables = BeliefTables.load()
    belief = None
    for observation in observations:
        belief = tables.updated([belief], [observation], elapsed_s)[0]
        assert belief.sum() == pytest.approx(1.0)
        assert (belief > 0.0).all()


@given(features)
def test_the_likelihood_is_the_product_of_the_tables(observation: dict) -> None:
    tables = BeliefTables.load()
    product = np.ones(len(Kind))
    for name, value in observation.items():
        product *= tables.tables[name][:, FEATURES[name].bin(value)]
    assert np.allclose(tables.likelihoods([observation]), product)


@given(st.floats(-10, 10))
def test_bins_cover_every_value(value: float) -> None:
    feature = Feature(-1.0, 2.0, 6)
    b = feature.bin(value)
    assert 0 <= b < 6
    if -1.0 <= value < 2.0:
        assert -1.0 + 0.5 * b - 1e-9 <= value <= -1.0 + 0.5 * (b + 1) + 1e-9


def two_kinds() -> BeliefTables:
    """Faces are large, left hands small and to the right."""
    seen = [{"major_m": 0.13}] * 50 + [{"major_m": 0.06, "right_of_head_m": 0.3}] * 50
    kinds = [Kind.FACE] * 50 + [Kind.LEFT_HAND] * 50
    return BeliefTables.learn(seen, kinds, "two kinds")


def test_what_was_learnt_is_recognised_and_can_be_won_back() -> None:
    tables = two_kinds()
    belief = tables.updated([None], [{"major_m": 0.13}], 0.0)[0]
    assert belief.argmax() == Kind.FACE
    for _ in range(100):
        belief = tables.updated([belief], [{"major_m": 0.13}], 1 / 30)[0]
    frames = 0
    while belief.argmax() != Kind.LEFT_HAND:
        belief = tables.updated([belief], [{"major_m": 0.06}], 1 / 30)[0]
        frames += 1
    assert 1 < frames < 30


def test_an_observation_weighs_as_much_as_it_is_new() -> None:
    tables = two_kinds()
    belief = np.full(4, 0.25)
    fast = belief
    for _ in range(4):
        fast = tables.updated([fast], [{"major_m": 0.06}], 0.02)[0]
    assert np.allclose(fast, tables.updated([belief], [{"major_m": 0.06}], 0.08)[0])


def test_tables_are_written_and_read(tmp_path: Path) -> None:
    file = tmp_path / "tables.npz"
    file.write_bytes(two_kinds().npz())
    read = BeliefTables.load(file)
    assert read.trained_on == "two kinds"
    assert np.allclose(read.tables["major_m"], two_kinds().tables["major_m"], atol=1e-6)
    file.write_bytes(b"no tables")
    with pytest.raises(InputError, match="train-hands"):
        BeliefTables.load(file)


def test_features_can_be_left_out() -> None:
    only = BeliefTables.load().only(THESIS_FEATURES)
    assert set(only.tables) == set(THESIS_FEATURES)
    assert np.allclose(only.likelihoods([{"major_m": 0.1}]), 1.0)
