"""Where the elbow, or the knee, may be of a limb whose end is known (Eq. 5.4 - 5.6), and how such a
limb is turned."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from topview.geometry.rotations import cross, unit
from topview.kernels.body import STRAIGHT
from topview.kernels.spread import farthest_first
from topview.track.pose import HINGE_BENDS

Array = NDArray[np.float64]

# Ours.
FOLDED_M: Final = 0.02  # a palm comes no nearer to the shoulder than the lengths' difference and it
STRETCHED: Final = 0.998  # share of its length that a limb stretches to


def elbows_on_circle(
    shoulder: Array, palms: Array, length_upper: float, length_lower: float, turns: int
) -> Array:
    """[P, 3] palms, of one shoulder [3] or one each [P, 3], to [P * turns, 2, 3] directions of both
    parts (Eq. 5.4 - 5.6).

    Palms out of reach, or too near, are taken at the nearest distance that the limb can have.
    """
    reach = palms - shoulder
    distance = np.linalg.norm(reach, axis=1)
    axis = unit(reach)
    shortest = abs(length_upper - length_lower) + FOLDED_M
    span = np.clip(distance, shortest, (length_upper + length_lower) * STRETCHED)
    i = (span**2 + length_upper**2 - length_lower**2) / (2 * span)
    r = np.sqrt(np.maximum(length_upper**2 - i**2, 0.0))
    helper = np.where(np.abs(axis[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    v1 = unit(cross(axis, helper))
    v2 = cross(axis, v1)
    t = 2 * np.pi * np.arange(turns) / turns
    across = v1[:, None] * np.cos(t)[None, :, None] + v2[:, None] * np.sin(t)[None, :, None]
    elbows = axis[:, None] * i[:, None, None] + across * r[:, None, None]
    lower = axis[:, None] * span[:, None, None] - elbows
    return unit(np.stack([elbows, lower], axis=2)).reshape(-1, 2, 3)


def spread_points(points: Array, start: Array, count: int) -> Array:
    """Up to `count` of the [N, 3] points, farthest-first: each next one lies farthest from `start`
    and from those already taken."""
    taken = np.empty(min(count, len(points)), np.int64)
    farthest_first(points, start, taken)
    return points[taken]


def limb_rotations(axes: Array, R_parent: Array, upper: int) -> Array:
    """[..., 2, 3, 3] rotations of a limb's parts along axes [..., 2, 3]: the hinge's axis stands
    across both, or along the parent's x where the limb is straight."""
    across = HINGE_BENDS[upper] * cross(axes[..., 0, :], axes[..., 1, :])
    sine = np.linalg.norm(across, axis=-1, keepdims=True)
    share = np.minimum(sine / STRAIGHT, 1.0)
    x = share * across / np.maximum(sine, 1e-9) + (1.0 - share) * R_parent[:, 0]
    x = x[..., None, :] - (axes @ x[..., None]) * axes
    x = unit(x)
    return np.stack([x, axes, cross(x, axes)], axis=-1)
