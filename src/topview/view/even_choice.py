"""Some frames of many, evenly over a recording whose length need not be known."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")


class EvenChoice(Generic[T]):
    """Keeps some of a sequence's items while it goes by.

    Of a known length it keeps the first, the last, and what lies evenly between. Else it keeps
    every item at first, then every second, every fourth, and so on: at most twice as many.

    Attributes:
        kept: in order.
    """

    def __init__(self, wanted: int, length: int | None) -> None:
        """`wanted` of `length` items; None if nobody knows how many there will be."""
        self.kept: list[T] = []
        self._wanted = wanted
        self._due: set[int] | None = None
        if length is not None:
            even = np.linspace(0, max(length, 1) - 1, wanted)
            self._due = {round(index) for index in even}
        self._stride = 1
        self._seen = 0

    def next_is_due(self) -> bool:
        """Whether to keep the next item; asked once for each."""
        index, self._seen = self._seen, self._seen + 1
        return index % self._stride == 0 if self._due is None else index in self._due

    def keep(self, item: T) -> None:
        """Keep the item that is due."""
        self.kept.append(item)
        if self._due is None and len(self.kept) >= 2 * self._wanted:
            del self.kept[1::2]
            self._stride *= 2
