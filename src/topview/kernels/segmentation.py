"""Distances along the visible surface, for the segmentation of people."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at
from topview.kernels.scene import floor_margin


@njit(cache=True, nogil=True)
def geodesic_distance(
    depth_m: NDArray[np.float32],
    focal_px: float,
    jump: Law,
    limit_m: float,
    out_m: NDArray[np.float32],
) -> None:
    """Length of the shortest way over the surface to each pixel, in place.

    Steps go to the 8 neighbours. A step is as long as the two points are apart, and is taken only
    where both are allowed and their depths differ by at most what the law `jump` says of the nearer
    one. Pixels whose distance has become shorter wait in a queue until they have
    told their neighbours; the result does not depend on the order.

    Args:
        depth_m: [h, w] metres.
        focal_px: of the depth image.
        jump: largest step in depth.
        limit_m: longer ways are not followed.
        out_m: [h, w] the cost at which each seed starts, infinity elsewhere, and minus infinity
            where no way may lead; replaced by the distances, infinity where there is no way.
    """
    height, width = depth_m.shape
    size = height * width
    queue = np.empty(size, np.int32)
    is_queued = np.zeros((height, width), np.bool_)
    head, count = 0, 0
    for row in range(height):
        for column in range(width):
            if 0.0 <= out_m[row, column] <= limit_m:
                queue[count] = row * width + column
                is_queued[row, column] = True
                count += 1
            elif out_m[row, column] >= 0.0:
                out_m[row, column] = np.inf
    while count > 0:
        pixel = queue[head]
        head = head + 1 if head + 1 < size else 0
        count -= 1
        row, column = pixel // width, pixel % width
        is_queued[row, column] = False
        z = depth_m[row, column]
        start = out_m[row, column]
        for i in range(max(row - 1, 0), min(row + 2, height)):
            for j in range(max(column - 1, 0), min(column + 2, width)):
                known = out_m[i, j]
                nearer = min(z, depth_m[i, j])
                across = nearer / focal_px
                # Even straight ahead it would be no shorter.
                if start + across >= known:
                    continue
                dz = depth_m[i, j] - z
                if abs(dz) > law_at(float(nearer), jump):
                    continue
                square = across * across * ((i != row) + (j != column))
                way = np.float32(start + np.sqrt(square + dz * dz))
                if way < known and way <= limit_m:
                    out_m[i, j] = way
                    if not is_queued[i, j]:
                        is_queued[i, j] = True
                        tail = head + count
                        queue[tail if tail < size else tail - size] = i * width + j
                        count += 1
    for row in range(height):
        for column in range(width):
            out_m[row, column] = abs(out_m[row, column])


@njit(cache=True, nogil=True)
def seed_body(
    points_camera: NDArray[np.float32],
    overview_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    is_free_standing: NDArray[np.bool_],
    is_bulky: NDArray[np.bool_],
    head_camera: NDArray[np.float32],
    head_overview_m: NDArray[np.float32],
    head_radius_m: float,
    core_radius_m: float,
    bottom_m: float,
    top_m: float,
    torso_reach_m: float,
    out_start_m: NDArray[np.float32],
) -> None:
    """Which pixels may be a body's, and how far those that surely are lie from its head.

    Allowed is what stands free, and is not bulky further aside of the head than `torso_reach_m`,
    seen from above. Sure is what of that lies in a ball about the head, or in the upright cylinder
    under it.

    Args:
        points_camera: [h, w, 3] metres.
        overview_m: [h, w, 2] the same seen from above.
        heights_m: [h, w] along up.
        is_free_standing: [h, w].
        is_bulky: [h, w].
        head_camera: [3] the head's centre.
        head_overview_m: [2] the same seen from above.
        head_radius_m: of the ball.
        core_radius_m: of the cylinder.
        bottom_m: of the cylinder, along up.
        top_m: of the cylinder, along up.
        torso_reach_m: see above.
        out_start_m: [h, w] straight distance from the head where sure, infinity where allowed,
            minus infinity elsewhere.
    """
    height, width = heights_m.shape
    for row in range(height):
        for column in range(width):
            out_start_m[row, column] = -np.inf
            if not is_free_standing[row, column]:
                continue
            right = overview_m[row, column, 0] - head_overview_m[0]
            forward = overview_m[row, column, 1] - head_overview_m[1]
            aside_m = np.sqrt(right * right + forward * forward)
            if is_bulky[row, column] and aside_m >= torso_reach_m:
                continue
            out_start_m[row, column] = np.inf
            x = points_camera[row, column, 0] - head_camera[0]
            y = points_camera[row, column, 1] - head_camera[1]
            z = points_camera[row, column, 2] - head_camera[2]
            from_head_m = np.sqrt(x * x + y * y + z * z)
            is_core = aside_m < core_radius_m and bottom_m < heights_m[row, column] < top_m
            if is_core or from_head_m < head_radius_m:
                out_start_m[row, column] = from_head_m


@njit(cache=True, nogil=True)
def recall_body(
    body_m: NDArray[np.float32],
    last_depth_m: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    faded_m: float,
    jump: Law,
    keeps_seeds: bool,
    out_start_m: NDArray[np.float32],
) -> None:
    """Start also from where a body is known to have been, as long as the depth there has stayed.

    It has where it differs from the last by less than the law `jump` says.

    Args:
        body_m: [h, w] its distances from the head in the last frame, infinity elsewhere.
        last_depth_m: [h, w] the last frame's.
        depth_m: [h, w].
        faded_m: what is added to the distances.
        jump: see above.
        keeps_seeds: whether the seeds (`seed_body`) come before what is remembered; else they are
            forgotten.
        out_start_m: [h, w] as `seed_body` gives it.
    """
    height, width = depth_m.shape
    for row in range(height):
        for column in range(width):
            start_m = out_start_m[row, column]
            if start_m < 0.0 or (keeps_seeds and start_m < np.inf):
                continue
            z = depth_m[row, column]
            off_m = abs(z - last_depth_m[row, column])
            stays = off_m < law_at(z, jump)
            remembered_m = body_m[row, column] + np.float32(faded_m)
            out_start_m[row, column] = remembered_m if stays else np.inf


@njit(cache=True, nogil=True)
def full_pixels_of(
    full_depth_m: NDArray[np.float32],
    small_depth_m: NDArray[np.float32],
    is_users: NDArray[np.bool_],
    stride: int,
    jump: Law,
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    floor: tuple[float, float, float, float],
    margin_m: float,
    noise_2: Law,
) -> NDArray[np.int32]:
    """Flat indices, ascending, of the full pixels that the small pixels of a user stand for.

    A full pixel is the user's if one of the four small pixels around it is, their depths differ by
    less than the law `jump` says of the full pixel's, and it is no floor (`floor_margin`).

    Args:
        full_depth_m: [H, W] metres, 0 where there is no reading.
        small_depth_m: [h, w]; small pixel (i, j) lies at full pixel (i, j) * stride.
        is_users: [h, w].
        stride: full pixels per small pixel.
        jump: see above.
        focal_px: (fx, fy) of the full image.
        principal_px: (cx, cy) of the full image.
        floor: its upward normal and the height of the camera over it.
        margin_m: see `floor_margin`; -inf where there is no floor.
        noise_2: see `floor_margin`.
    """
    full_height, full_width = full_depth_m.shape
    height, width = small_depth_m.shape
    # With a border, so that every pixel has four around it.
    users_depth_m = np.full((height + 1, width + 1), -np.inf, np.float32)
    top, bottom, left, right = height, -1, width, -1
    users = 0
    for i in range(height):
        for j in range(width):
            if is_users[i, j]:
                users_depth_m[i, j] = small_depth_m[i, j]
                top, bottom = min(top, i), i
                left, right = min(left, j), max(right, j)
                users += 1
    pixels = np.empty(4 * users * stride * stride, np.int32)
    count = 0
    up_x, up_y = floor[0] / focal_px[0], floor[1] / focal_px[1]
    for row in range(max((top - 1) * stride, 0), min((bottom + 1) * stride, full_height)):
        i = row // stride
        rise_y = (row - principal_px[1]) * up_y
        for j in range(max(left - 1, 0), right + 1):
            z_0, z_1 = users_depth_m[i, j], users_depth_m[i, j + 1]
            z_2, z_3 = users_depth_m[i + 1, j], users_depth_m[i + 1, j + 1]
            if max(max(z_0, z_1), max(z_2, z_3)) == -np.inf:
                continue
            for column in range(j * stride, min((j + 1) * stride, full_width)):
                z = full_depth_m[row, column]
                off_m = min(min(abs(z_0 - z), abs(z_1 - z)), min(abs(z_2 - z), abs(z_3 - z)))
                above_camera_m = ((column - principal_px[0]) * up_x + rise_y + floor[2]) * z
                least_m = floor_margin(z, above_camera_m, margin_m, noise_2)
                pixels[count] = row * full_width + column
                count += (
                    (z > 0.0) & (off_m < law_at(z, jump)) & (above_camera_m + floor[3] > least_m)
                )
    return pixels[:count].copy()
