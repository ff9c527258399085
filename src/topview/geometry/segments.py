"""Points and line segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def square_distances(points: Array, starts: Array, ends: Array) -> Array:
    """[N, B] square metres from [N, 3] points to segments from [B, 3] to [B, 3]."""
    along = ends - starts
    offset = points[:, None] - starts
    square = np.maximum((along**2).sum(-1), 1e-9)
    share = np.clip(np.einsum("nbi,bi->nb", offset, along) / square, 0.0, 1.0)
    offset -= share[..., None] * along
    return np.einsum("nbi,nbi->nb", offset, offset)
