"""A law that is linear in traits, learnt from recordings with truth, as files keep it (ours)."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from typing import Self

import numpy as np
from numpy.typing import NDArray

from topview.files import read_archive

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LinearLaw:
    """What a law tells of each of some traits.

    Attributes:
        source: what it was learnt from, and how.
        weights: [..., T] of each trait, for each number that is told.
        lowest, highest: [T] traits are taken as no farther out than those it was learnt from.
    """

    source: str
    weights: Array
    lowest: Array
    highest: Array

    @classmethod
    def shipped(cls, file: str) -> Self:
        """That of a file which comes with the project."""
        files = resources.files("topview.track.methods.topview") / file
        with resources.as_file(files) as path:
            arrays = read_archive(path)
        return cls(str(arrays.pop("source")), **arrays)

    def told_by(self, traits: Array) -> Array:
        """[...] what [T] traits tell, or [..., N] of [T, N]."""
        return self.weights @ np.clip(traits.T, self.lowest, self.highest).T
