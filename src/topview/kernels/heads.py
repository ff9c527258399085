"""What a depth image shows at the places of a template."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# What is seen at a place, compared with the depth that it should have.
HIDDEN, THERE, BEHIND, EMPTY = range(4)


@njit(cache=True, nogil=True)
def look_at_template(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    centers_camera: NDArray[np.float64],
    offsets_camera: NDArray[np.float64],
    before_m: float,
    behind_m: float,
    far_behind_m: float,
    noise_per_square_m: float,
    out_seen: NDArray[np.uint8],
) -> None:
    """Look through every place of a template put at every centre.

    `HIDDEN`: out of view, or something nearer by more than `before_m` is in the way; `THERE`: a
    surface there, or further away by up to `behind_m`; `BEHIND`: one up to `far_behind_m` further
    away; `EMPTY`: nothing that near, or no reading. All three grow by `noise_per_square_m` times
    the square of the centre's depth.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        focal_px: (fx, fy).
        principal_px: (cx, cy).
        centers_camera: [N, 3] metres.
        offsets_camera: [K, 3] metres from the centre.
        before_m: see above.
        behind_m: see above.
        far_behind_m: see above.
        noise_per_square_m: see above, 1/m.
        out_seen: [N, K].
    """
    height, width = depth_m.shape
    for n in range(centers_camera.shape[0]):
        noise_m = noise_per_square_m * centers_camera[n, 2] ** 2
        for k in range(offsets_camera.shape[0]):
            out_seen[n, k] = HIDDEN
            z = centers_camera[n, 2] + offsets_camera[k, 2]
            if z <= 0.0:
                continue
            x = centers_camera[n, 0] + offsets_camera[k, 0]
            y = centers_camera[n, 1] + offsets_camera[k, 1]
            column = int(np.floor(x / z * focal_px[0] + principal_px[0] + 0.5))
            row = int(np.floor(y / z * focal_px[1] + principal_px[1] + 0.5))
            if not (0 <= row < height and 0 <= column < width):
                continue
            seen_m = depth_m[row, column]
            if seen_m == 0.0 or seen_m - z > far_behind_m + noise_m:
                out_seen[n, k] = EMPTY
            elif seen_m - z > behind_m + noise_m:
                out_seen[n, k] = BEHIND
            elif seen_m - z >= -before_m - noise_m:
                out_seen[n, k] = THERE
