"""What a body that was found measures."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at


@njit(cache=True, nogil=True)
def share_within(
    overview_m: NDArray[np.float32],
    is_body: NDArray[np.bool_],
    right_m: float,
    forward_m: float,
    radius_m: float,
) -> float:
    """Share of a body's pixels [h, w] that are nearer than `radius_m` to a place, seen from above
    (`overview_m`, [h, w, 2]); NaN if it has none."""
    height, width = is_body.shape
    pixels, within = 0, 0
    for row in range(height):
        for column in range(width):
            if is_body[row, column]:
                right = overview_m[row, column, 0] - right_m
                forward = overview_m[row, column, 1] - forward_m
                pixels += 1
                within += right * right + forward * forward < radius_m * radius_m
    return within / pixels if pixels else np.nan


@njit(cache=True, nogil=True)
def measure_body(
    distance_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    inset_m: NDArray[np.float32],
    focal_px: float,
    above_m: float,
    bust_m: float,
    torso_m: float,
    edge: Law,
) -> tuple[float, float, float, float, float, float]:
    """Areas of a body, of what of it is higher than `above_m` and of the bust, in square metres;
    its lowest height; how many of the bust's pixels lie on edges, over the root of all; and how
    far the innermost pixel of bust and torso is from what surrounds it.

    Args:
        distance_m: [h, w] of each of its pixels from the head, infinity elsewhere.
        depth_m: [h, w].
        heights_m: [h, w] along up.
        inset_m: [h, w] how far each pixel is from what surrounds its surface.
        focal_px: of the depth image.
        above_m: see above.
        bust_m: nearer to the head is the bust.
        torso_m: nearer to the head are bust and torso.
        edge: on an edge is what has no reading, or differs from the left or the upper pixel's depth
            by more than this law says.
    """
    height, width = depth_m.shape
    area_m2, over_m2, bust_m2, lowest_m, radius_m = 0.0, 0.0, 0.0, np.inf, 0.0
    edges, pixels = 0, 0
    for row in range(height):
        for column in range(width):
            if distance_m[row, column] == np.inf:
                continue
            z = depth_m[row, column]
            pixel_m2 = (z / focal_px) ** 2
            area_m2 += pixel_m2
            lowest_m = min(lowest_m, heights_m[row, column])
            if heights_m[row, column] > above_m:
                over_m2 += pixel_m2
            if distance_m[row, column] < torso_m:
                radius_m = max(radius_m, inset_m[row, column])
            if distance_m[row, column] < bust_m:
                bust_m2 += pixel_m2
                pixels += 1
                jump_m = law_at(z, edge)
                left_m, upper_m = depth_m[row, max(column - 1, 0)], depth_m[max(row - 1, 0), column]
                edges += (z == 0.0) | (abs(z - left_m) > jump_m) | (abs(z - upper_m) > jump_m)
    return area_m2, over_m2, bust_m2, lowest_m, edges / np.sqrt(max(pixels, 1)), radius_m
