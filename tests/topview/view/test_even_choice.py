"""Which frames a sheet keeps."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from topview.view.even_choice import EvenChoice


def chosen(wanted: int, length: int, known: bool) -> list[int]:
    choice: EvenChoice[int] = EvenChoice(wanted, length if known else None)
    for index in range(length):
        if choice.next_is_due():
            choice.keep(index)
    return choice.kept


@given(st.integers(2, 9), st.integers(1, 500))
def test_of_a_known_length_the_first_and_the_last_are_kept(wanted, length):
    kept = chosen(wanted, length, known=True)
    assert kept[0] == 0
    assert kept[-1] == length - 1
    assert len(kept) == min(wanted, length)


@given(st.integers(2, 9), st.integers(1, 500))
def test_of_an_unknown_length_the_kept_lie_evenly(wanted, length):
    kept = chosen(wanted, length, known=False)
    assert kept[0] == 0
    assert min(wanted, length) <= len(kept) < 2 * wanted or length < wanted
    assert len({b - a for a, b in zip(kept, kept[1:], strict=False)}) <= 1
