"""How the words of a command line become values: stricter than what converts them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isfinite
from typing import Any, Final, get_args

from cyclopts import Token, convert

from topview.records import InputError, shown

MOST_DIGITS: Final = 19
"""Of whole numbers, as many as 2^63 has."""


def converted(type_: Any, tokens: Sequence[Token]) -> Any:
    """Words as a value of a type, whole numbers written as such and no others finite.

    Raises:
        InputError: a word is no whole number where one is needed, or not finite.
    """
    needs_whole, needs_finite = (_contains(type_, kind) for kind in (int, float))
    for token in tokens:
        if needs_whole and not re.fullmatch(rf"[+-]?[0-9]{{1,{MOST_DIGITS}}}", token.value):
            raise InputError(f"{_named(token)}; it must be a whole number")
        if needs_finite and not _is_finite(token.value):
            raise InputError(f"{_named(token)}; it must be a number")
    return convert(type_, tokens)


def _contains(type_: Any, kind: type) -> bool:
    return type_ is kind or any(_contains(inner, kind) for inner in get_args(type_))


def _is_finite(word: str) -> bool:
    try:
        return isfinite(float(word))
    except ValueError:
        return False


def _named(token: Token) -> str:
    return f"{token.keyword or 'an argument'} is {shown(token.value)}"
