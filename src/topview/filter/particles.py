"""Sampling-importance-resampling over abstract states: it knows scores, not bodies (Sec. 5.3.2).

A state is whatever its owner makes of an index; the filter decides which of the kept hypotheses is
the parent of each new one, draws the noise that moves it, and says which are worth keeping.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def generator(seed: int, *counters: int) -> np.random.Generator:
    """A counter-based generator: the same seed and counters give the same numbers anywhere."""
    return np.random.Generator(np.random.Philox(key=seed, counter=[0, *counters][-4:]))


def time_key(time_s: float) -> int:
    """What stands for a moment among a generator's counters: its whole microseconds, so that frames
    draw the same numbers whichever others there are, and however they are numbered."""
    return round(time_s * 1e6) & (2**63 - 1)


def importance_weights(scores: Array) -> Array:
    """[N] scores, lower is better, to [N] weights that sum to one: w ~ 1 / f."""
    weights = 1.0 / np.maximum(scores, np.finfo(np.float64).tiny)
    total = weights.sum()
    return weights / total if 0.0 < total < np.inf else np.full(len(scores), 1.0 / len(scores))


def systematic_resample(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """[count] indices of parents, drawn in proportion to their weights with one random number."""
    positions = (rng.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights), positions), len(weights) - 1)


def n_best(scores: Array, count: int) -> NDArray[np.intp]:
    """Indices of the lowest `count` scores, best first; ties keep their order."""
    return np.argsort(scores, kind="stable")[:count]
