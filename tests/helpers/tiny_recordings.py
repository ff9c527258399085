"""What the tiny recordings of these tests are made of."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 64, 48
CAMERA = {"fx": 57.0, "fy": 57.0, "cx": 31.5, "cy": 23.5, "width": WIDTH, "height": HEIGHT}


def wall(depth_mm: int = 3000) -> NDArray[Any]:
    """A depth image of a bare wall; 0 for no reading."""
    return np.full((HEIGHT, WIDTH), depth_mm, np.uint16)
