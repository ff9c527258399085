"""Spatially correlated noise that is cheap to redraw for every frame."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

MARGIN: float = 0.5
"""The field is larger than an image by this share on each axis (ours)."""


def noise_generator(seed: int, frame: int) -> np.random.Generator:
    """A generator for one frame, independent of what was drawn before."""
    return np.random.default_rng((seed, frame))


class NoiseField:
    """Normal noise of unit variance, averaged over square windows, larger than an image.

    Each draw is a window at a random place, flipped or not: a thousandth of the cost of new random
    numbers.
    """

    def __init__(self, shape: tuple[int, ...], window_px: int, rng: np.random.Generator) -> None:
        self._shape = shape
        height, width = (int((1.0 + MARGIN) * side) for side in shape[:2])
        white = rng.standard_normal((height, width, *shape[2:]), np.float32)
        sums = cv2.boxFilter(white, -1, (window_px, window_px), normalize=False)
        self._field: NDArray[np.float32] = np.asarray(sums / window_px, np.float32)

    def draw(self, rng: np.random.Generator) -> NDArray[np.float32]:
        """An image of noise; a view, not to be written to."""
        (height, width), field = self._shape[:2], self._field
        top = rng.integers(field.shape[0] - height + 1)
        left = rng.integers(field.shape[1] - width + 1)
        part = field[top : top + height, left : left + width]
        return part[:: 1 - 2 * int(rng.integers(2))]
