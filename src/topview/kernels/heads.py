"""Heads in a depth image: how well a template fits, and what lies about a head's centre."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from topview.kernels.medians import median
from topview.kernels.noise import Law, law_at

# What is seen at a place, compared with the depth that it should have.
HIDDEN, THERE, BEHIND, EMPTY, OUTSIDE = range(5)


@njit(error_model="numpy", nogil=True)
def look_at(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    places_camera: NDArray[np.float64],
    tolerances_m: tuple[float, float, float],
    noise_m: NDArray[np.float64],
) -> NDArray[np.int8]:
    """[N] what a depth image [h, w], 0 where there is no reading, shows in the direction of [3, N]
    points.

    `OUTSIDE`: out of view; `HIDDEN`: something nearer by more than the first of `tolerances_m` is
    in the way; `THERE`: a surface there, or further away by up to the second; `BEHIND`: one further
    away by up to the third; `EMPTY`: nothing that near, or no reading. All three grow by `noise_m`,
    [N].
    """
    before_m, behind_m, far_behind_m = tolerances_m
    height, width = depth_m.shape
    xs, ys, zs = places_camera[0], places_camera[1], places_camera[2]
    pixels, seen_m = np.empty(len(xs), np.int32), np.empty(len(xs), np.float32)
    is_in_view, seen = np.empty(len(xs), np.bool_), np.empty(len(xs), np.int8)
    depth_of = depth_m.ravel()
    # In loops without branches, so that several places are looked at together.
    for n in range(len(xs)):
        per_z = 1.0 / max(zs[n], 1e-9)
        u = xs[n] * per_z * focal_px[0] + principal_px[0] + 0.5
        v = ys[n] * per_z * focal_px[1] + principal_px[1] + 0.5
        is_in_view[n] = (zs[n] > 0.0) & (u >= 0.0) & (u < width) & (v >= 0.0) & (v < height)
        row, column = min(max(v, 0.0), height - 1.0), min(max(u, 0.0), width - 1.0)
        pixels[n] = np.int32(row) * np.int32(width) + np.int32(column)
    for n in range(len(xs)):
        seen_m[n] = depth_of[np.uint32(pixels[n])]
    for n in range(len(xs)):
        further_m = seen_m[n] - zs[n] if seen_m[n] > 0.0 else np.inf
        is_visible = is_in_view[n] & (further_m >= -before_m - noise_m[n])
        is_behind = further_m > behind_m + noise_m[n]
        is_far = further_m > far_behind_m + noise_m[n]
        seen[n] = is_visible * (THERE + is_behind + is_far) + (not is_in_view[n]) * OUTSIDE
    return seen


@njit(error_model="numpy", nogil=True)
def _count(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    centers_camera: NDArray[np.float64],
    up_camera: NDArray[np.float64],
    places_m: NDArray[np.float64],
    tolerances_m: tuple[float, float, float],
    noise: Law,
) -> NDArray[np.int64]:
    """[4, N] how many of the template's places [K, 2] about centres [N, 3], upright along [3], are
    visible, there, behind, and outside of the image; the others are as for `fit_template`."""
    up_x, up_y, up_z = up_camera[0], up_camera[1], up_camera[2]
    across = np.hypot(up_x, up_y)
    right_x, right_y = -up_y / across, up_x / across
    count = len(centers_camera)
    places, noise_m = np.empty((3, len(places_m) * count)), np.empty(len(places_m) * count)
    for k in range(len(places_m)):
        right, up = places_m[k, 0], places_m[k, 1]
        for n in range(count):
            x, y, z = centers_camera[n, 0], centers_camera[n, 1], centers_camera[n, 2]
            places[0, k * count + n] = x + (right * right_x + up * up_x)
            places[1, k * count + n] = y + (right * right_y + up * up_y)
            places[2, k * count + n] = z + up * up_z
            noise_m[k * count + n] = law_at(z, noise)
    seen = look_at(depth_m, focal_px, principal_px, places, tolerances_m, noise_m)
    counts = np.zeros((4, count), np.int64)
    for k in range(len(places_m)):
        for n in range(count):
            shown = seen[k * count + n]
            counts[0, n] += (shown != HIDDEN) & (shown != OUTSIDE)
            counts[1, n] += shown == THERE
            counts[2, n] += shown == BEHIND
            counts[3, n] += shown == OUTSIDE
    return counts


@njit(nogil=True)
def _copy(source: NDArray[np.float64], n: int, out: NDArray[np.float64], k: int) -> None:
    """A row of [N, 3] to one of [K, 3]."""
    for axis in range(3):
        out[k, axis] = source[n, axis]


@njit(cache=True, error_model="numpy", nogil=True)
def fit_template(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    centers_camera: NDArray[np.float64],
    up_camera: NDArray[np.float64],
    inside_m: NDArray[np.float64],
    free_m: NDArray[np.float64],
    shoulders_m: NDArray[np.float64],
    tolerances_m: tuple[float, float, float],
    noise: Law,
    least: float,
    out_evidence: NDArray[np.float64],
) -> None:
    """How well what is seen about centres fits a head, in shares: of the head's disc that is there,
    of what lies in the picture, or of half of it; of the visible space above and beside it that is
    empty; of the visible shoulders and chest that is there; and of these that is not hidden.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        focal_px: (fx, fy).
        principal_px: (cx, cy).
        centers_camera: [N, 3] metres.
        up_camera: [3] unit vector: how the template stands.
        inside_m: [K, 2] places of the template within the head, right of and above the centre.
        free_m: [L, 2] those about it that should be empty.
        shoulders_m: [M, 2] those on the shoulders and the chest.
        tolerances_m: of `look_at`, at no noise.
        noise: by how much they grow with the centre's depth.
        least: where the share that is free, or that times the share inside, is less than this, no
            more is looked at, and all four are zero.
        out_evidence: [4, N] shares: inside, free, shoulders, shoulders seen.
    """
    out_evidence[:] = 0.0
    left, left_camera = np.arange(len(centers_camera)), centers_camera.copy()
    for part, places_m in enumerate((free_m, inside_m, shoulders_m)):
        counts = _count(
            depth_m, focal_px, principal_px, left_camera, up_camera, places_m, tolerances_m, noise
        )
        kept = 0
        for k in range(len(left)):
            n = left[k]
            visible, there, behind, outside = counts[0, k], counts[1, k], counts[2, k], counts[3, k]
            if part == 0:
                out_evidence[1, n] = (visible - there) / max(visible, len(places_m) / 2)
                is_good = out_evidence[1, n] >= least
            elif part == 1:
                out_evidence[0, n] = there / max(len(places_m) - outside, len(places_m) / 2)
                is_good = out_evidence[0, n] * out_evidence[1, n] >= least
            else:
                out_evidence[2, n] = (there + behind) / max(visible, 1)
                out_evidence[3, n] = visible / len(places_m)
                is_good = True
            if is_good:
                left[kept] = n
                _copy(left_camera, k, left_camera, kept)
                kept += 1
            else:
                out_evidence[:, n] = 0.0
        left, left_camera = left[:kept], left_camera[:kept]


@njit(nogil=True)
def _confidence(evidence: NDArray[np.float64], n: int, hidden_shoulders: float) -> float:
    """0..1, of one of [4, N] shares of `fit_template`: all three must hold; hidden shoulders count
    for `hidden_shoulders`."""
    shoulders = evidence[3, n] * evidence[2, n] + (1.0 - evidence[3, n]) * hidden_shoulders
    return evidence[0, n] * evidence[1, n] * shoulders


@njit(cache=True, nogil=True)
def confidences(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    centers_camera: NDArray[np.float64],
    ups_camera: NDArray[np.float64],
    upright: NDArray[np.float64],
    places_m: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    tolerances_m: tuple[float, float, float],
    noise: Law,
    hidden_shoulders: float,
) -> NDArray[np.float64]:
    """[N] that centres [N, 3] are heads, each as it stands best, 0..1; the other arguments are
    those of `find_heads`."""
    count = len(centers_camera)
    evidence, best = np.empty((4, count)), np.zeros(count)
    for t in range(len(ups_camera)):
        fit_template(
            depth_m, focal_px, principal_px, centers_camera, ups_camera[t],
            places_m[0], places_m[1], places_m[2], tolerances_m, noise, 0.0, evidence,
        )  # fmt: skip
        for n in range(count):
            best[n] = max(best[n], upright[t] * _confidence(evidence, n, hidden_shoulders))
    return best


@njit(error_model="numpy", nogil=True)
def _pixel_of(
    shape: tuple[int, int],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    x: float,
    y: float,
    z: float,
) -> tuple[int, int, bool]:
    """Row and column (clipped into the image) of a point, and whether it is in view."""
    height, width = shape
    u = x / max(z, 1e-3) * focal_px[0] + principal_px[0]
    v = y / max(z, 1e-3) * focal_px[1] + principal_px[1]
    is_in_view = -0.5 < u < width - 0.5 and -0.5 < v < height - 0.5
    row = int(np.rint(min(max(v, 0.0), height - 1.0)))
    return row, int(np.rint(min(max(u, 0.0), width - 1.0))), is_in_view


@njit(cache=True, nogil=True)
def unread_shares(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    centers_camera: NDArray[np.float64],
    ups_camera: NDArray[np.float64],
    places_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """[N] shares of the places [K, 2], to the right of and above centres [N, 3] that stand along
    [N, 3], that are in view and where [h, w] a depth image has no reading."""
    shares = np.zeros(len(centers_camera))
    for n in range(len(centers_camera)):
        up_x, up_y, up_z = ups_camera[n]
        across = np.hypot(up_x, up_y)
        for k in range(len(places_m)):
            right, up = places_m[k, 0], places_m[k, 1]
            x = centers_camera[n, 0] + (right * (-up_y / across) + up * up_x)
            y = centers_camera[n, 1] + (right * (up_x / across) + up * up_y)
            z = centers_camera[n, 2] + up * up_z
            row, column, is_seen = _pixel_of(depth_m.shape, focal_px, principal_px, x, y, z)
            shares[n] += is_seen and depth_m[row, column] == 0.0
        shares[n] /= len(places_m)
    return shares


@njit(cache=True, nogil=True)
def covered_share(
    depth_m: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    center_camera: tuple[float, float, float],
    up_camera: tuple[float, float, float],
    places_m: NDArray[np.float64],
    nearer_m: float,
) -> float:
    """Share of the places [K, 2], to the right of and above a centre, that are out of view or
    hidden by something that is nearer than they are by more than `nearer_m`."""
    covered = 0
    up_x, up_y, up_z = up_camera
    across = np.hypot(up_x, up_y)
    for k in range(len(places_m)):
        right, up = places_m[k, 0], places_m[k, 1]
        x = center_camera[0] + right * (-up_y / across) + up * up_x
        y = center_camera[1] + right * (up_x / across) + up * up_y
        z = center_camera[2] + up * up_z
        row, column, is_in_view = _pixel_of(depth_m.shape, focal_px, principal_px, x, y, z)
        seen_m = depth_m[row, column]
        covered += not is_in_view or 0.0 < seen_m < z - nearer_m
    return covered / len(places_m)


@njit(cache=True, error_model="numpy", nogil=True)
def places_of_heads(
    depth_m: NDArray[np.float32],
    points_camera: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    ups_camera: NDArray[np.float64],
    max_depth_m: float,
    step_m: float,
    below_m: float,
    surface_m: float,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """[N, 3] points in the picture, below tops along each of [T, 3] directions, and [N] which
    direction, ascending.

    A top is a point, nearer than `max_depth_m`, whose upper neighbour in the image has no reading
    or is further away by more than `step_m`. What is `below_m` below it counts where the depth
    seen there differs from its own by less than `surface_m`.
    """
    height, width = depth_m.shape
    tops = np.empty(height * width, np.int64)
    is_top = np.empty(width, np.bool_)
    count = 0
    for row in range(1, height):
        seen_m, upper_m = depth_m[row], depth_m[row - 1]
        # Without branches, so that several pixels are looked at together.
        for column in range(width):
            z = seen_m[column]
            is_step = (upper_m[column] == 0.0) | (upper_m[column] > z + np.float32(step_m))
            is_top[column] = (z > 0.0) & (z < max_depth_m) & is_step
        for column in range(width):
            if is_top[column]:
                tops[count] = row * width + column
                count += 1
    places = np.empty((count * len(ups_camera), 3))
    directions = np.empty(count * len(ups_camera), np.int64)
    found = 0
    for t in range(len(ups_camera)):
        for k in range(count):
            row, column = tops[k] // width, tops[k] % width
            for axis in range(3):
                top_m = float(points_camera[row, column, axis])
                places[found, axis] = top_m - below_m * ups_camera[t, axis]
            x, y, z = places[found, 0], places[found, 1], places[found, 2]
            i, j, is_in_view = _pixel_of(depth_m.shape, focal_px, principal_px, x, y, z)
            directions[found] = t
            found += is_in_view and abs(depth_m[i, j] - z) < surface_m
    return places[:found].copy(), directions[:found].copy()


@njit(cache=True, nogil=True)
def below_others(
    centers_camera: NDArray[np.float64],
    up_camera: NDArray[np.float64],
    above_m: tuple[float, float],
    aside_m: float,
    behind_m: float,
) -> NDArray[np.bool_]:
    """[N] which of [N, 3] centres have another above them, by between the two of `above_m`, that
    is less than `aside_m` aside and more than `behind_m` further away from the camera."""
    count = len(centers_camera)
    is_below = np.zeros(count, np.bool_)
    for n in range(count):
        for other in range(count):
            z = centers_camera[other, 2] - centers_camera[n, 2]
            if z <= behind_m:
                continue
            x = centers_camera[other, 0] - centers_camera[n, 0]
            y = centers_camera[other, 1] - centers_camera[n, 1]
            up_m = x * up_camera[0] + y * up_camera[1] + z * up_camera[2]
            aside_square = x * x + y * y + z * z - up_m * up_m
            if above_m[0] < up_m < above_m[1] and aside_square < aside_m * aside_m:
                is_below[n] = True
                break
    return is_below


@njit(cache=True, nogil=True)
def strongest(
    centers_camera: NDArray[np.float64],
    confidence: NDArray[np.float64],
    apart_m: float,
    like_m: float,
    like_share: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The best of [N] candidates, the best of those further than `apart_m` from it, and so on:
    [M, 3] centres and [M] confidence.

    Each centre is the mean of the candidates left within `like_m` whose confidence is more than
    `like_share` of the best one's.
    """
    count = len(confidence)
    is_left = np.ones(count, np.bool_)
    chosen = np.empty(count, np.int64)
    means = np.zeros((count, 3))
    found = 0
    while True:
        best = -1
        for n in range(count):
            if is_left[n] and (best < 0 or confidence[n] > confidence[best]):
                best = n
        if best < 0:
            break
        like = 0
        for n in range(count):
            if not is_left[n]:
                continue
            x = centers_camera[n, 0] - centers_camera[best, 0]
            y = centers_camera[n, 1] - centers_camera[best, 1]
            z = centers_camera[n, 2] - centers_camera[best, 2]
            distance_m = np.sqrt(x * x + y * y + z * z)
            if distance_m < like_m and confidence[n] > like_share * confidence[best]:
                for axis in range(3):
                    means[found, axis] += centers_camera[n, axis]
                like += 1
            is_left[n] = distance_m > apart_m
        for axis in range(3):
            means[found, axis] /= like
        chosen[found] = best
        found += 1
    return means[:found].copy(), confidence[chosen[:found]]


@njit(cache=True, nogil=True)
def find_heads(
    depth_m: NDArray[np.float32],
    points_camera: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    up_camera: NDArray[np.float64],
    ups_camera: NDArray[np.float64],
    upright: NDArray[np.float64],
    tops: tuple[float, float, float, float],
    places_m: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    tolerances_m: tuple[float, float, float],
    noise: Law,
    hidden_shoulders: float,
    least: float,
    unread: float,
    shoulder: tuple[tuple[float, float], float, float],
    like: tuple[float, float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """[M, 3] centres of heads and their [M] confidence; and the same of heads over shoulders and a
    chest without any reading, which do not count.

    Args:
        depth_m: [h, w] metres, 0 where there is no reading.
        points_camera: [h, w, 3].
        focal_px: (fx, fy).
        principal_px: (cx, cy).
        up_camera: [3] away from the floor.
        ups_camera: [T, 3] along which heads may stand.
        upright: [T] how much one that stands so counts.
        tops: `max_depth_m`, `step_m`, `below_m` and `surface_m` of `places_of_heads`.
        places_m: the three of `fit_template`.
        tolerances_m: see there.
        noise: see there.
        hidden_shoulders: see `_confidence`.
        least: confidence.
        unread: share of the shoulders and the chest.
        shoulder: the last three arguments of `below_others`, which are no heads.
        like: those of `strongest`.
    """
    centers, directions = places_of_heads(
        depth_m, points_camera, focal_px, principal_px, ups_camera,
        tops[0], tops[1], tops[2], tops[3],
    )  # fmt: skip
    count = len(centers)
    evidence, first = np.empty((4, count)), 0
    for t in range(len(ups_camera)):
        last = first + np.count_nonzero(directions == t)
        fit_template(
            depth_m, focal_px, principal_px, centers[first:last], ups_camera[t],
            places_m[0], places_m[1], places_m[2], tolerances_m, noise, least,
            evidence[:, first:last],
        )  # fmt: skip
        first = last
    good, lone, lone_ups = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    confidence, alone = np.empty(count + 1), np.empty(count + 1)
    goods, lones = 0, 0
    for n in range(count):
        confidence[goods] = upright[directions[n]] * _confidence(evidence, n, hidden_shoulders)
        if confidence[goods] >= least:
            _copy(centers, n, good, goods)
            goods += 1
        alone[lones] = upright[directions[n]] * evidence[0, n] * evidence[1, n]
        if alone[lones] >= least and evidence[2, n] * evidence[3, n] <= 1.0 - unread:
            _copy(centers, n, lone, lones)
            _copy(ups_camera, directions[n], lone_ups, lones)
            lones += 1
    is_shoulder = below_others(good[:goods], up_camera, shoulder[0], shoulder[1], shoulder[2])
    shares = unread_shares(
        depth_m, focal_px, principal_px, lone[:lones], lone_ups[:lones], places_m[2]
    )
    heads, lone_heads = 0, 0
    for n in range(goods):
        if not is_shoulder[n]:
            _copy(good, n, good, heads)
            confidence[heads] = confidence[n]
            heads += 1
    for n in range(lones):
        if shares[n] >= unread:
            _copy(lone, n, lone, lone_heads)
            alone[lone_heads] = alone[n]
            lone_heads += 1
    found, best = strongest(good[:heads], confidence[:heads], like[0], like[1], like[2])
    found_alone, best_alone = strongest(
        lone[:lone_heads], alone[:lone_heads], like[0], like[1], like[2]
    )
    return found, best, found_alone, best_alone


@njit(nogil=True)
def _window(middle: float, reach: float, size: int) -> tuple[int, int]:
    """The first pixel within reach of `middle`, and the one after the last."""
    start = int(min(max(middle - reach, 0.0), size))
    return start, min(max(int(min(max(middle + reach, -2.0), size)) + 2, start), size)


@njit(cache=True, nogil=True)
def median_about(
    points_camera: NDArray[np.float32],
    focal_px: tuple[float, float],
    principal_px: tuple[float, float],
    center_camera: NDArray[np.float64],
    up_camera: NDArray[np.float64],
    radius_m: float,
    half_height_m: float,
    across_m: float,
    out_median: NDArray[np.float64],
) -> int:
    """How many points lie both in a ball and in an upright cylinder about a centre; and their
    median.

    Args:
        points_camera: [h, w, 3] metres, zeros where there is no reading.
        focal_px: (fx, fy).
        principal_px: (cx, cy).
        center_camera: [3], before the camera.
        up_camera: [3] the cylinder's axis.
        radius_m: of the ball.
        half_height_m: of the cylinder.
        across_m: the cylinder's radius.
        out_median: [3] along each axis, left alone if there are no points.
    """
    away_m = center_camera[2]
    height, width = points_camera.shape[:2]
    u = focal_px[0] * center_camera[0] / away_m + principal_px[0]
    v = focal_px[1] * center_camera[1] / away_m + principal_px[1]
    left, right = _window(u, radius_m * focal_px[0] / away_m + 1.0, width)
    top, bottom = _window(v, radius_m * focal_px[1] / away_m + 1.0, height)
    near = np.empty((3, (bottom - top) * (right - left)))
    count = 0
    for row in range(top, bottom):
        for column in range(left, right):
            if points_camera[row, column, 2] <= 0.0:
                continue
            x = points_camera[row, column, 0] - center_camera[0]
            y = points_camera[row, column, 1] - center_camera[1]
            z = points_camera[row, column, 2] - center_camera[2]
            square = x * x + y * y + z * z
            up_m = x * up_camera[0] + y * up_camera[1] + z * up_camera[2]
            if square >= radius_m * radius_m or abs(up_m) >= half_height_m:
                continue
            x -= up_m * up_camera[0]
            y -= up_m * up_camera[1]
            z -= up_m * up_camera[2]
            if np.sqrt(x * x + y * y + z * z) < across_m:
                for axis in range(3):
                    near[axis, count] = points_camera[row, column, axis]
                count += 1
    if count > 0:
        for axis in range(3):
            out_median[axis] = median(near[axis, :count])
    return count


@njit(cache=True, nogil=True)
def relief_about(
    depth_m: NDArray[np.float32],
    row: int,
    column: int,
    center_depth_m: float,
    cutoff_m: float,
    out_relief_m: NDArray[np.float32],
) -> None:
    """Depths relative to a centre's about a pixel, cut off at `cutoff_m`, which also stands for no
    reading; the image [h, w] goes on beyond its border as it is there.

    `out_relief_m`: [2 * r + 1, 2 * r + 1].
    """
    height, width = depth_m.shape
    side = out_relief_m.shape[0]
    center, cutoff = np.float32(center_depth_m), np.float32(cutoff_m)
    for i in range(side):
        v = min(max(row + i - side // 2, 0), height - 1)
        for j in range(side):
            z = depth_m[v, min(max(column + j - side // 2, 0), width - 1)]
            relief = min(max(z - center, -cutoff), cutoff)
            out_relief_m[i, j] = relief if z != 0.0 else cutoff


@njit(cache=True, nogil=True)
def lowest(costs: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Flat indices of the `count` lowest of [n, m] costs, lowest first; the first of equals."""
    cost_of, best = costs.ravel(), np.empty(count, np.int64)
    kept = 0
    for index in range(len(cost_of)):
        if kept == count:
            if cost_of[index] >= cost_of[best[count - 1]]:
                continue
            kept -= 1
        place = kept
        while place > 0 and cost_of[best[place - 1]] > cost_of[index]:
            best[place] = best[place - 1]
            place -= 1
        best[place] = index
        kept += 1
    return best[:kept]
