"""Distances along the visible surface, for the segmentation of people."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at

# Below 1 by more than single precision rounds the length of a step and a way to it.
SHORTER = 0.999


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
    queue, count = np.empty(depth_m.size, np.int32), 0
    for row in range(height):
        start_m, starts = out_m[row], 0
        # Without branches, so that several pixels are looked at together.
        for column in range(width):
            starts += (start_m[column] >= 0.0) & (start_m[column] <= limit_m)
            is_far = start_m[column] > limit_m
            start_m[column] = np.float32(np.inf) if is_far else start_m[column]
        for column in range(width if starts else 0):
            queue[count] = row * width + column
            count += (start_m[column] >= 0.0) & (start_m[column] <= limit_m)
    _spread(depth_m, focal_px, jump, limit_m, queue, count, out_m)


@njit(error_model="numpy", nogil=True)
def _spread(
    depth_m: NDArray[np.float32],
    focal_px: float,
    jump: Law,
    limit_m: float,
    queue: NDArray[np.int32],
    count: int,
    out_m: NDArray[np.float32],
) -> None:
    """The ways of `geodesic_distance` from the first `count` pixels, flat, of a queue [h * w]."""
    width = depth_m.shape[1]
    size = depth_m.size
    z_of, told, is_queued = depth_m.ravel(), out_m.ravel(), np.zeros(size, np.bool_)
    for k in range(count):
        is_queued[queue[k]] = True
    # Even straight ahead no step is shorter than these times the nearer depth, even if rounded.
    straight = np.float32(SHORTER / focal_px)
    diagonal = np.float32(SHORTER * np.sqrt(2.0) / focal_px)
    head = 0
    while count > 0:
        pixel = np.int64(queue[np.uint32(head)])
        head = head + 1 if head + 1 < size else 0
        count -= 1
        is_queued[pixel] = False
        z, start = z_of[pixel], told[pixel]
        column = pixel % width
        left, right = int(column > 0), int(column < width - 1)
        above = pixel - width if pixel >= width else pixel
        below = pixel + width if pixel + width < size else pixel
        # The pixel itself, which is among them, and at the border is so again, is told nothing.
        for middle in (above, pixel, below):
            for place in (middle - left, middle, middle + right):
                other = np.uint32(place)
                known, nearer = told[other], min(z, z_of[other])
                steps = (middle != pixel) + (place != middle)
                # Most neighbours know a way that is as short, or none may lead over them.
                if start + nearer * (diagonal if steps == 2 else straight) >= known:
                    continue
                dz = z_of[other] - z
                if abs(dz) > law_at(float(nearer), jump):
                    continue
                across = nearer / focal_px
                way = np.float32(start + np.sqrt(across * across * steps + dz * dz))
                if way < known and way <= limit_m:
                    told[other] = way
                    if not is_queued[other]:
                        is_queued[other] = True
                        tail = head + count
                        queue[np.uint32(tail if tail < size else tail - size)] = other
                        count += 1
    for pixel in range(size):
        told[pixel] = abs(told[pixel])  # of what is below 0 only -inf is left


@njit(cache=True, nogil=True)
def grow_body(
    standing_px: NDArray[np.int64],
    standing: NDArray[np.float32],
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
        standing: [7, N] of these: see `topview.kernels.scene.gather_standing`.
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
    head_x, head_y = np.float32(head_camera[0]), np.float32(head_camera[1])
    head_z = np.float32(head_camera[2])
    head_right, head_forward = np.float32(head_overview_m[0]), np.float32(head_overview_m[1])
    rights_m, forwards_m, heights_m = standing[0], standing[1], standing[2]
    xs, ys, zs, is_bulky = standing[3], standing[4], standing[5], standing[6]
    aside_m, start_m = np.empty_like(xs), np.empty_like(xs)
    last_m, last_z = np.empty_like(xs), np.empty_like(xs)
    last_of, last_z_of, out_of = last_body_m.ravel(), last_depth_m.ravel(), out_m.ravel()
    remembered = len(xs) if len(last_of) else 0
    # In short loops without branches, so that several pixels are looked at together.
    for k in range(len(xs)):
        right, forward = rights_m[k] - head_right, forwards_m[k] - head_forward
        aside_m[k] = np.sqrt(right * right + forward * forward)
    for k in range(len(xs)):
        x, y, z = xs[k] - head_x, ys[k] - head_y, zs[k] - head_z
        start_m[k] = np.sqrt(x * x + y * y + z * z)
    for k in range(len(xs)):
        is_core = (aside_m[k] < core[0]) & (core[1] < heights_m[k]) & (heights_m[k] < core[2])
        is_at_head = from_head & (is_core | (start_m[k] < head_radius_m))
        start_m[k] = start_m[k] if is_at_head else np.float32(np.inf)
    for k in range(remembered):
        pixel = np.uint32(standing_px[k])
        last_m[k], last_z[k] = last_of[pixel], last_z_of[pixel]
    for k in range(remembered):
        has_stayed = abs(zs[k] - last_z[k]) < law_at(zs[k], stays)
        remembered_m = last_m[k] + np.float32(faded_m)
        start_m[k] = remembered_m if has_stayed & (start_m[k] == np.inf) else start_m[k]
    for k in range(len(xs)):
        is_allowed = (is_bulky[k] == 0.0) | (aside_m[k] < torso_reach_m)
        unknown_m = np.float32(np.inf) if is_allowed else np.float32(-np.inf)
        start_m[k] = start_m[k] if is_allowed & (start_m[k] <= limit_m) else unknown_m
    queue, count = np.empty(depth_m.size, np.int32), 0
    out_m[:] = -np.inf
    for k in range(len(xs)):
        pixel = np.uint32(standing_px[k])
        out_of[pixel] = start_m[k]
        queue[count] = pixel
        count += abs(start_m[k]) < np.inf
    _spread(depth_m, focal_px, jump, limit_m, queue, count, out_m)


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
    wide_m, rows_m = np.empty((2, most), np.float32), np.empty((stride, most), np.float32)
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
        # Copied first, as what waits for memory then does not wait for what is reckoned of it.
        for row in range(i * stride, min((i + 1) * stride, full_height)):
            far_m, near_m = full_depth_m[row, first:last], rows_m[row - i * stride]
            for n in range(len(far_m)):
                near_m[n] = far_m[n]
        for row in range(i * stride, min((i + 1) * stride, full_height)):
            rise_y = (row - principal_px[1]) * up_y + floor[2]
            seen_m = rows_m[row - i * stride, : last - first]
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
