"""Distances along the visible surface, for the segmentation of people."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at

# Whether ways may lead over a pixel, and whether it waits to tell its neighbours.
FORBIDDEN, ALLOWED, QUEUED = range(3)


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
    queue, state = np.empty(depth_m.size, np.int32), np.empty(depth_m.size, np.uint8)
    count = 0
    for row in range(height):
        for column in range(width):
            pixel, start_m = row * width + column, out_m[row, column]
            state[pixel] = FORBIDDEN if start_m < 0.0 else ALLOWED
            if 0.0 <= start_m <= limit_m:
                if _may_tell(out_m, row, column):
                    queue[count] = pixel
                    count += 1
            else:
                out_m[row, column] = np.inf
    _spread(depth_m, focal_px, jump, limit_m, queue, count, state, out_m)


@njit(nogil=True)
def _may_tell(out_m: NDArray[np.float32], row: int, column: int) -> bool:
    """Whether a seed is nearer than one of its 8 neighbours."""
    height, width = out_m.shape
    farthest_m = out_m[row, column]
    for i in range(max(row - 1, 0), min(row + 2, height)):
        for j in range(max(column - 1, 0), min(column + 2, width)):
            farthest_m = max(farthest_m, out_m[i, j])
    return farthest_m > out_m[row, column]


@njit(error_model="numpy", nogil=True)
def _spread(
    depth_m: NDArray[np.float32],
    focal_px: float,
    jump: Law,
    limit_m: float,
    queue: NDArray[np.int32],
    count: int,
    state: NDArray[np.uint8],
    out_m: NDArray[np.float32],
) -> None:
    """The ways of `geodesic_distance` from the first `count` pixels, flat, of a queue [h * w];
    `state` [h * w] says which pixels are allowed."""
    width = depth_m.shape[1]
    size = depth_m.size
    z_of, told = depth_m.ravel(), out_m.ravel()
    for k in range(count):
        state[queue[k]] = QUEUED
    head = 0
    while count > 0:
        pixel = queue[head]
        head = head + 1 if head + 1 < size else 0
        count -= 1
        state[pixel] = ALLOWED
        z = z_of[pixel]
        start = told[pixel]
        column = pixel % width
        left, right = int(column > 0), int(column < width - 1)
        above = pixel - width if pixel >= width else pixel
        below = pixel + width if pixel + width < size else pixel
        for middle in range(above, below + 1, width):
            for other in range(middle - left, middle + right + 1):
                known = told[other]
                if start >= known or state[other] == FORBIDDEN:
                    continue
                nearer = min(z, z_of[other])
                across = nearer / focal_px
                # Even straight ahead it would be no shorter.
                if start + across >= known:
                    continue
                dz = z_of[other] - z
                if abs(dz) > law_at(float(nearer), jump):
                    continue
                square = across * across * ((middle != pixel) + (other != middle))
                way = np.float32(start + np.sqrt(square + dz * dz))
                if way < known and way <= limit_m:
                    told[other] = way
                    if state[other] != QUEUED:
                        state[other] = QUEUED
                        tail = head + count
                        queue[tail if tail < size else tail - size] = other
                        count += 1


@njit(cache=True, nogil=True)
def grow_body(
    standing_px: NDArray[np.int64],
    points_camera: NDArray[np.float32],
    plan_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    is_bulky: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    focal_px: float,
    jump: Law,
    stays: Law,
    head_camera: tuple[float, float, float],
    head_overview_m: tuple[float, float],
    head_radius_m: float,
    core: tuple[float, float, float],
    torso_reach_m: float,
    limit_m: float,
    last_body_m: NDArray[np.float32],
    last_depth_m: NDArray[np.float32],
    faded_m: float,
    from_head: bool,
    out_m: NDArray[np.float32],
) -> None:
    """How far each pixel is from a head over the visible surface of its body.

    Ways lead over what stands free, and is not bulky further aside of the head than
    `torso_reach_m`, seen from above. They start where of that lies in a ball about the head or in
    the upright cylinder under it, as far from the head as the straight line; and where the body is
    known to have been, as far as then, if the depth has changed by less than the law `stays` says.

    Args:
        standing_px: flat indices of what stands free.
        points_camera: [h, w, 3] metres.
        plan_m: [2, h, w] the same seen from above: right and forward.
        heights_m: [h, w] along up.
        is_bulky: [h, w].
        depth_m: [h, w].
        focal_px: of the depth image.
        jump: see `geodesic_distance`.
        stays: see above.
        head_camera: the head's centre.
        head_overview_m: the same seen from above.
        head_radius_m: of the ball.
        core: of the cylinder: its radius, and where it begins and ends along up.
        torso_reach_m: see above.
        limit_m: longer ways are not followed.
        last_body_m: [h, w] the last frame's distances, infinity elsewhere; [0, 0] for none.
        last_depth_m: [h, w] the last frame's depth.
        faded_m: what is added to the last distances.
        from_head: whether what is at the head and under it comes before what is remembered; else
            it is no start.
        out_m: [h, w] the distances, infinity where there is no way.
    """
    queue, state = np.empty(depth_m.size, np.int32), np.zeros(depth_m.size, np.uint8)
    count = 0
    is_remembered = len(last_body_m) > 0
    head_x, head_y = np.float32(head_camera[0]), np.float32(head_camera[1])
    head_z = np.float32(head_camera[2])
    head_right, head_forward = np.float32(head_overview_m[0]), np.float32(head_overview_m[1])
    point_of = points_camera.reshape(-1, 3)
    right_of, forward_of = plan_m[0].ravel(), plan_m[1].ravel()
    height_of, z_of, is_bulk = heights_m.ravel(), depth_m.ravel(), is_bulky.ravel()
    last_body_of, last_z_of = last_body_m.ravel(), last_depth_m.ravel()
    # Further aside, but for rounding, nothing is in the ball nor the cylinder.
    near_m = max(core[0], head_radius_m + 0.001)
    out_m[:] = np.inf
    out_of = out_m.ravel()
    for k in range(len(standing_px)):
        pixel = int(standing_px[k])
        right, forward = right_of[pixel] - head_right, forward_of[pixel] - head_forward
        aside_m = np.sqrt(right * right + forward * forward)
        if is_bulk[pixel] and aside_m >= torso_reach_m:
            continue
        state[pixel] = ALLOWED
        start_m = np.float32(np.inf)
        if from_head and aside_m < near_m:
            x = point_of[pixel, 0] - head_x
            y = point_of[pixel, 1] - head_y
            z = point_of[pixel, 2] - head_z
            from_head_m = np.sqrt(x * x + y * y + z * z)
            is_core = aside_m < core[0] and core[1] < height_of[pixel] < core[2]
            if is_core or from_head_m < head_radius_m:
                start_m = from_head_m
        if is_remembered and start_m == np.inf and last_body_of[pixel] < np.inf:
            off_m = abs(z_of[pixel] - last_z_of[pixel])
            if off_m < law_at(z_of[pixel], stays):
                start_m = last_body_of[pixel] + np.float32(faded_m)
        if start_m <= limit_m:
            queue[count] = pixel
            count += 1
            out_of[pixel] = start_m
    _spread(depth_m, focal_px, jump, limit_m, queue, count, state, out_m)


@njit(cache=True, nogil=True)
def share_bodies(
    bodies_m: NDArray[np.float32],
    is_persons: NDArray[np.bool_],
    is_tracked: NDArray[np.bool_],
    share_m: float,
    out_is_contested: NDArray[np.bool_],
) -> int:
    """Leave to each body the pixels that are its own: of all the nearest one's, and those that are
    no further by over `share_m`; what any person reaches is no other thing's.

    Args:
        bodies_m: [N, h, w] distance of each pixel from each head, infinity where it is none's;
            replaced by what is left, but for what is contested, which tracked ones keep.
        is_persons: [N].
        is_tracked: [N].
        share_m: see above.
        out_is_contested: [h, w] where several tracked ones are reached.

    Returns:
        How many are contested.
    """
    count, height, width = bodies_m.shape
    contested = 0
    nearest_m = np.empty((2, width), np.float32)
    reached = np.empty(width, np.int32)
    # Row by row without branches, so that several pixels are looked at together.
    for row in range(height):
        nearest_m[:] = np.inf
        reached[:] = 0
        for n in range(count):
            body_m, is_counted = bodies_m[n, row], np.int32(is_tracked[n])
            to_kind_m = nearest_m[int(is_persons[n])]
            for column in range(width):
                to_kind_m[column] = min(to_kind_m[column], body_m[column])
                reached[column] += is_counted & (body_m[column] < np.inf)
        for column in range(width):
            is_persons_own = nearest_m[1, column] < np.inf
            nearest_m[0, column] = -np.inf if is_persons_own else nearest_m[0, column]
            out_is_contested[row, column] = reached[column] > 1
            contested += reached[column] > 1
        for n in range(count):
            body_m, may_keep = bodies_m[n, row], is_tracked[n]
            to_kind_m = nearest_m[int(is_persons[n])]
            for column in range(width):
                is_near = body_m[column] <= to_kind_m[column] + np.float32(share_m)
                is_near |= may_keep & (reached[column] > 1)
                body_m[column] = body_m[column] if is_near else np.float32(np.inf)
    return contested


@njit(cache=True, error_model="numpy", nogil=True)
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
    less than the law `jump` says of the full pixel's, and it is no floor (as in `set_up`).

    Args:
        full_depth_m: [H, W] metres, 0 where there is no reading.
        small_depth_m: [h, w]; small pixel (i, j) lies at full pixel (i, j) * stride.
        is_users: [h, w].
        stride: full pixels per small pixel.
        jump: see above.
        focal_px: (fx, fy) of the full image.
        principal_px: (cx, cy) of the full image.
        floor: its upward normal and the height of the camera over it.
        margin_m: see `set_up`; -inf where there is no floor.
        noise_2: see `set_up`.
    """
    full_height, full_width = full_depth_m.shape
    height, width = small_depth_m.shape
    starts, ends = np.full(height + 1, width), np.full(height + 1, -1)
    top, bottom = height, -1
    for i in range(height):
        for j in range(width):
            if is_users[i, j]:
                starts[i], ends[i] = min(starts[i], j), j
        if ends[i] >= 0:
            top, bottom = min(top, i), i
    if bottom < 0:
        return np.empty(0, np.int32)
    begin = max(starts.min() - 1, 0)
    # A small row of the user's, and the one below it, as broad as the full one; with one small
    # pixel more, so that every full pixel has four around it.
    most = (ends.max() - begin + 2) * stride
    wide_m = np.empty((2, most), np.float32)
    is_its, rises = np.empty(most, np.bool_), np.empty(most)
    up_x, up_y = floor[0] / focal_px[0], floor[1] / focal_px[1]
    for n in range(most):
        rises[n] = (begin * stride + n - principal_px[0]) * up_x
    above = max(top - 1, 0)
    pixels = np.empty((bottom + 1 - above) * stride * most, np.int32)
    count = 0
    _widen(small_depth_m, is_users, above, begin, stride, wide_m)
    for i in range(above, bottom + 1):
        _widen(small_depth_m, is_users, i + 1, begin, stride, wide_m)
        left, right = min(starts[i], starts[i + 1]), max(ends[i], ends[i + 1])
        if right < 0:
            continue
        first, last = max(left - 1, 0) * stride, min((right + 1) * stride, full_width)
        offset = first - begin * stride
        rise_x = rises[offset:]
        upper_m, lower_m = wide_m[i % 2, offset:], wide_m[(i + 1) % 2, offset:]
        upper_right_m, lower_right_m = upper_m[stride:], lower_m[stride:]
        for row in range(i * stride, min((i + 1) * stride, full_height)):
            rise_y = (row - principal_px[1]) * up_y + floor[2]
            seen_m = full_depth_m[row, first:last]
            # Without branches, so that several pixels are looked at together.
            for n in range(len(seen_m)):
                z = seen_m[n]
                off_m = min(
                    min(abs(upper_m[n] - z), abs(upper_right_m[n] - z)),
                    min(abs(lower_m[n] - z), abs(lower_right_m[n] - z)),
                )
                rise = rise_x[n] + rise_y
                least_m = margin_m + law_at(z, noise_2) * abs(rise)
                is_near = (z > 0.0) & (off_m < law_at(z, jump))
                is_its[n] = is_near & (rise * z + floor[3] > least_m)
            for n in range(len(seen_m)):
                pixels[count] = row * full_width + first + n
                count += is_its[n]
    return pixels[:count].copy()


@njit(nogil=True)
def _widen(
    small_depth_m: NDArray[np.float32],
    is_users: NDArray[np.bool_],
    i: int,
    begin: int,
    stride: int,
    out_wide_m: NDArray[np.float32],
) -> None:
    """Fill one of two rows, in turn, with the depths of a small row's pixels, from one on, each
    `stride` times; of those that are not the user's it is minus infinity."""
    height, width = is_users.shape
    wide_m = out_wide_m[i % 2]
    for k in range(len(wide_m) // stride):
        j = begin + k
        value_m = np.float32(-np.inf)
        if i < height and j < width and is_users[i, j]:
            value_m = small_depth_m[i, j]
        for n in range(k * stride, (k + 1) * stride):
            wide_m[n] = value_m
