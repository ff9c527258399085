"""What a depth image shows, with up and down: heights, the overview, the floor, the room."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at, slope_at


@njit(nogil=True)
def floor_margin(depth_m: float, above_camera_m: float, margin_m: float, noise_2: Law) -> float:
    """How high a reading of the floor may seem to be: two standard deviations of the noise more
    than `margin_m`.

    The noise, whose law for two of them is `noise_2`, lies along the ray, so that it moves a point
    up by the share of the ray's own descent, which is that of `above_camera_m` (less than zero) in
    the depth.
    """
    return margin_m + slope_at(depth_m, noise_2) * abs(above_camera_m)


@njit(cache=True, nogil=True)
def to_points(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    out_points_camera: NDArray[np.float32],
) -> None:
    """[h, w, 3] metres of a depth image [h, w], zeros where there is no reading."""
    height, width = depth_m.shape
    across = np.empty(width, np.float32)
    for column in range(width):
        off_px = np.float32(column) - np.float32(principal_px[0])
        across[column] = off_px / np.float32(focal_px[0])
    for row in range(height):
        off_px = np.float32(row) - np.float32(principal_px[1])
        down = off_px / np.float32(focal_px[1])
        for column in range(width):
            z = depth_m[row, column]
            out_points_camera[row, column, 0] = z * across[column]
            out_points_camera[row, column, 1] = z * down
            out_points_camera[row, column, 2] = z


@njit(cache=True, nogil=True)
def set_up(
    points_camera: NDArray[np.float32],
    is_background: NDArray[np.bool_],
    axes_camera: NDArray[np.float32],
    camera_height_m: float,
    margin_m: float,
    noise_2: Law,
    jump: Law,
    out_heights_m: NDArray[np.float32],
    out_overview_m: NDArray[np.float32],
    out_is_free_standing: NDArray[np.bool_],
    out_is_inner: NDArray[np.uint8],
) -> None:
    """Heights and overview of a cloud, what of it stands free, and what of that has no depth edge.

    Args:
        points_camera: [h, w, 3] metres, zeros where there is no reading.
        is_background: [h, w].
        axes_camera: [3, 3] to the right, forward, and up.
        camera_height_m: what is added to the heights.
        margin_m: see `floor_margin`; -inf where there is no floor.
        noise_2: see `floor_margin`.
        jump: an edge is where the depth differs from the left or the upper neighbour's by more than
            this law says.
        out_heights_m: [h, w] along up.
        out_overview_m: [h, w, 2] right and forward.
        out_is_free_standing: [h, w] has a reading and is neither background nor floor.
        out_is_inner: [h, w] 1 where it stands free and there is no edge.
    """
    height, width = is_background.shape
    for row in range(height):
        for column in range(width):
            x, y, z = points_camera[row, column]
            for axis in range(2):
                right_or_forward = axes_camera[axis]
                out_overview_m[row, column, axis] = (
                    x * right_or_forward[0] + y * right_or_forward[1] + z * right_or_forward[2]
                )
            up = axes_camera[2]
            above_camera_m = x * up[0] + y * up[1] + z * up[2]
            height_m = above_camera_m + np.float32(camera_height_m)
            out_heights_m[row, column] = height_m
            is_free_standing = z > 0.0 and not is_background[row, column]
            if is_free_standing:
                is_free_standing = height_m > floor_margin(z, above_camera_m, margin_m, noise_2)
            jump_m = law_at(z, jump)
            left_m = points_camera[row, max(column - 1, 0), 2]
            above_m = points_camera[max(row - 1, 0), column, 2]
            out_is_free_standing[row, column] = is_free_standing
            out_is_inner[row, column] = (
                is_free_standing & (abs(z - left_m) <= jump_m) & (abs(z - above_m) <= jump_m)
            )


@njit(cache=True, nogil=True)
def find_cores(
    inset_px: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    is_allowed: NDArray[np.bool_],
    focal_px: float,
    core_inset_m: float,
    out_inset_m: NDArray[np.float32],
    out_start_m: NDArray[np.float32],
) -> float:
    """How far each pixel is from what surrounds its surface, in metres; which are further than
    `core_inset_m`, the cores; and what area those have, in square metres.

    Args:
        inset_px: [h, w] the same in pixels, 0 where not allowed.
        depth_m: [h, w].
        is_allowed: [h, w].
        focal_px: of the depth image.
        core_inset_m: see above.
        out_inset_m: [h, w].
        out_start_m: [h, w] 0 in cores, infinity where allowed, minus infinity elsewhere, as
            `topview.kernels.segmentation.geodesic_distance` takes it.
    """
    height, width = depth_m.shape
    # Without an edge it is all but infinite.
    most_px = np.float32(max(height, width))
    area_m2 = 0.0
    for row in range(height):
        for column in range(width):
            pixel_m = depth_m[row, column] / np.float32(focal_px)
            inset_m = min(inset_px[row, column], most_px) * pixel_m
            out_inset_m[row, column] = inset_m
            out_start_m[row, column] = np.inf if is_allowed[row, column] else -np.inf
            if inset_m > core_inset_m:
                out_start_m[row, column] = 0.0
                area_m2 += pixel_m * pixel_m
    return area_m2


@njit(nogil=True)
def _in_double(points: NDArray[np.float32], n: int) -> tuple[float, float, float]:
    return np.float64(points[n, 0]), np.float64(points[n, 1]), np.float64(points[n, 2])


@njit(cache=True, nogil=True)
def plane_moments(
    points_camera: NDArray[np.float32],
    normal_camera: NDArray[np.float64],
    distance_m: float,
    tolerance: Law,
    out_mean: NDArray[np.float64],
    out_covariance: NDArray[np.float64],
) -> int:
    """How many points lie near a plane, their mean and their covariance, weighted by 1 / z^2.

    Args:
        points_camera: [N, 3] metres; those with z = 0 do not count.
        normal_camera: [3] the plane's unit normal.
        distance_m: points p of the plane have normal @ p + distance = 0.
        tolerance: how far from it is near.
        out_mean: [3], left alone where there are no points, as is
        out_covariance: [3, 3].
    """
    near = np.empty(points_camera.shape[0], np.int64)
    count = 0
    total, mean_x, mean_y, mean_z = 0.0, 0.0, 0.0, 0.0
    for n in range(points_camera.shape[0]):
        x, y, z = _in_double(points_camera, n)
        off_m = x * normal_camera[0] + y * normal_camera[1] + z * normal_camera[2] + distance_m
        if z > 0.0 and abs(off_m) < law_at(z, tolerance):
            near[count] = n
            count += 1
            weight = 1.0 / (z * z)
            total += weight
            mean_x += weight * x
            mean_y += weight * y
            mean_z += weight * z
    if count == 0:
        return 0
    mean_x, mean_y, mean_z = mean_x / total, mean_y / total, mean_z / total
    xx, xy, xz, yy, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        x, y, z = _in_double(points_camera, near[k])
        weight = 1.0 / (z * z)
        x, y, z = x - mean_x, y - mean_y, z - mean_z
        xx += weight * x * x
        xy += weight * x * y
        xz += weight * x * z
        yy += weight * y * y
        yz += weight * y * z
        zz += weight * z * z
    out_mean[0], out_mean[1], out_mean[2] = mean_x, mean_y, mean_z
    out_covariance[0, 0], out_covariance[1, 1], out_covariance[2, 2] = xx, yy, zz
    out_covariance[0, 1] = out_covariance[1, 0] = xy
    out_covariance[0, 2] = out_covariance[2, 0] = xz
    out_covariance[1, 2] = out_covariance[2, 1] = yz
    for i in range(3):
        for j in range(3):
            out_covariance[i, j] /= total
    return count


@njit(cache=True, nogil=True)
def learn_background(
    depth_m: NDArray[np.float32],
    is_somebodys: NDArray[np.bool_],
    share: float,
    elapsed_s: float,
    tolerance: Law,
    out_mean_m: NDArray[np.float32],
    out_steady_s: NDArray[np.float32],
) -> None:
    """Where a frame shows nobody, blend a steady depth into the mean, and start again with one
    that is further away; nearer ones hide the room.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        is_somebodys: [h, w].
        share: of the new depth in the mean.
        elapsed_s: since the last frame.
        tolerance: steady is what differs by less.
        out_mean_m: [h, w] so far, updated.
        out_steady_s: [h, w] for how long it has been steady, updated.
    """
    height, width = depth_m.shape
    for row in range(height):
        for column in range(width):
            z = depth_m[row, column]
            if z == 0.0 or is_somebodys[row, column]:
                continue
            ahead_m = out_mean_m[row, column] - z
            tolerance_m = law_at(z, tolerance)
            if ahead_m < -tolerance_m:
                out_mean_m[row, column] = z
                out_steady_s[row, column] = np.float32(0.0)
            elif ahead_m < tolerance_m:
                out_mean_m[row, column] -= np.float32(share) * ahead_m
                out_steady_s[row, column] += np.float32(elapsed_s)


@njit(cache=True, nogil=True)
def changed_share(
    is_own: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    mean_m: NDArray[np.float32],
    steady_s: NDArray[np.float32],
    since_s: float,
    tolerance: Law,
) -> float:
    """Share of a thing's pixels [h, w] whose depth has not been the same for `since_s`; 1 of none.

    The other arguments are those of `learn_background`, which has learnt from this depth.
    """
    own, changed = 0, 0
    for row in range(is_own.shape[0]):
        for column in range(is_own.shape[1]):
            if not is_own[row, column]:
                continue
            z = depth_m[row, column]
            is_there = z > mean_m[row, column] - law_at(z, tolerance)
            own += 1
            changed += not is_there or steady_s[row, column] < np.float32(since_s)
    return changed / own if own else 1.0


@njit(cache=True, nogil=True)
def shows_background(
    depth_m: NDArray[np.float32],
    mean_m: NDArray[np.float32],
    steady_s: NDArray[np.float32],
    known_s: float,
    tolerance: Law,
    out_is_seen: NDArray[np.bool_],
) -> None:
    """[h, w] where the background is known and what is seen is no nearer than it; the arguments
    are those of `learn_background`."""
    height, width = depth_m.shape
    for row in range(height):
        for column in range(width):
            z = depth_m[row, column]
            out_is_seen[row, column] = (steady_s[row, column] >= np.float32(known_s)) & (
                z > mean_m[row, column] - law_at(z, tolerance)
            )
