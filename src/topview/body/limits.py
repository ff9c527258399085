"""Limits on the rotation of a part relative to its parent (Table 3.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import PARTS
from topview.geometry.rotations import angles_from_rotations

Array = NDArray[np.float64]


def excess_rad(part: int, Rs_parent_part: Array) -> Array:
    """[..., 3, 3] rotations to [...]: by how much they leave the part's limits, 0 within them.

    A rotation has two decompositions into turns about x, z and y; the more favourable counts.
    """
    angles = angles_from_rotations(Rs_parent_part)
    other = np.stack(
        [
            _wrapped(angles[..., 0] + np.pi),
            _wrapped(angles[..., 1] + np.pi),
            np.pi - angles[..., 2],
        ],
        -1,
    )
    other[..., 2] = _wrapped(other[..., 2])
    return np.minimum(_excess(part, angles), _excess(part, other))


def _wrapped(angle: Array) -> Array:
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _excess(part: int, angles: Array) -> Array:
    low, high = np.array(PARTS[part].limits_rad).T
    beyond = np.maximum(low - angles, angles - high)
    return np.maximum(beyond, 0.0).max(-1)
