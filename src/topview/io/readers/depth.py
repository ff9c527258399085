"""From stored depth values to a frame's depth image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

METRES_PER_MILLIMETRE = 0.001


def depth_image(values: NDArray[Any], metres_per_unit: float) -> NDArray[np.float32]:
    """float32 metres of the same shape; NaN, infinite and negative readings become 0 (none)."""
    with np.errstate(over="ignore", invalid="ignore"):
        depth_m = np.array(values * metres_per_unit, np.float32, order="C")
    depth_m[~(np.isfinite(depth_m) & (depth_m > 0.0))] = 0.0
    return depth_m
