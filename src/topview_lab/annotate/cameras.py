"""Pose and delay of the rear camera relative to the front camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares

from topview.geometry.rotations import rotations_from_vectors, transform, vectors_from_rotations
from topview.records import InputError
from topview.room.floor import FloorPlane
from topview_lab.annotate.landmarks import BACK, DEPTHS, FRONT, NAMES
from topview_lab.annotate.starting import similarity
from topview_lab.annotate.tracks import NO_SPOT, J, Tracks, View, transform_points, trunk_axes

LEAST_LIKENESS: Final = 0.4
"""Correlation of the two views' motion below which they cannot be aligned (ours)."""
MOST_OFFSET_S: Final = 4.0
SPEED_SMOOTHING_S: Final = 0.05
"""Width of the filter over joint speeds (ours)."""
LEAST_SPEED_MPS: Final = 0.3
"""Least speed of the fastest joint; below it nobody moves and the views cannot be aligned."""


def time_offset_frames(
    front: Tracks, rear: Tracks, floors: Sequence[FloorPlane | None], fps: float
) -> int:
    """Delay of the rear recording in frames, by correlating the vertical speeds of the joints, or
    their speeds where no floor is seen. Both are independent of the viewpoint.

    Raises:
        InputError: nobody moves, or the motions are not alike at any offset.
    """
    a, b = _motion(front, floors[0], fps), _motion(rear, floors[1], fps)
    if floors[0] is None or floors[1] is None:
        a, b = _motion(front, None, fps), _motion(rear, None, fps)
    fastest = min(float(np.percentile(np.nan_to_num(np.abs(x)).max(-1), 95)) for x in (a, b))
    if fastest < LEAST_SPEED_MPS:
        raise InputError(
            f"the time between the cameras cannot be told: no joint moves faster than "
            f"{fastest:.2f} m/s; give --offset SECONDS, or record a wave of the hand"
        )
    reach = min(int(MOST_OFFSET_S * fps), len(a) // 2, len(b) // 2)
    likeness = {shift: _likeness(a, b, shift) for shift in range(-reach, reach + 1)}
    best = max(likeness, key=lambda shift: (likeness[shift], -abs(shift)))
    if likeness[best] < LEAST_LIKENESS:
        raise InputError(
            f"the time between the cameras cannot be told: their motions are alike to "
            f"{likeness[best]:.2f} at best, at {best / fps:+.2f} s; they must show the same motion "
            f"(at least {LEAST_LIKENESS:g}), or give --offset SECONDS"
        )
    return best


def remaining_offset_frames(points: NDArray[np.float64], fps: float) -> int:
    """Remaining delay of the rear view in frames, estimated from the markers' velocity vectors.

    Args:
        points: [2, F, P, J, 2, 3] markers in front and rear view, in the front camera's frame, NaN
            where unseen.
        fps: frames per second.
    """
    reach = max(round(VELOCITY_STEP_S * fps), 1)
    ahead, behind = np.roll(points, -reach, 1), np.roll(points, reach, 1)
    speeds = (ahead - behind) / (2 * reach) * fps
    speeds[:, :reach] = speeds[:, -reach:] = np.nan
    speeds[np.linalg.norm(np.nan_to_num(speeds), axis=-1) > MOST_SPEED_MPS] = np.nan
    sides = [(a, b) for a in (FRONT, BACK) for b in (FRONT, BACK)]
    front = np.stack([speeds[0][..., a, :] for a, _ in sides], 1).reshape(points.shape[1], -1)
    rear = np.stack([speeds[1][..., b, :] for _, b in sides], 1).reshape(points.shape[1], -1)
    near = range(-NEAR_FRAMES, NEAR_FRAMES + 1)
    return max(near, key=lambda shift: (_likeness(front, rear, shift), -abs(shift)))


NEAR_FRAMES: Final = 4
VELOCITY_STEP_S: Final = 0.05
"""Half the time over which a marker's velocity is taken (ours)."""


def _motion(tracks: Tracks, floor: FloorPlane | None, fps: float) -> NDArray[np.float64]:
    """[F, P * J] m/s, NaN where a joint is not seen."""
    speeds = _velocities(tracks, fps)
    along = np.linalg.norm(speeds, axis=-1) if floor is None else speeds @ floor.normal_camera
    return along.reshape(len(along), -1)


def _velocities(tracks: Tracks, fps: float) -> NDArray[np.float64]:
    """[F, P, J, 3] m/s, NaN where a joint is not seen or jumps, as after it was lost."""
    places = gaussian_filter1d(tracks.joints_front, SPEED_SMOOTHING_S * fps, axis=0)
    speeds = np.gradient(places, axis=0) * fps
    seen = (tracks.spots[0] != NO_SPOT).any(-1)
    jumps = np.linalg.norm(speeds, axis=-1) > MOST_SPEED_MPS
    return np.where((seen & ~jumps)[..., None], speeds, np.nan)


MOST_SPEED_MPS: Final = 6.0
"""About the speed of a throwing hand (ours)."""


def _likeness(a: NDArray[np.float64], b: NDArray[np.float64], shift: int) -> float:
    """Correlation of a[f] with b[f + shift], where both are known."""
    first, last = max(0, -shift), min(len(a), len(b) - shift)
    x, y = a[first:last], b[first + shift : last + shift]
    known = ~np.isnan(x) & ~np.isnan(y)
    if known.sum() < 0.1 * min(a.size, b.size):
        return 0.0
    x, y = x[known], y[known]
    x, y = x - x.mean(), y - y.mean()
    return float((x * y).sum() / max(np.sqrt((x**2).sum() * (y**2).sum()), 1e-12))


@dataclass(frozen=True, slots=True, eq=False)
class Extrinsics:
    """Pose of the rear camera.

    Attributes:
        T_front_rear: [4, 4].
        residual_m: root mean square of the residuals.
        pairs: number of marker pairs (or board corners) that it is estimated from.
    """

    T_front_rear: NDArray[np.float64]
    residual_m: float
    pairs: int


LEAST_PAIRS: Final = 60
GIRTH_SPREAD: Final = 0.30
"""Relative standard deviation of people's girth (ours)."""
DEPTH_SPREAD: Final = 0.08
"""The same for each joint, beyond the girth of the whole body (ours)."""
FLOOR: Final = 3.0
"""Weight of the floor against all markers: it is a plane through thousands of readings (ours)."""
SIDE_SPREAD: Final = 0.03
"""The same between left and right (ours)."""
KIND: Final = [NAMES.index(name.replace("_r", "_l")) for name in NAMES]
"""[J] index of the joint itself, or of the left one of a pair."""
OTHER_SIDE_WEIGHT: Final = 0.2
"""Weight of two different markers of one joint against one that both cameras see (ours)."""
FULL_RADIUS_SHARE: Final = 0.85
"""A marker whose spot has at least this share of its radius is fully visible (ours)."""
PARTLY_SEEN_WEIGHT: Final = 0.1
"""Weight of a partly visible marker, whose depth is contaminated by the occluder (ours)."""
FACING: Final = np.array([not name.startswith(("shoulder", "elbow", "hand")) for name in NAMES])
"""[J] True for joints whose markers lie in front of and behind them in the trunk's frame."""
RESIDUAL_M: Final = 0.02
MOST_FRAMES: Final = 100


def rough_extrinsics(front: Tracks, rear: Tracks) -> NDArray[np.float64]:
    """[4, 4] T_front_rear that brings the joints of two single-view tracks together; both over the
    same F frames."""
    seen = (front.spots[0] != NO_SPOT).any(-1) & (rear.spots[0] != NO_SPOT).any(-1)
    a, b = rear.joints_front[seen], front.joints_front[seen]
    if len(a) < LEAST_PAIRS:
        raise InputError(
            f"the cameras see {len(a)} joints at the same time; they must see at least "
            f"{LEAST_PAIRS} to be placed by the markers, or use --board"
        )
    weights = np.ones(len(a))
    R, t = np.eye(3), np.zeros(3)
    for _ in range(8):
        R, t = _rigid(a, b, weights)
        off = np.linalg.norm(a @ R.T + t - b, axis=-1)
        weights = 1.0 / (1.0 + (off / (2.0 * RESIDUAL_M)) ** 2)
    return transform(R, t)


def _rigid(
    a: NDArray[np.float64], b: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    R, _, _ = similarity(a, b, weights)
    w = weights / weights.sum()
    return R, w @ b - R @ (w @ a)


def refined_extrinsics(
    views: Sequence[View],
    tracks: Tracks,
    statures_m: NDArray[np.float64],
    floors: Sequence[FloorPlane | None] = (None, None),
) -> Extrinsics:
    """Fit the rear camera's pose and the people's depths at the joints to all visible markers.

    The same marker in both views lies in one place; the front and the back marker of a joint lie a
    depth apart along the direction in which the trunk faces, which is nearly so for trunk and legs
    and not used of arms; both cameras stand on one floor.

    Args:
        views: front and rear.
        tracks: names in both.
        statures_m: of the people.
        floors: as each camera sees it, None where it does not.
    """
    names = tracks.spots
    F, P = names.shape[1:3]
    frames = np.unique(np.linspace(0, F - 1, MOST_FRAMES).astype(int))
    measured = [_marker_points(view, names[v], frames) for v, view in enumerate(views)]
    points, radii = zip(*measured, strict=True)
    full_m = float(np.nanmedian(np.concatenate([r.ravel() for r in radii])))
    fronts = _trunk_fronts(points[0])
    outwards_of = np.nan_to_num(fronts)
    rows = []
    for side_a in (FRONT, BACK):
        for side_b in (FRONT, BACK):
            p, q = points[0][..., side_a, :], points[1][..., side_b, :]
            seen = ~np.isnan(p[..., 0]) & ~np.isnan(q[..., 0])
            if side_a != side_b:
                seen &= FACING & ~np.isnan(fronts[..., :1])
            both = np.argwhere(seen)
            f, k, j = both.T
            sign = np.full(len(both), float(side_b - side_a))
            least = np.minimum(radii[0][f, k, j, side_a], radii[1][f, k, j, side_b])
            weight = np.where(
                sign != 0.0,
                OTHER_SIDE_WEIGHT,
                np.where(least > FULL_RADIUS_SHARE * full_m, 1.0, PARTLY_SEEN_WEIGHT),
            )
            rows.append((p[f, k, j], q[f, k, j], sign, weight, k * J + j, outwards_of[f, k]))
    p, q, sign, weight, joint, outwards = (
        np.concatenate(column) for column in zip(*rows, strict=True)
    )
    if len(p) < LEAST_PAIRS:
        raise InputError(
            f"the cameras see {len(p)} markers of the same joints at the same time; they must see "
            f"at least {LEAST_PAIRS} to be placed by the markers, or use --board"
        )
    T0 = views[1].T_front_view
    depths0 = np.repeat(statures_m, J).reshape(P, J) * DEPTHS

    def residuals(x: NDArray[np.float64]) -> NDArray[np.float64]:
        T = pose(x)
        girths, shapes, lopsided = np.split(x[6:], [P, P + P * J])
        shapes = (1.0 + shapes.reshape(P, J))[:, KIND] + lopsided.reshape(P, J)
        depths = (depths0 * (1.0 + girths)[:, None] * shapes).ravel()
        off = p - transform_points(T, q) - (sign * depths[joint])[:, None] * outwards
        off[sign != 0.0] = off[sign != 0.0] @ level
        off *= weight[:, None]
        priors = x[6:] / spreads
        return np.concatenate(
            [
                off.ravel(),
                RESIDUAL_M * alike * priors,
                FLOOR * len(p) ** 0.5 * _floors_apart(floors, T),
            ]
        )

    def pose(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return transform(T0[:3, :3] @ rotations_from_vectors(x[:3]), T0[:3, 3] + x[3:6])

    # Markers of one joint need not be level with each other; the floor tells heights better.
    up = np.zeros(3) if None in floors or floors[0] is None else floors[0].normal_camera
    level = np.eye(3) - np.outer(up, up)
    spreads = np.repeat([GIRTH_SPREAD, DEPTH_SPREAD, SIDE_SPREAD], [P, P * J, P * J])
    alike = (len(p) / (P * J)) ** 0.5
    solution = least_squares(
        residuals, np.zeros(6 + P + 2 * P * J), loss="soft_l1", f_scale=RESIDUAL_M, max_nfev=60
    )
    T, x = pose(solution.x), solution.x
    off = residuals(x)[: 3 * len(p)].reshape(-1, 3)
    median = float(np.median(np.linalg.norm(off, axis=-1)))
    return Extrinsics(T, median, len(p))


def _trunk_fronts(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """[F, P, 3] unit vectors in which trunks face, from the front camera's markers [F, P, J, 2, 3]
    alone; NaN where it does not see shoulders or hips, neck and pelvis from one side. (With the
    rear camera's markers, an error of its pose would confirm itself.)"""
    fronts = np.full((*points.shape[:2], 3), np.nan)
    for f, p in np.ndindex(*points.shape[:2]):
        for side in (BACK, FRONT):
            one_side = np.nan_to_num(points[f, p, :, side], nan=0.0)
            missing = np.isnan(points[f, p, :, side, 0])
            if not missing[TRUNK_JOINTS].any():
                fronts[f, p] = trunk_axes(one_side)[:, 2]
    return fronts


TRUNK_JOINTS: Final = [
    NAMES.index(name) for name in ("neck", "pelvis", "shoulder_l", "shoulder_r", "hip_l", "hip_r")
]


def _floors_apart(
    floors: Sequence[FloorPlane | None], T_front_rear: NDArray[np.float64]
) -> NDArray[np.float64]:
    """[4] differences between both cameras' floors: height below the rear camera, and slope over
    3 m, in metres; zeros where a floor is unknown."""
    front, rear = floors
    if front is None or rear is None:
        return np.zeros(4)
    height = front.height_of(T_front_rear[:3, 3]) - rear.distance_m
    slope = T_front_rear[:3, :3] @ rear.normal_camera - front.normal_camera
    return np.array([float(height), *(3.0 * slope)])


def _marker_points(
    view: View, names: NDArray[np.intp], frames: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[F, P, J, 2, 3] in the view's own camera frame and [F, P, J, 2] radii, NaN where unseen."""
    points = np.full((len(frames), *names.shape[1:], 3), np.nan)
    radii = np.full(points.shape[:-1], np.nan)
    for row, f in enumerate(frames):
        seen = names[f] != NO_SPOT
        points[row][seen] = view.blobs[f].points_camera[names[f][seen]]
        radii[row][seen] = view.blobs[f].radii_m[names[f][seen]]
    return points, radii


def difference(T_a: NDArray[np.float64], T_b: NDArray[np.float64]) -> tuple[float, float]:
    """Metres and degrees between two poses of a camera."""
    turn = vectors_from_rotations(T_a[:3, :3].T @ T_b[:3, :3])
    return float(np.linalg.norm(T_a[:3, 3] - T_b[:3, 3])), float(np.degrees(np.linalg.norm(turn)))
