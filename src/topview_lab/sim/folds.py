"""Small irregularities of skin and cloth: folds that are fixed to the body and move with it.

The surface is displaced along its normal by a sum of sine waves over the point's place in the
standing body, where the waves continue from one segment to the next: a bent joint does not tear
them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import read_only

WAVELENGTHS_M: Final = (0.45, 0.28, 0.18, 0.12, 0.085, 0.06)
"""From the drape of a whole garment to a crease (ours)."""


@dataclass(frozen=True, slots=True, eq=False)
class Folds:
    """K waves: displacement = amplitude * sum(weights * sin(waves . place + phases)), whose
    absolute value never exceeds the amplitude.

    Attributes:
        waves: [K, 3] radians per metre, in the axes of the standing body.
        phases, weights: [K]; the weights' sum is 1.
    """

    waves: NDArray[np.float32]
    phases: NDArray[np.float32]
    weights: NDArray[np.float32]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            read_only(getattr(self, name))

    @classmethod
    def sample(cls, rng: np.random.Generator) -> Folds:
        """A wave of each length in a random direction; cloth hangs, so few run up and down."""
        lengths = np.array(WAVELENGTHS_M)
        directions = rng.standard_normal((len(lengths), 3)) * (1.0, 0.5, 1.0)
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        weights = lengths**0.5
        return cls(
            waves=(2.0 * np.pi / lengths[:, None] * directions).astype(np.float32),
            phases=rng.uniform(0.0, 2.0 * np.pi, len(lengths)).astype(np.float32),
            weights=(weights / weights.sum()).astype(np.float32),
        )

    def at(
        self, places: NDArray[np.float32], amplitudes_m: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Displacements [M] in metres and their slopes [M, 3] at places [M, 3] in the standing
        body, where the amplitudes are [M]."""
        angles = places @ self.waves.T + self.phases
        displacements = amplitudes_m * (np.sin(angles) @ self.weights)
        slopes = amplitudes_m[:, None] * (np.cos(angles) @ (self.weights[:, None] * self.waves))
        return np.asarray(displacements, np.float32), np.asarray(slopes, np.float32)
