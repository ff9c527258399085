"""Numbers of options: whole where they must be, of a length that means something, finite."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from topview.cli.values import MOST_DIGITS, converted
from topview.records import InputError

WHOLE = [
    ("track", "x", "--out", "y", "--threads"),
    ("track", "x", "--out", "y", "--seed"),
    ("demo", "--frames"),
    ("simulate", "stand", "--out", "y", "--people"),
    ("evaluate", "simulated", "--workers"),
    ("evaluate", "folder", "x", "--seed"),
    ("reproduce", "--seed"),
    ("bench", "--frames"),
    ("annotate", "x", "y", "--port"),
    ("train-skin", "x", "--skin", "1", "2", "3"),
    ("train-forest", "--threads"),
    ("train-people", "x", "--every"),
]


@pytest.mark.parametrize("word", ["2.5", "2.0", "1e3", "nan", "7" * 5000, "7" * 400 + ".0", "0x10"])
@pytest.mark.parametrize("arguments", WHOLE, ids=" ".join)
def test_whole_numbers_are_written_as_such(topview, arguments: tuple[str, ...], word: str) -> None:
    refused = topview(*arguments, word)
    assert refused.status == 2
    option = next(argument for argument in reversed(arguments) if argument.startswith("--"))
    (line,) = refused.complaints
    assert line.startswith(f"topview: {option} is '{word[:40]}")
    assert line.endswith("it must be a whole number")
    assert len(line) < 160


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("train-skin", "x", "--out", "y", "--weight"), "nan"),
        (("train-skin", "x", "--out", "y", "--weight"), "9" * 5000),
        (("annotate", "x", "y", "--offset"), "inf"),
        (("annotate", "x", "y", "--offset"), "soon"),
    ],
)
def test_numbers_are_finite(topview, arguments: tuple[str, ...], word: str) -> None:
    refused = topview(*arguments, word)
    assert refused.status == 2
    (line,) = refused.complaints
    assert f"{arguments[-1]} is '{word[:40]}" in line


@pytest.mark.parametrize("seeds", ["7" * 5000, "1,,2", "1.5", "-1", "", "\N{SUPERSCRIPT TWO}"])
def test_lists_of_numbers(topview, seeds: str) -> None:
    refused = topview("evaluate", "simulated", "stand", f"--seeds={seeds}")
    assert refused.status == 2
    (line,) = refused.complaints
    assert "--seeds is" in line
    assert len(line) < 2100


@given(st.integers(-(10**19) + 1, 10**19 - 1))
def test_a_whole_number_is_itself(number: int) -> None:
    from cyclopts import Token

    assert converted(int, [Token(value=str(number))]) == number


@given(st.text(max_size=30))
def test_any_word_is_a_number_or_refused(word: str) -> None:
    from cyclopts import Token

    try:
        assert isinstance(converted(int, [Token(value=word)]), int)
    except InputError:
        assert not word.isdecimal() or len(word) > MOST_DIGITS or not word.isascii()
    assert converted(Path, [Token(value=word)]) == Path(word)
