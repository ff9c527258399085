"""Statistics of errors: mean, standard deviation, share within 10 cm or 10 degrees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

CM_PER_M: Final = 100.0
WITHIN: Final = 10.0  # cm for joints, degrees for angles: the accuracy A of Sec. 6.1.2


@dataclass(frozen=True, slots=True)
class Statistic:
    """Errors in cm (joints) or degrees (angles): NaN where there is none.

    Attributes:
        count: how many.
        mean: their mean, muE in Sec. 6.1.
        std: their standard deviation, sigmaE.
        within_10: share 0..1 that is at most 10, A.
    """

    count: int
    mean: float
    std: float
    within_10: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """The same errors as they are, and with the constant offsets taken out."""

    raw: Statistic
    offset_out: Statistic


def statistic(errors: NDArray[np.float64]) -> Statistic:
    """Of all the finite values."""
    finite = errors[np.isfinite(errors)]
    if finite.size == 0:
        return Statistic(0, *[float("nan")] * 3)
    return Statistic(
        count=finite.size,
        mean=float(finite.mean()),
        std=float(finite.std()),
        within_10=float((finite <= WITHIN).mean()),
    )


def share(part: float, whole: float) -> float:
    """`part / whole`, NaN of nothing."""
    return float(part / whole) if whole else float("nan")
