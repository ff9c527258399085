"""Where the pixels of a depth image lie in another camera's image."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Ours: a depth pixel also covers the cells around its own up to this far beyond half a cell, so
# that a surface that the other camera sees larger has no gaps.
SLACK_CELLS = 0.25


@njit(cache=True, nogil=True)
def fill_from_behind(
    depth_m: NDArray[np.float32], far_m: float, out_m: NDArray[np.float32]
) -> None:
    """Give pixels without a reading the further one of the next readings left and right.

    What has no reading is mostly in the shadow of something nearer.

    Args:
        depth_m: [H, W] metres, 0 where there is no reading.
        far_m: for rows without any reading.
        out_m: [H, W] metres.
    """
    height, width = depth_m.shape
    for row in range(height):
        last_m = np.float32(0.0)
        for column in range(width):
            if depth_m[row, column] > 0.0:
                last_m = depth_m[row, column]
            out_m[row, column] = last_m
        last_m = np.float32(0.0)
        for column in range(width - 1, -1, -1):
            if depth_m[row, column] > 0.0:
                last_m = depth_m[row, column]
            elif last_m > out_m[row, column]:
                out_m[row, column] = last_m
            if out_m[row, column] == 0.0:
                out_m[row, column] = far_m


@njit(cache=True, nogil=True)
def locate_pixels(
    depth_m: NDArray[np.float32],
    has_reading: NDArray[np.bool_],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    T_other_depth: NDArray[np.float64],
    other_focal_px: tuple[float, float],
    other_principal_px: tuple[float, float],
    other_size_px: tuple[int, int],
    cell_px: tuple[float, float],
    nearer_m: float,
    nearer_per_square_m: float,
    nearest_m: NDArray[np.float32],
    other_depth_m: NDArray[np.float32],
    out_px: NDArray[np.float32],
) -> None:
    """Project every depth pixel into the other camera's image, and say which it cannot see.

    Hidden is a pixel whose cell of the other image is covered by a reading that is nearer to that
    camera by more than `nearer_m + nearer_per_square_m * z^2`.

    Args:
        depth_m: [H, W] metres, above 0 everywhere.
        has_reading: [H, W]; pixels without one hide nothing.
        focal_px: (fx, fy) of the depth image.
        principal_px: (cx, cy) of the depth image.
        T_other_depth: [4, 4] the depth camera's frame into the other's.
        other_focal_px: (fx, fy).
        other_principal_px: (cx, cy).
        other_size_px: (width, height).
        cell_px: (width, height) of a cell: how far apart neighbouring depth pixels lie.
        nearer_m: see above.
        nearer_per_square_m: see above, 1/m.
        nearest_m: [rows, columns] scratch, infinity; a cell for every cell_px.
        other_depth_m: [H, W] scratch.
        out_px: [2, H, W] column and row in the other image; -2 where it is out of view or hidden.
    """
    height, width = depth_m.shape
    rows, columns = nearest_m.shape
    R, t = T_other_depth[:3, :3], T_other_depth[:3, 3]
    other_width, other_height = other_size_px
    for row in range(height):
        for column in range(width):
            out_px[0, row, column] = out_px[1, row, column] = -2.0
            depth = float(depth_m[row, column])
            x = (column - principal_px[0]) / focal_px[0] * depth
            y = (row - principal_px[1]) / focal_px[1] * depth
            z = R[2, 0] * x + R[2, 1] * y + R[2, 2] * depth + t[2]
            if z <= 0.0:
                continue
            u = (R[0, 0] * x + R[0, 1] * y + R[0, 2] * depth + t[0]) / z
            v = (R[1, 0] * x + R[1, 1] * y + R[1, 2] * depth + t[1]) / z
            u = u * other_focal_px[0] + other_principal_px[0]
            v = v * other_focal_px[1] + other_principal_px[1]
            if not (-0.5 <= u < other_width - 0.5 and -0.5 <= v < other_height - 0.5):
                continue
            out_px[0, row, column] = min(max(u, 0.0), other_width - 1.0)
            out_px[1, row, column] = min(max(v, 0.0), other_height - 1.0)
            other_depth_m[row, column] = z
            if not has_reading[row, column]:
                continue
            middle_i, middle_j = v / cell_px[1], u / cell_px[0]
            reach = 0.5 + SLACK_CELLS
            for i in range(
                max(int(np.ceil(middle_i - reach)), 0),
                min(int(np.floor(middle_i + reach)) + 1, rows),
            ):
                for j in range(
                    max(int(np.ceil(middle_j - reach)), 0),
                    min(int(np.floor(middle_j + reach)) + 1, columns),
                ):
                    nearest_m[i, j] = min(nearest_m[i, j], z)
    for row in range(height):
        for column in range(width):
            if out_px[0, row, column] < 0.0:
                continue
            z = other_depth_m[row, column]
            i = min(int(out_px[1, row, column] / cell_px[1] + 0.5), rows - 1)
            j = min(int(out_px[0, row, column] / cell_px[0] + 0.5), columns - 1)
            if z - nearest_m[i, j] > nearer_m + nearer_per_square_m * z * z:
                out_px[0, row, column] = out_px[1, row, column] = -2.0
