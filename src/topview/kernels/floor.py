"""What of a depth image is floor."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def floor_margin(
    depth_m: float,
    height_m: float,
    camera_height_m: float,
    margin_m: float,
    noise_per_square_m: float,
) -> float:
    """How high a reading of the floor may seem to be: the noise lies along the ray, so that it
    moves a point up by the share of the ray's own descent.

    Two standard deviations of it, `noise_per_square_m` times the square of the depth each, are
    added to `margin_m`.
    """
    drop_per_m = abs(height_m - camera_height_m) / max(depth_m, 0.1)
    return margin_m + 2.0 * noise_per_square_m * depth_m * depth_m * drop_per_m
