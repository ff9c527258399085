"""No broken file, odd name or option ends in anything but a line and an exit status."""

from __future__ import annotations

import os
import sys
import time

import pytest

from fuzz import running
from fuzz.cases import Case, cases, families
from fuzz.running import Ending, outcome_of, run_apart, run_case, table

CASES, SEED = 300, 1


@pytest.fixture(scope="module")
def endings(compiled) -> list[Ending]:
    return list(run_apart(CASES, SEED))


@pytest.mark.slow
def test_every_case_ends_in_a_result_or_in_a_clean_line(endings):
    """`scripts/fuzz.py --only FAMILY --cases 1 --seed N` runs one that a failure names."""
    print(table(endings))
    assert len(endings) == CASES
    bad = [ending for ending in endings if not ending.is_fine]
    told = [f"{ending.outcome}: {ending.case}\n{ending.said[-600:]}" for ending in bad[:10]]
    assert not bad, "\n".join([f"{len(bad)} of {CASES} cases:", *told])


@pytest.mark.slow
def test_what_is_broken_is_mostly_refused_and_sometimes_read(endings):
    """A corpus of which all were refused for one and the same reason would say little."""
    outcomes = [ending.outcome for ending in endings]
    assert outcomes.count("clean line") > CASES // 3
    assert outcomes.count("result") > CASES // 20


def test_cases_are_the_same_every_time_and_each_family_has_its_turn(tmp_path):
    count = len(families())
    first = list(cases(2 * count, SEED))
    assert first == list(cases(2 * count, SEED))
    assert first != list(cases(2 * count, SEED + 1))
    assert {case.family for case in first[:count]} == families().keys()
    assert {case.seed for case in first} == {SEED, SEED + 1}


@pytest.mark.parametrize(
    ("status", "said", "outcome"),
    [
        (0, "", "result"),
        (0, "topview: frame 3 is missing\n", "result"),
        (2, "topview: x: no such file\n", "clean line"),
        (2, "", "noise"),
        (2, "libpng error: CRC\ntopview: x\n", "noise"),
        (2, "topview: x\n" * (running.MOST_LINES + 1), "noise"),
        (2, "topview: " + "x" * running.MOST_LONGEST, "noise"),
        (1, "topview: a bug of topview (KeyError: 3)\n", "traceback"),
        (2, "Traceback (most recent call last):\n", "traceback"),
        (2, "topview: not enough memory: 12 GB\n", "over memory"),
        (2, "topview: is damaged (Unable to allocate 3 GiB for an array)\n", "over memory"),
        (139, "", "status 139"),
    ],
)
def test_endings_are_told_apart(status, said, outcome):
    assert outcome_of(status, said) == outcome


def ends_with_2(arguments):
    os.write(2, b"topview: no\n")
    sys.exit(2)


def hangs(arguments):
    while True:
        time.sleep(0.01)


def says_by_itself(arguments):
    os.write(2, b"libpng error\n")


def fails(arguments):
    raise KeyError(3)


@pytest.mark.parametrize(
    ("command", "outcome"),
    [
        (ends_with_2, "clean line"),
        (hangs, "hang"),
        (says_by_itself, "noise"),
        (fails, "traceback"),
        (lambda arguments: None, "result"),
    ],
)
def test_a_command_is_seen_through(tmp_path, monkeypatch, command, outcome):
    monkeypatch.setattr(running, "MOST_SECONDS", 0.05)
    (tmp_path / "bases").mkdir()
    case = Case("words | 0", 1)
    assert run_case(case, tmp_path / "bases", command).outcome == outcome
    assert list(tmp_path.iterdir()) == [tmp_path / "bases"]
