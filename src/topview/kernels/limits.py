"""By how much hypotheses of a part leave the limits of its joint (Table 3.2), many at once.

Definition: `topview.body.limits`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from topview.kernels.body import beyond_limits

LEAST_HINGE = 1e-12  # of a shorter one the direction cannot be told


@njit(error_model="numpy")
def excess(P, R, limits, with_turn):
    """By how many radians R leaves the limits in the frame of its parent P, the more favourable
    of its two decompositions into turns about x, z and y; the turn about y counts if `with_turn`.
    """
    sine = -(P[0, 0] * R[0, 1] + P[1, 0] * R[1, 1] + P[2, 0] * R[2, 1])
    r11 = P[0, 1] * R[0, 1] + P[1, 1] * R[1, 1] + P[2, 1] * R[2, 1]
    r21 = P[0, 2] * R[0, 1] + P[1, 2] * R[1, 1] + P[2, 2] * R[2, 1]
    x, z = np.arctan2(r21, r11), np.arcsin(min(max(sine, -1.0), 1.0))
    first = max(
        abs(beyond_limits(limits[0, 0], limits[0, 1], x)),
        abs(beyond_limits(limits[2, 0], limits[2, 1], z)),
    )
    second = max(
        abs(beyond_limits(limits[0, 0], limits[0, 1], x + np.pi if x < 0 else x - np.pi)),
        abs(beyond_limits(limits[2, 0], limits[2, 1], np.pi - z if z > 0 else -np.pi - z)),
    )
    if with_turn:
        r00 = P[0, 0] * R[0, 0] + P[1, 0] * R[1, 0] + P[2, 0] * R[2, 0]
        r02 = P[0, 0] * R[0, 2] + P[1, 0] * R[1, 2] + P[2, 0] * R[2, 2]
        y = np.arctan2(r02, r00)
        first = max(first, abs(beyond_limits(limits[1, 0], limits[1, 1], y)))
        y += np.pi if y < 0 else -np.pi
        second = max(second, abs(beyond_limits(limits[1, 0], limits[1, 1], y)))
    return min(first, second)


@njit(cache=True, error_model="numpy", nogil=True)
def part_excess(Rs, R_parent, limits, with_turn, out):
    """Fill `out` [M] with `excess` of `Rs_camera_part` [M, 3, 3].

    Args:
        R_parent: [3, 3] `R_camera_part` of the part above.
        limits: [3, 2] radians, of the turns about x, y and z.
        with_turn: whether the turn about the part's own axis counts.
    """
    for m in range(Rs.shape[0]):
        out[m] = excess(R_parent, Rs[m], limits, with_turn)


@njit(error_model="numpy")
def _hinge(R_upper, R_lower, bend, known_bend):
    """Unit vector of the axis about which a limb bends, across both of its parts, and the length
    that it had; that of a straight limb is the upper part's x."""
    ux, uy, uz = R_upper[0, 1], R_upper[1, 1], R_upper[2, 1]
    lx, ly, lz = R_lower[0, 1], R_lower[1, 1], R_lower[2, 1]
    x = bend * (uy * lz - uz * ly) + known_bend * R_upper[0, 0]
    y = bend * (uz * lx - ux * lz) + known_bend * R_upper[1, 0]
    z = bend * (ux * ly - uy * lx) + known_bend * R_upper[2, 0]
    size = np.sqrt(x * x + y * y + z * z)
    inv = 1.0 / max(size, LEAST_HINGE)
    return x * inv, y * inv, z * inv, size


@njit(error_model="numpy")
def _turn_x_to(x, y, z, R):
    """Turn a part about its own axis until its x is a unit vector across that."""
    R[0, 0], R[1, 0], R[2, 0] = x, y, z
    R[0, 2] = y * R[2, 1] - z * R[1, 1]
    R[1, 2] = z * R[0, 1] - x * R[2, 1]
    R[2, 2] = x * R[1, 1] - y * R[0, 1]


@njit(cache=True, error_model="numpy", nogil=True)
def bend_about_hinge(R_upper, R_lower, bend, known_bend):
    """Turn both parts of a limb, [3, 3] `R_camera_part`, about their own axes until it bends about
    a hinge.

    Args:
        bend: 1 for elbows, -1 for knees.
        known_bend: weight of the upper part's own x against the sine of the bend.
    """
    x, y, z, size = _hinge(R_upper, R_lower, bend, known_bend)
    if size < LEAST_HINGE:
        return
    _turn_x_to(x, y, z, R_upper)
    along = x * R_lower[0, 1] + y * R_lower[1, 1] + z * R_lower[2, 1]
    x, y, z = x - along * R_lower[0, 1], y - along * R_lower[1, 1], z - along * R_lower[2, 1]
    inv = 1.0 / np.sqrt(x * x + y * y + z * z)
    _turn_x_to(x * inv, y * inv, z * inv, R_lower)


@njit(cache=True, error_model="numpy", nogil=True)
def hinge_excess(Rs, R_upper, R_torso, limits_upper, most_flexion, bend, known_bend, out):
    """Fill `out` [M] with how far a limb leaves its limits whose lower part is turned like `Rs`
    [M, 3, 3]: the flexion beyond `most_flexion`, and `excess` of the upper part, turned about its
    own axis until the limb bends about the hinge.

    Args:
        R_upper, R_torso: [3, 3] `R_camera_part` of the upper part, and of the one above it.
        limits_upper: [3, 2] radians, of the upper part.
        bend, known_bend: as of `bend_about_hinge`.
    """
    turned = R_upper.copy()
    for m in range(Rs.shape[0]):
        x, y, z, size = _hinge(R_upper, Rs[m], bend, known_bend)
        if size < LEAST_HINGE:
            out[m] = np.inf
            continue
        _turn_x_to(x, y, z, turned)
        along = turned[0, 1] * Rs[m, 0, 1] + turned[1, 1] * Rs[m, 1, 1] + turned[2, 1] * Rs[m, 2, 1]
        flexion = np.arccos(min(max(along, -1.0), 1.0))
        out[m] = excess(R_torso, turned, limits_upper, True) + max(flexion - most_flexion, 0.0)
