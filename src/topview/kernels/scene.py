"""What a depth image shows, with up and down: heights, the overview, the floor, the room."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.noise import Law, law_at, slope_at


@njit(cache=True, nogil=True)
def thin(image: NDArray[np.float32], stride: int, out: NDArray[np.float32]) -> None:
    """[h, w] every `stride`-th pixel of every `stride`-th row of [H, W]."""
    for row in range(out.shape[0]):
        source, target = image[row * stride], out[row]
        # A stride that is known beforehand lets several pixels be copied together.
        if stride == 2:
            for column in range(len(target)):
                target[column] = source[column * 2]
        else:
            for column in range(len(target)):
                target[column] = source[column * stride]


@njit(nogil=True)
def floor_margin(depth_m: float, above_camera_m: float, margin_m: float, noise_2: Law) -> float:
    """How high a reading of the floor may seem to be: two standard deviations of the noise more
    than `margin_m`.

    The noise, whose law for two of them is `noise_2`, lies along the ray, so that it moves a point
    up by the share of the ray's own descent, which is that of `above_camera_m` (less than zero) in
    the depth.
    """
    return margin_m + slope_at(depth_m, noise_2) * abs(above_camera_m)


@njit(nogil=True)
def _slopes(count: int, focal_px: float, principal_px: float) -> NDArray[np.float32]:
    """[count] of the rays through each column or row: metres aside at 1 m."""
    slopes = np.empty(count, np.float32)
    for place in range(count):
        off_px = np.float32(place) - np.float32(principal_px)
        slopes[place] = off_px / np.float32(focal_px)
    return slopes


@njit(cache=True, nogil=True)
def to_points(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    out_points_camera: NDArray[np.float32],
) -> None:
    """[h, w, 3] metres of a depth image [h, w], zeros where there is no reading."""
    height, width = depth_m.shape
    across = _slopes(width, focal_px[0], principal_px[0])
    down = _slopes(height, focal_px[1], principal_px[1])
    for row in range(height):
        for column in range(width):
            z = depth_m[row, column]
            out_points_camera[row, column, 0] = z * across[column]
            out_points_camera[row, column, 1] = z * down[row]
            out_points_camera[row, column, 2] = z


@njit(cache=True, error_model="numpy", nogil=True)
def set_up(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    is_background: NDArray[np.bool_],
    axes_camera: NDArray[np.float32],
    camera_height_m: float,
    margin_m: float,
    noise_2: Law,
    jump: Law,
    out_heights_m: NDArray[np.float32],
    out_plan_m: NDArray[np.float32],
    out_is_free_standing: NDArray[np.bool_],
    out_is_inner: NDArray[np.uint8],
) -> None:
    """Heights and overview of a depth image, what of it stands free, and what of that has no depth
    edge.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        focal_px: (fx, fy).
        principal_px: (cx, cy).
        is_background: [h, w].
        axes_camera: [3, 3] to the right, forward, and up.
        camera_height_m: what is added to the heights.
        margin_m: see `floor_margin`; -inf where there is no floor.
        noise_2: see `floor_margin`.
        jump: an edge is where the depth differs from the left or the upper neighbour's by more than
            this law says.
        out_heights_m: [h, w] along up.
        out_plan_m: [2, h, w] right and forward.
        out_is_free_standing: [h, w] has a reading and is neither background nor floor.
        out_is_inner: [h, w] 1 where it stands free and there is no edge.
    """
    height, width = depth_m.shape
    across = _slopes(width, focal_px[0], principal_px[0])
    down = _slopes(height, focal_px[1], principal_px[1])
    right_x, right_y, right_z = axes_camera[0]
    forward_x, forward_y, forward_z = axes_camera[1]
    up_x, up_y, up_z = axes_camera[2]
    # Row by row without branches, so that several pixels are looked at together.
    for row in range(height):
        seen_m, above_m = depth_m[row], depth_m[max(row - 1, 0)]
        right_m, forward_m, heights_m = out_plan_m[0, row], out_plan_m[1, row], out_heights_m[row]
        is_known, is_free_standing = is_background[row], out_is_free_standing[row]
        is_inner = out_is_inner[row]
        for column in range(width):
            z = seen_m[column]
            x, y = z * across[column], z * down[row]
            right_m[column] = x * right_x + y * right_y + z * right_z
            forward_m[column] = x * forward_x + y * forward_y + z * forward_z
            heights_m[column] = x * up_x + y * up_y + z * up_z
        for column in range(width):
            z, above_camera_m = seen_m[column], heights_m[column]
            height_m = above_camera_m + np.float32(camera_height_m)
            heights_m[column] = height_m
            is_over_floor = height_m > floor_margin(z, above_camera_m, margin_m, noise_2)
            is_free_standing[column] = (z > 0.0) & (not is_known[column]) & is_over_floor
        for column in range(width):
            z = seen_m[column]
            is_even = abs(z - above_m[column]) <= law_at(z, jump)
            is_inner[column] = is_free_standing[column] & is_even
        right_of_first, left_m, is_inner_right = seen_m[1:], seen_m[:-1], is_inner[1:]
        for column in range(width - 1):
            z = right_of_first[column]
            is_inner_right[column] &= abs(z - left_m[column]) <= law_at(z, jump)


@njit(cache=True, nogil=True)
def gather_standing(
    standing_px: NDArray[np.int64],
    plan_m: NDArray[np.float32],
    heights_m: NDArray[np.float32],
    points_camera: NDArray[np.float32],
    is_bulky: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """[7, N] of flat pixels: right, forward and height; x, y and z; and 1 where [h, w] is bulky, or
    else 0. What each of many heads is compared with is so beside each other."""
    right_of, forward_of, height_of = plan_m[0].ravel(), plan_m[1].ravel(), heights_m.ravel()
    point_of, is_bulk = points_camera.reshape(-1, 3), is_bulky.ravel()
    standing = np.empty((7, len(standing_px)), np.float32)
    for k in range(len(standing_px)):
        pixel = np.uint32(standing_px[k])
        standing[0, k], standing[1, k] = right_of[pixel], forward_of[pixel]
        standing[2, k], standing[6, k] = height_of[pixel], is_bulk[pixel]
        for axis in range(3):
            standing[3 + axis, k] = point_of[pixel, axis]
    return standing


@njit(cache=True, error_model="numpy", nogil=True)
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
        has_core = False
        for column in range(width):
            pixel_m = depth_m[row, column] / np.float32(focal_px)
            inset_m = min(inset_px[row, column], most_px) * pixel_m
            out_inset_m[row, column] = inset_m
            start_m = np.float32(np.inf) if is_allowed[row, column] else np.float32(-np.inf)
            is_core = inset_m > core_inset_m
            out_start_m[row, column] = np.float32(0.0) if is_core else start_m
            has_core |= is_core
        for column in range(width if has_core else 0):
            if out_start_m[row, column] == 0.0:
                pixel_m = depth_m[row, column] / np.float32(focal_px)
                area_m2 += pixel_m * pixel_m
    return area_m2


@njit(cache=True, nogil=True)
def plane_moments(
    points_camera: NDArray[np.float32],
    step: int,
    normal_camera: NDArray[np.float64],
    distance_m: float,
    tolerance: Law,
    out_mean: NDArray[np.float64],
    out_covariance: NDArray[np.float64],
) -> int:
    """How many points lie near a plane, their mean and their covariance, weighted by 1 / z^2.

    Args:
        points_camera: [h, w, 3] metres; those with z = 0 do not count.
        step: from a row and a column that are looked at to the next.
        normal_camera: [3] the plane's unit normal.
        distance_m: points p of the plane have normal @ p + distance = 0.
        tolerance: how far from it is near.
        out_mean: [3], left alone where there are no points, as is
        out_covariance: [3, 3].
    """
    height, width = points_camera.shape[:2]
    near = np.empty((((height + step - 1) // step) * ((width + step - 1) // step), 3))
    count = 0
    total, mean_x, mean_y, mean_z = 0.0, 0.0, 0.0, 0.0
    for row in range(0, height, step):
        for column in range(0, width, step):
            x = np.float64(points_camera[row, column, 0])
            y = np.float64(points_camera[row, column, 1])
            z = np.float64(points_camera[row, column, 2])
            off_m = x * normal_camera[0] + y * normal_camera[1] + z * normal_camera[2] + distance_m
            if z > 0.0 and abs(off_m) < law_at(z, tolerance):
                near[count, 0], near[count, 1], near[count, 2] = x, y, z
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
        x, y, z = near[k, 0], near[k, 1], near[k, 2]
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


@njit(cache=True, error_model="numpy", nogil=True)
def learn_background(
    depth_m: NDArray[np.float32],
    is_somebodys: NDArray[np.bool_],
    share: float,
    elapsed_s: float,
    tolerance: Law,
    out_mean_m: NDArray[np.float32],
    out_steady_s: NDArray[np.float32],
    out_age_s: NDArray[np.float32],
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
        out_steady_s: [h, w] for how long it has been seen steady, updated.
        out_age_s: [h, w] for how long it has been the furthest, hidden or not, updated.
    """
    height, width = depth_m.shape
    for row in range(height):
        for column in range(width):
            z = depth_m[row, column]
            mean_m, steady_s = out_mean_m[row, column], out_steady_s[row, column]
            ahead_m = mean_m - z
            tolerance_m = law_at(z, tolerance)
            is_learnt = (z != 0.0) & (not is_somebodys[row, column])
            is_further = is_learnt & (ahead_m < -tolerance_m)
            is_steady = is_learnt & (ahead_m < tolerance_m)
            blended_m = mean_m - np.float32(share) * ahead_m
            mean_m = blended_m if is_steady else mean_m
            out_mean_m[row, column] = z if is_further else mean_m
            steady_s = steady_s + np.float32(elapsed_s) if is_steady else steady_s
            out_steady_s[row, column] = np.float32(0.0) if is_further else steady_s
            age_s = out_age_s[row, column] + np.float32(elapsed_s)
            out_age_s[row, column] = np.float32(0.0) if is_further else age_s


@njit(cache=True, nogil=True)
def changed_share(
    is_own: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    mean_m: NDArray[np.float32],
    age_s: NDArray[np.float32],
    since_s: float,
    tolerance: Law,
) -> float:
    """Share of a thing's pixels [h, w] whose depth has not been the same for `since_s`, but while
    something hid it; 1 of none.

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
            changed += not is_there or age_s[row, column] < np.float32(since_s)
    return changed / own if own else 1.0


@njit(cache=True, nogil=True)
def moved_share(
    is_own: NDArray[np.bool_],
    depth_m: NDArray[np.float32],
    before_m: NDArray[np.float32],
    tolerance: Law,
    focal_px: float,
    least_m2: float,
) -> float:
    """Share of a thing's area [h, w] where something farther was seen before [h, w]: it has come
    there. Where something nearer was seen, or nothing, it may have been there.

    The area is at least `least_m2`; the same depth is what differs by less than `tolerance`.
    """
    came_m2, stayed_m2 = 0.0, 0.0
    for row in range(is_own.shape[0]):
        for column in range(is_own.shape[1]):
            if not is_own[row, column]:
                continue
            z = depth_m[row, column]
            pixel_m2, farther_m = (z / focal_px) ** 2, before_m[row, column] - z
            tolerance_m = law_at(z, tolerance)
            came_m2 += pixel_m2 if farther_m > tolerance_m else 0.0
            stayed_m2 += pixel_m2 if abs(farther_m) <= tolerance_m else 0.0
    return came_m2 / max(came_m2 + stayed_m2, least_m2)


@njit(cache=True, error_model="numpy", nogil=True)
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


@njit(nogil=True, error_model="numpy")
def _continue_line(
    depth_m: NDArray[np.float32],
    mean_m: NDArray[np.float32],
    is_known: NDArray[np.bool_],
    tolerance: Law,
    last_depth_m: NDArray[np.float32],
    was_somebodys: NDArray[np.bool_],
    baseline_px: int,
    first: int,
    step: int,
    count: int,
    out_is_seen: NDArray[np.bool_],
) -> None:
    """`continues_background` along one line of images that are flat: up to `count` pixels from the
    first one that is not known, `step` apart."""
    last, back = first - step, baseline_px * step
    nearness = 1.0 / mean_m[last]
    slope = (nearness - 1.0 / mean_m[last - 2 * back]) / (2 * baseline_px)
    z = 1.0 / (nearness - slope * baseline_px)
    if not abs(mean_m[last - back] - z) < 0.5 * law_at(z, tolerance):
        return
    for place in range(count):
        here = first + place * step
        if is_known[here]:
            return
        if depth_m[here] > 0.0:
            z = 1.0 / (nearness + slope * (place + 1))
            off = law_at(z, tolerance)
            taken_m = last_depth_m[here] if was_somebodys[here] else np.float32(0.0)
            came_to_light = depth_m[here] > taken_m + off
            out_is_seen[here] |= came_to_light & (abs(depth_m[here] - z) < off)


@njit(cache=True, error_model="numpy", nogil=True)
def continues_background(
    depth_m: NDArray[np.float32],
    mean_m: NDArray[np.float32],
    steady_s: NDArray[np.float32],
    known_s: float,
    tolerance: Law,
    last_depth_m: NDArray[np.float32],
    was_somebodys: NDArray[np.bool_],
    baseline_px: int,
    out_is_seen: NDArray[np.bool_],
) -> None:
    """Add to where the background is seen, [h, w], what is not known, but lies on the plane of what
    is known beside it in its row or column: three places there, `baseline_px` apart, are on one
    line. Along a line of the image the inverse depth of a plane is linear. What is no farther now
    than in the last frame, `last_depth_m` [h, w], where it was somebody's, [h, w], is still theirs.
    The other arguments are those of `shows_background`."""
    height, width = depth_m.shape
    z, mean, seen = depth_m.ravel(), mean_m.ravel(), out_is_seen.ravel()
    last_z, was_owned = last_depth_m.ravel(), was_somebodys.ravel()
    is_known = steady_s >= np.float32(known_s)
    known, is_first = is_known.ravel(), np.empty(width + 2, np.bool_)
    middle, behind = 1 + baseline_px, 1 + 2 * baseline_px
    for row in range(height):
        here, upper = is_known[row], is_known[max(row - 1, 0)]
        lower = is_known[min(row + 1, height - 1)]
        # Without branches, so that several pixels are looked at together.
        before, inside, after = is_first[:-2], is_first[1:-1], is_first[2:]
        is_first[:] = False
        for column in range(width):
            before[column] = here[column]
        for column in range(width):
            after[column] |= here[column]
        for column in range(width):
            is_beside = inside[column] | upper[column] | lower[column]
            inside[column] = is_beside & (not here[column])
        for column in range(width):
            if not inside[column]:
                continue
            first, right, below = row * width + column, width - column, height - row
            for step, room, count in (
                (1, column, right),
                (-1, right - 1, column + 1),
                (width, row, below),
                (-width, below - 1, row + 1),
            ):
                if room < behind or not known[first - step]:
                    continue
                if known[first - middle * step] and known[first - behind * step]:
                    _continue_line(
                        z, mean, known, tolerance, last_z, was_owned, baseline_px,
                        first, step, count, seen,
                    )  # fmt: skip
