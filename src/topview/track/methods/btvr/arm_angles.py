"""The arm's four angles and their ranges (Table 5.1, Denavit and Hartenberg's convention).

The first two frames turn the upper arm to `(cos t1 cos t2, sin t1 cos t2, -sin t2)`, the next two
the forearm to `(sin t4 sin t3, -sin t4 cos t3, cos t4)` in the frame that hangs on it. The table
does not say how its base stands in the torso; with -90..90 for both, the upper arm points into the
half space along the base's x, which is here (ours) between front and side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RANGES_RAD = np.radians([(-90.0, 90.0), (-90.0, 90.0), (-230.0, 90.0), (0.0, 145.0)])
"""Of theta 1 to 4, Table 5.1."""

_OUT, _DOWN, _FRONT = np.eye(3)
_BASE_X = (_OUT + _FRONT) / np.sqrt(2.0)
_BASE = np.stack([_BASE_X, _DOWN, np.cross(_BASE_X, _DOWN)], axis=1)
"""[3, 3] the base's axes in the torso's frame, of a right arm."""


def arm_angles(axes_torso: Array, side: float) -> Array:
    """[M, 2, 3] directions of upper arm and forearm in the torso's frame to [M, 4] radians.

    `side` is +1 for a right arm and -1 for a left one, which is its mirror image.
    """
    mirrored = axes_torso * (side, 1.0, 1.0)
    upper, lower = np.moveaxis(mirrored @ _BASE, 1, 0)
    t1 = np.arctan2(upper[:, 1], upper[:, 0])
    t2 = np.arcsin(np.clip(-upper[:, 2], -1.0, 1.0))
    c1, s1, c2, s2 = np.cos(t1), np.sin(t1), np.cos(t2), np.sin(t2)
    x2 = np.stack([c1 * s2, s1 * s2, c2], axis=1)
    y2 = np.stack([s1, -c1, np.zeros_like(s1)], axis=1)
    across_x, across_y = (lower * x2).sum(1), (lower * y2).sum(1)
    t3 = np.arctan2(across_x, -across_y)
    t3 = np.where(t3 > RANGES_RAD[2, 1], t3 - 2 * np.pi, t3)
    t4 = np.arccos(np.clip((lower * upper).sum(1), -1.0, 1.0))
    return np.stack([t1, t2, t3, t4], axis=1)


def beyond_ranges_rad(angles_rad: Array) -> Array:
    """[M, 4] to [M]: by how much an arm leaves the ranges.

    Theta 1 and 2 count together, as the angle between the upper arm and the half space that they
    reach; theta 3 counts as far as the elbow is bent, since a straight arm does not show it.
    """
    t1, t2, t3, t4 = angles_rad.T
    behind = np.arcsin(np.clip(-np.cos(t1) * np.cos(t2), 0.0, 1.0))
    low, high = RANGES_RAD[2]
    turned = np.sin(t4) * np.maximum(np.maximum(low - t3, t3 - high), 0.0)
    bent = np.maximum(t4 - RANGES_RAD[3, 1], 0.0)
    return np.maximum(np.maximum(behind, turned), bent)
