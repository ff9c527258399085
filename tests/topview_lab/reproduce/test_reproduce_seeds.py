"""Whose simulated people are measured, and what is recorded of them."""

from __future__ import annotations

from itertools import combinations

from topview_lab.reproduce.catalogue import EXPERIMENTS
from topview_lab.reproduce.context import Context
from topview_lab.reproduce.page import Report, as_html, as_markdown
from topview_lab.reproduce.provenance import provenance
from topview_lab.seeds import (
    FOREST_HELD_OUT_SEED,
    HANDS_HELD_OUT_SEEDS,
    HANDS_LEARNT_SEEDS,
    SEED_USES,
    Knowledge,
    detection_seed,
    report_seed,
    use_of,
)


def seeds_by_experiment(context: Context) -> dict[str, list[int]]:
    return {name: experiment.seeds(context) for name, experiment in EXPERIMENTS.items()}


def test_a_seed_is_recorded_once():
    for a, b in combinations(SEED_USES, 2):
        assert not any(seed in a and seed in b for seed in range(9000)), (a.label, b.label)


def test_every_seed_of_the_default_report_is_recorded(tmp_path):
    for name, seeds in seeds_by_experiment(Context(tmp_path)).items():
        assert all(use_of(seed).knowledge != Knowledge.UNRECORDED for seed in seeds), name


def test_what_the_history_says_of_some_seeds():
    for seed in (12, 503, report_seed(0, 1), report_seed(0, 83), detection_seed(1, 0)):
        assert use_of(seed).knowledge == Knowledge.LOOKED_AT
    for seed in (0, *HANDS_LEARNT_SEEDS):
        assert use_of(seed).knowledge == Knowledge.FITTED
    for seed in (*HANDS_HELD_OUT_SEEDS, 11, 13, report_seed(0, 84), detection_seed(3, 1)):
        assert use_of(seed).knowledge == Knowledge.NUMBERS_READ
    assert use_of(report_seed(1, 0)).knowledge == Knowledge.UNRECORDED
    assert use_of(FOREST_HELD_OUT_SEED - 1).knowledge == Knowledge.UNRECORDED


def test_the_report_tells_every_seed_and_what_is_recorded_of_it(tmp_path):
    context = Context(tmp_path, seed=6)
    section = provenance(seeds_by_experiment(context))
    assert section.numbers["detection"]["looked at"] == [7600, 7601, 7602, 7603, 7604]
    assert section.numbers["users"]["no use recorded"] == [6670, 6671, 6672]
    told = {row.cells[0] for row in section.tables[0].rows}
    assert told == set(EXPERIMENTS) - {"figure-3.2"}  # which has no scene
    report = Report("A report", (), (), appendix=(section,))
    for render in (as_markdown, as_html):
        page = render(report, tmp_path)
        for told in ("6670, 6671, 6672", "7600 to 7699", "looked at", "UTD-MHAD", "b3_stand60"):
            assert told in page


def test_every_seed_of_an_experiment_is_in_one_column(tmp_path):
    numbers = provenance(seeds_by_experiment(Context(tmp_path))).numbers
    for told in numbers.values():
        columns = [told[kind.value] for kind in Knowledge]
        assert sorted(seed for column in columns for seed in column) == told["seeds"]
