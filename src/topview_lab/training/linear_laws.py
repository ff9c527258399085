"""What the fits of linear laws have in common: traits that are standardised, and outliers that
count by distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# All ours.
REWEIGHTED: Final = 4  # of least squares, each with the weights of the one before
TRAITS_WITHIN: Final = 0.01, 0.99  # quantiles of traits, beyond which they are cut off


@dataclass(frozen=True, slots=True, eq=False)
class Standardised:
    """Traits, of which the first is 1, without outliers and of one scale.

    Attributes:
        traits: [N, T] of mean 0 and variance 1, but the first.
        lowest, highest: [T] they were cut off at.
        mean, spread: [T] of them before.
    """

    traits: Array
    lowest: Array
    highest: Array
    mean: Array
    spread: Array

    @classmethod
    def of(cls, traits: Array) -> Standardised:
        """Of [N, T]."""
        lowest, highest = np.quantile(traits, TRAITS_WITHIN, axis=0)
        within = np.clip(traits, lowest, highest)
        mean, spread = within.mean(0), within.std(0)
        mean[0], spread[spread < 1e-9] = 0.0, 1.0
        return cls((within - mean) / spread, lowest, highest, mean, spread)

    def weights(self, standard: Array) -> Array:
        """[..., T] weights of the traits as they were, of those [..., T] of standardised ones."""
        weights = standard / self.spread
        weights[..., 0] -= weights[..., 1:] @ self.mean[1:]
        return weights


def counted_by_distance(left: Array, typical: float) -> Array:
    """[...] weights of [..., 3] residuals, with which squares of what is farther off than is
    typical count by the distance."""
    return typical / np.maximum(np.linalg.norm(left, axis=-1), typical)
