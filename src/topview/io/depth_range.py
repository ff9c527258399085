"""How far away all that a recording shows is, so that a wrong unit of depth can be told."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, log, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.records import FARTHEST_READING_M, Frame, Person

PEOPLE_LIE_WITHIN_M: Final = (0.3, 10.0)
"""Where depth cameras of rooms see people (ours)."""
LEAST_SHARE_NEAR: Final = 0.05
"""Of the readings; with fewer there, the recording shows no people, or its unit is wrong (ours)."""
PIXELS_PER_FRAME: Final = 5_000
"""So many are looked at; ours."""
_NEAREST_M: Final = 1e-4
_BINS: Final = 1 + ceil(100.0 * log(FARTHEST_READING_M / _NEAREST_M))  # of 1 %


class DepthRange:
    """Counts readings by distance. It is a viewer of frames (`topview.view.Viewer`), too.

    Attributes:
        frames: how many were counted.
    """

    def __init__(self) -> None:
        self.frames = 0
        self._pixels = 0
        self._counts = np.zeros(_BINS, np.int64)
        self._sums_m = np.zeros(_BINS)

    def show(self, frame: Frame, people: Sequence[Person]) -> None:
        """Count a frame's readings where nobody is found; elsewhere nobody asks for them."""
        if not people:
            self.add(frame.depth_m)

    def add(self, depth_m: NDArray[np.float32]) -> None:
        """Count the readings of an image [H, W] in metres, 0 where there is none."""
        step = max(1, round(sqrt(depth_m.size / PIXELS_PER_FRAME)))
        looked_at = depth_m[step // 2 :: step, step // 2 :: step]
        readings_m = looked_at[looked_at > 0.0]
        logs = 100.0 * np.log(np.maximum(readings_m, _NEAREST_M) / _NEAREST_M)
        bins = np.minimum(logs.astype(np.intp), _BINS - 1)
        self._counts += np.bincount(bins, minlength=_BINS)
        self._sums_m += np.bincount(bins, readings_m, _BINS)
        self._pixels += looked_at.size
        self.frames += 1

    @property
    def valid_share(self) -> float:
        """Of the pixels, those that have a reading."""
        return float(self._counts.sum()) / max(self._pixels, 1)

    def quantile_m(self, share: float) -> float:
        """Metres that so great a share of the readings lies within, to 1 %; NaN without any."""
        total = int(self._counts.sum())
        if not total:
            return float("nan")
        at = int(np.searchsorted(np.cumsum(self._counts), share * total))
        return float(self._sums_m[at] / self._counts[at])

    @property
    def told(self) -> str:
        """From where to where nearly all readings lie, in words."""
        if not self._counts.any():
            return "no pixel has a reading"
        return f"readings lie from {self.quantile_m(0.01):.2g} to {self.quantile_m(0.99):.2g} m"

    @property
    def problem(self) -> str:
        """Why nobody could be seen at such distances, and what would be right; empty if that is no
        reason."""
        low, high = PEOPLE_LIE_WITHIN_M
        if not self._counts.any():
            return f"{self.told}; people must be seen at {low:g} to {high:g} m"
        edges_m = _NEAREST_M * np.exp(np.arange(_BINS) / 100.0)
        near = self._counts[(edges_m >= low) & (edges_m <= high)].sum() / self._counts.sum()
        if near >= LEAST_SHARE_NEAR:
            return ""
        return (
            f"{self.told}; people must be seen at {low:g} to {high:g} m. The unit of depth is "
            "probably wrong: depth_scale is 0.001 for millimetres, 0.0002 for TUM RGB-D, 1 for "
            "floats in metres"
        )
