"""What grows with the depth as a sensor's noise does."""

from __future__ import annotations

from numba import njit

# (a, b, c) of a + b z + c z^2, metres at z metres: `topview.records.DepthNoise.times`.
Law = tuple[float, float, float]


@njit(nogil=True)
def law_at(depth_m: float, law: Law) -> float:
    """a + b z + c z^2, metres."""
    return law[0] + law[1] * depth_m + law[2] * depth_m * depth_m


@njit(nogil=True)
def slope_at(depth_m: float, law: Law) -> float:
    """The same over z: a / z + b + c z."""
    return law[0] / max(depth_m, 0.1) + law[1] + law[2] * depth_m
