"""Limits on the rotation of a part relative to its parent: of Table 3.2, and of anatomy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from topview.body.parts import (
    LEFT_LOWER_LEG,
    LEFT_UPPER_LEG,
    PARTS,
    RIGHT_LOWER_LEG,
    RIGHT_UPPER_LEG,
)
from topview.geometry.rotations import angles_from_rotations

Array = NDArray[np.float64]

LIMITS_RAD = np.array([part.limits_rad for part in PARTS])  # [11, 3, 2]: low and high of x, y, z

# Hips and knees bend farther than Table 3.2 says: anybody's do by 120 degrees and more (J. M.
# Soucie et al., "Range of motion measurements: reference values and a database for comparison
# studies", Haemophilia 2011), and of rendered people who sit (seeds 0 to 13) half of the hips and
# two thirds of the knees are beyond 100. Chosen on those: where knees bend to 135 or 150 degrees
# limbs that are hardly seen fold up, and who sits is 0.4 and 0.9 cm farther off.
HIP_FLEXION_RAD = KNEE_FLEXION_RAD = np.radians(120.0)


def _anatomical() -> Array:
    limits = LIMITS_RAD.copy()
    limits[[LEFT_UPPER_LEG, RIGHT_UPPER_LEG], 0, 1] = HIP_FLEXION_RAD
    limits[[LEFT_LOWER_LEG, RIGHT_LOWER_LEG], 0, 0] = -KNEE_FLEXION_RAD
    return limits


ANATOMICAL_LIMITS_RAD = _anatomical()  # [11, 3, 2]: Table 3.2 with hips and knees that bend so far

_DIRECTION = [0, 2]  # the turns about x and z alone say where a part points


def excess_rad(part: int, Rs_parent_part: Array) -> Array:
    """[..., 3, 3] rotations to [...]: by how much they leave the part's limits, 0 within them."""
    return _excess(part, angles_rad(part, Rs_parent_part))


def direction_excess_rad(part: int, Rs_parent_part: Array) -> Array:
    """[..., 3, 3] rotations to [...]: by how much the part's direction leaves the limits, whatever
    its turn about its own axis: with some turn, a part that does not leave them is within."""
    one, other = (angles[..., _DIRECTION] for angles in _decompositions(part, Rs_parent_part))
    limits = LIMITS_RAD[part, _DIRECTION]
    return np.minimum(_beyond(limits, one), _beyond(limits, other))


def angles_rad(part: int, Rs_parent_part: Array) -> Array:
    """[..., 3, 3] rotations to [..., 3] turns about x, y and z (`rotations_from_angles`).

    A rotation has two decompositions into turns about x, z and y; the more favourable to the
    part's limits counts. An angle is given in the full turn round the middle of its limits: an
    arm that is raised to its limit of 180 degrees and a little beyond stands at 181, not at -179.
    """
    angles, other = _decompositions(part, Rs_parent_part)
    is_better = _excess(part, other) < _excess(part, angles)
    return np.where(is_better[..., None], other, angles)


def _decompositions(part: int, Rs_parent_part: Array) -> tuple[Array, Array]:
    """[..., 3, 3] rotations to [..., 3] both turns about x, y and z that they are."""
    angles = angles_from_rotations(Rs_parent_part)
    x, y, z = np.moveaxis(angles, -1, 0)
    other = np.stack([x + np.pi, y + np.pi, np.pi - z], -1)
    return _around_limits(part, angles), _around_limits(part, other)


def _around_limits(part: int, angles: Array) -> Array:
    """[..., 3] the same directions, at most half a turn from the middle of the part's limits."""
    middle = LIMITS_RAD[part].mean(-1)
    return angles - 2 * np.pi * np.round((angles - middle) / (2 * np.pi))


def _excess(part: int, angles: Array) -> Array:
    return _beyond(LIMITS_RAD[part], angles)


def _beyond(limits_rad: Array, angles: Array) -> Array:
    """[..., K] angles to [...] by how much one of them leaves its limits, [K, 2]."""
    low, high = limits_rad.T
    return np.maximum(np.maximum(low - angles, angles - high), 0.0).max(-1)
